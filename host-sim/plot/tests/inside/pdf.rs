//! Tests of `src/pdf.rs` from inside: the file taken apart again by what the standard says of it.

use super::*;
use crate::sheet::{Anchor, Dash, Frame, INK};

const ABOUT: &str = "# cohold paper\nkey = 1\n";

fn sheet() -> Sheet {
    let upward = Text {
        at: (20.0, 90.0),
        anchor: Anchor::Middle,
        size: 20.0,
        color: INK,
        upward: true,
        text: "Force (µN)".to_owned(),
    };
    let marks = vec![
        Mark::Line {
            points: vec![(0.0, 1.0), (2.0, 3.125), (4.0, 5.0)],
            color: (255, 0, 51),
            width: 2.6,
            dash: Dash::Dashed,
        },
        Mark::fill(Frame::sized((1.0, 2.0), 2.0, 3.0), INK, 0.25),
        Mark::Disc { at: (50.0, 60.0), radius: 7.0, color: INK },
        Mark::text((100.0, 50.0), Anchor::End, 20.0, INK, "K_T = 10^−3 ≤ Ω"),
        Mark::Text(upward),
    ];
    let (title, caption, data) = ("Title".to_owned(), "What is seen".to_owned(), "panel,series\n1,a\n".to_owned());
    Sheet { width: 160.0, width_mm: 18.0, height: 100.0, title, caption, data, marks }
}

/// Where `wanted` begins in `bytes`, from `from` on.
fn find(bytes: &[u8], wanted: &[u8], from: usize) -> Option<usize> {
    bytes[from..].windows(wanted.len()).position(|here| here == wanted).map(|at| at + from)
}

/// The objects of a file, by the table at its end.
fn objects(file: &[u8]) -> Vec<&[u8]> {
    let text = String::from_utf8_lossy(file);
    let start: usize = text.rsplit("startxref\n").next().unwrap().lines().next().unwrap().parse().unwrap();
    assert!(file[start..].starts_with(b"xref\n0 "));
    let lines =
        file[start..].split(|byte| *byte == b'\n').skip(3).take_while(|line| line.len() > 17 && line[17] == b'n');
    let at = |line: &[u8]| std::str::from_utf8(&line[..10]).unwrap().parse::<usize>().unwrap();
    let objects: Vec<&[u8]> = lines.map(at).map(|at| &file[at..find(file, b"endobj", at).unwrap()]).collect();
    for (number, object) in objects.iter().enumerate() {
        assert!(object.starts_with(format!("{} 0 obj", number + 1).as_bytes()), "{number}");
    }
    objects
}

/// What the stream of an object holds, unpacked.
fn stream(object: &[u8]) -> Option<Vec<u8>> {
    let start = find(object, b"stream\n", 0)? + 7;
    let length = std::str::from_utf8(object).err().map_or(object.len(), |error| error.valid_up_to());
    let head = String::from_utf8_lossy(&object[..length.min(start)]).into_owned();
    let length: usize = head.split("/Length ").nth(1)?.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()?;
    let bytes = &object[start..start + length];
    Some(if head.contains("FlateDecode") {
        miniz_oxide::inflate::decompress_to_vec_zlib(bytes).unwrap()
    } else {
        bytes.to_vec()
    })
}

#[test]
fn a_page_is_as_large_as_in_print_and_holds_every_mark() {
    let file = render(&sheet(), ABOUT).unwrap();
    assert!(file == render(&sheet(), ABOUT).unwrap(), "same figure, same bytes");
    let objects = objects(&file);
    // 18 mm and 11.25 mm in points.
    let page = objects.iter().find(|object| find(object, b"/MediaBox", 0).is_some()).unwrap();
    let page = String::from_utf8_lossy(page);
    assert!(page.contains("/MediaBox [0 0 51.0236") && page.contains(" 31.8897"), "{page}");
    let drawn: Vec<u8> = objects
        .iter()
        .filter_map(|object| stream(object))
        .find(|bytes| bytes.ends_with(b"ET") || find(bytes, b"BT", 0).is_some())
        .unwrap();
    let drawn = String::from_utf8_lossy(&drawn);
    for wanted in [
        "0.31889763 0 0 -0.31889763 0 31.889763 cm",
        "1 0 0.2 RG\n2.6 w\n[12 7] 0 d\n0 1 m\n2 3.13 l\n4 5 l\nS",
        "/O250 gs\n1 2 m\n3 2 l\n3 5 l\n1 5 l\nh\nf",
        "57 60 m\n57 63.87 53.87 67 50 67 c",
        // Upwards: along −y, its letters' tops towards −x.
        "0 -1 -1 0 20 ",
    ] {
        assert!(drawn.contains(wanted), "{wanted}\n{drawn}");
    }
}

/// Who copies text gets the characters back, from left to right, through the map that stands in the file.
#[test]
fn letters_stay_letters() {
    let file = render(&sheet(), ABOUT).unwrap();
    let streams: Vec<Vec<u8>> = objects(&file).iter().filter_map(|object| stream(object)).collect();
    let map = streams.iter().find(|bytes| find(bytes, b"beginbfchar", 0).is_some()).unwrap();
    let map = String::from_utf8_lossy(map);
    let pairs = map.lines().filter_map(|line| line.strip_prefix('<')?.strip_suffix('>')?.split_once("> <"));
    let hex = |digits: &str| u32::from_str_radix(digits, 16).unwrap();
    let letters: BTreeMap<u32, char> = pairs
        .filter(|(glyph, _)| *glyph != "0000")
        .map(|(glyph, letter)| (hex(glyph), char::from_u32(hex(letter)).unwrap()))
        .collect();
    let mut painter = Painter::new().unwrap();
    sheet().marks.iter().for_each(|mark| painter.paint(mark));
    for letter in "KT=10−3≤ΩForce(µN)".chars() {
        let glyph = painter.glyph(letter);
        assert_eq!(letters.get(&u32::from(glyph)), Some(&letter));
        assert!(painter.face.glyph_index(letter).is_some(), "the font has {letter}");
    }
}

/// The embedded part of the font draws each letter as the whole font does.
#[test]
fn embedded_glyphs_are_those_of_the_font() {
    #[derive(Default, PartialEq, Debug)]
    struct Outline(Vec<(char, f32, f32)>);
    impl ttf_parser::OutlineBuilder for Outline {
        fn move_to(&mut self, x: f32, y: f32) {
            self.0.push(('m', x, y));
        }
        fn line_to(&mut self, x: f32, y: f32) {
            self.0.push(('l', x, y));
        }
        fn quad_to(&mut self, bow_x: f32, bow_y: f32, x: f32, y: f32) {
            self.0.extend([('b', bow_x, bow_y), ('q', x, y)]);
        }
        fn curve_to(&mut self, _: f32, _: f32, _: f32, _: f32, x: f32, y: f32) {
            self.0.push(('c', x, y));
        }
        fn close(&mut self) {
            self.0.push(('z', 0.0, 0.0));
        }
    }
    let mut painter = Painter::new().unwrap();
    sheet().marks.iter().for_each(|mark| painter.paint(mark));
    let part = subsetter::subset(UBUNTU_LIGHT, 0, &painter.used).unwrap();
    // What is for PDF only has no table of characters: the outlines stand in `glyf`.
    let raw = ttf_parser::RawFace::parse(&part, 0).unwrap();
    let table = |name: &[u8; 4]| raw.table(ttf_parser::Tag::from_bytes(name)).unwrap();
    let head = ttf_parser::head::Table::parse(table(b"head")).unwrap();
    let count = ttf_parser::maxp::Table::parse(table(b"maxp")).unwrap().number_of_glyphs;
    let places = ttf_parser::loca::Table::parse(count, head.index_to_location_format, table(b"loca")).unwrap();
    let glyphs = ttf_parser::glyf::Table::parse(places, table(b"glyf")).unwrap();
    for (glyph, letter) in &painter.letters {
        let (mut ours, mut whole) = (Outline::default(), Outline::default());
        glyphs.outline(ttf_parser::GlyphId(*glyph), &mut ours);
        painter.face.outline_glyph(painter.face.glyph_index(*letter).unwrap(), &mut whole);
        assert!(ours == whole && !ours.0.is_empty(), "{letter}");
    }
}

#[test]
fn data_and_what_made_it_are_attached() {
    let file = render(&sheet(), ABOUT).unwrap();
    let streams: Vec<Vec<u8>> = objects(&file).iter().filter_map(|object| stream(object)).collect();
    assert!(streams.contains(&sheet().data.into_bytes()) && streams.contains(&ABOUT.as_bytes().to_vec()));
    let text = String::from_utf8_lossy(&file).into_owned();
    assert!(
        text.contains("/Names [(data.csv) ") && text.contains("(made.toml) ") && text.contains("/Title (Title)"),
        "{text}"
    );
    let bare = render(&Sheet { data: String::new(), ..sheet() }, "").unwrap();
    assert!(!String::from_utf8_lossy(&bare).contains("EmbeddedFiles"));
}
