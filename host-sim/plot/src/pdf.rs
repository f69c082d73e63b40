//! The PDF painter: the marks of a sheet as a page of its size in print.
//!
//! Letters stay letters: the part of the built-in font that is used is embedded (TrueType, never Type 3, which journals refuse), with
//! the characters that its glyphs stand for. The font is light, so that its outlines are stroked, too. What made the figure and the
//! data that it shows are attached as files: viewers list them. Same figure, same bytes: there is no date in it.

use std::collections::BTreeMap;

use epaint_default_fonts::UBUNTU_LIGHT;
use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{CidFontType, FontFlags, LineJoinStyle, SystemInfo, TextRenderingMode, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use subsetter::GlyphRemapper;
use ttf_parser::Face;

use super::error::Cause;
use super::font;
use super::sheet::{Mark, Point, Rgb, Sheet, Text};

/// Points in a millimetre.
const PT_PER_MM: f64 = 72.0 / 25.4;
/// How strongly glyphs are stroked besides being filled, ems.
const BOLDER: f64 = 0.02;
const FONT: Name = Name(b"F");
const FONT_NAME: Name = Name(b"UBUNTU+Ubuntu-Light");
const SYSTEM: SystemInfo = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

/// The sheet as a PDF file.
pub(crate) fn render(sheet: &Sheet, about: &str) -> Result<Vec<u8>, Cause> {
    let mut painter = Painter::new()?;
    let scale = sheet.width_mm * PT_PER_MM / sheet.width.max(1.0);
    let size = [sheet.width * scale, sheet.height * scale].map(|length| length as f32);
    // Pixels from the top left corner, downwards.
    painter.content.transform([scale as f32, 0.0, 0.0, -scale as f32, 0.0, size[1]]);
    painter.content.set_line_join(LineJoinStyle::RoundJoin);
    sheet.marks.iter().for_each(|mark| painter.paint(mark));

    let mut ids = (1..).map(Ref::new);
    let mut id = || ids.next().unwrap_or(Ref::new(1));
    let (catalog, pages, page, content, font) = (id(), id(), id(), id(), id());
    let mut pdf = Pdf::new();
    pdf.pages(pages).kids([page]).count(1);
    let states: Vec<(String, Ref, f64)> =
        painter.opacities.iter().map(|(name, value)| (name.clone(), id(), *value)).collect();
    {
        let mut page = pdf.page(page);
        page.media_box(Rect::new(0.0, 0.0, size[0], size[1])).parent(pages).contents(content);
        let mut resources = page.resources();
        resources.fonts().pair(FONT, font);
        let mut graphics = resources.ext_g_states();
        for (name, id, _) in &states {
            graphics.pair(Name(name.as_bytes()), *id);
        }
    }
    for (_, id, opacity) in &states {
        pdf.ext_graphics(*id).non_stroking_alpha(*opacity as f32);
    }
    painter.write_font(&mut pdf, font, &mut id)?;
    let packed = compress_to_vec_zlib(&painter.content.finish(), 6);
    pdf.stream(content, &packed).filter(Filter::FlateDecode);

    let files = [("data.csv", sheet.data.as_str()), ("made.toml", about)];
    let files: Vec<(&str, Ref)> = files
        .into_iter()
        .filter(|(_, text)| !text.is_empty())
        .map(|(name, text)| (name, attach(&mut pdf, name, text, &mut id)))
        .collect();
    {
        let mut catalog = pdf.catalog(catalog);
        catalog.pages(pages).lang(TextStr("en"));
        if !files.is_empty() {
            let mut names = catalog.names();
            let mut tree = names.embedded_files();
            let mut entries = tree.names();
            for (name, id) in &files {
                entries.insert(Str(name.as_bytes()), *id);
            }
        }
    }
    pdf.document_info(id()).title(TextStr(&sheet.title)).subject(TextStr(&sheet.caption));
    Ok(pdf.finish())
}

/// A file within the file; returns where it is described.
fn attach(pdf: &mut Pdf, name: &str, text: &str, id: &mut impl FnMut() -> Ref) -> Ref {
    let (stream, described) = (id(), id());
    let packed = compress_to_vec_zlib(text.as_bytes(), 6);
    let mut file = pdf.embedded_file(stream, &packed);
    file.subtype(Name(b"text/plain")).params().size(text.len() as i32);
    file.filter(Filter::FlateDecode);
    file.finish();
    pdf.file_spec(described).path(Str(name.as_bytes())).unic_file(TextStr(name)).embedded_file_with_unicode(stream);
    described
}

struct Painter {
    content: Content,
    face: Face<'static>,
    used: GlyphRemapper,
    /// Characters by their glyph of the embedded font.
    letters: BTreeMap<u16, char>,
    /// Opacities by the name of their state.
    opacities: BTreeMap<String, f64>,
}

impl Painter {
    fn new() -> Result<Self, Cause> {
        let face = Face::parse(UBUNTU_LIGHT, 0)?;
        Ok(Self {
            content: Content::new(),
            face,
            used: GlyphRemapper::new(),
            letters: BTreeMap::new(),
            opacities: BTreeMap::new(),
        })
    }

    fn paint(&mut self, mark: &Mark) {
        match mark {
            Mark::Line { points, color, width, dash } => {
                let [red, green, blue] = rgb(*color);
                self.content.set_stroke_rgb(red, green, blue).set_line_width(short(*width));
                self.content.set_dash_pattern(dash.pattern().iter().map(|length| *length as f32), 0.0);
                self.path(points);
                self.content.stroke();
            }
            Mark::Fill { frame, color, opacity } => self.fill(std::iter::once(frame.corners()), *color, *opacity),
            Mark::Region { strips, color, opacity } => {
                self.fill(strips.iter().map(|corners| corners.to_vec()), *color, *opacity)
            }
            Mark::Disc { at, radius, color } => self.disc(*at, *radius, *color),
            Mark::Text(text) => self.text(text),
        }
    }

    fn path(&mut self, points: &[Point]) {
        for (at, (x, y)) in points.iter().enumerate() {
            if at == 0 {
                self.content.move_to(short(*x), short(*y))
            } else {
                self.content.line_to(short(*x), short(*y))
            };
        }
    }

    /// All pieces as one shape: nothing shines through between them.
    fn fill(&mut self, pieces: impl Iterator<Item = Vec<Point>>, color: Rgb, opacity: f64) {
        self.ink(color, opacity);
        for corners in pieces {
            self.path(&corners);
            self.content.close_path();
        }
        self.content.fill_nonzero();
    }

    fn disc(&mut self, (x, y): Point, radius: f64, color: Rgb) {
        self.ink(color, 1.0);
        // A quarter of a circle as a cubic, to 3e-4 of its radius.
        let bow = 0.552_285 * radius;
        let at = |dx: f64, dy: f64| (short(x + dx), short(y + dy));
        let (start_x, start_y) = at(radius, 0.0);
        self.content.move_to(start_x, start_y);
        for [first, second, end] in [
            [at(radius, bow), at(bow, radius), at(0.0, radius)],
            [at(-bow, radius), at(-radius, bow), at(-radius, 0.0)],
            [at(-radius, -bow), at(-bow, -radius), at(0.0, -radius)],
            [at(bow, -radius), at(radius, -bow), at(radius, 0.0)],
        ] {
            self.content.cubic_to(first.0, first.1, second.0, second.1, end.0, end.1);
        }
        self.content.fill_nonzero();
    }

    /// Colour and opacity of what is filled next.
    fn ink(&mut self, color: Rgb, opacity: f64) {
        let [red, green, blue] = rgb(color);
        let state = format!("O{:.0}", 1000.0 * opacity);
        self.content.set_fill_rgb(red, green, blue).set_parameters(Name(state.as_bytes()));
        self.opacities.insert(state, opacity);
    }

    fn text(&mut self, text: &Text) {
        let (words, width) = font::words(&text.text, text.size);
        let (back, (x, y)) = (text.anchor.back(width), text.at);
        self.ink(text.color, 1.0);
        let [red, green, blue] = rgb(text.color);
        self.content.set_stroke_rgb(red, green, blue).set_dash_pattern([], 0.0);
        self.content.begin_text().set_text_rendering_mode(TextRenderingMode::FillStroke);
        for word in words {
            let along = word.x - back;
            let place = if text.upward {
                [0.0, -1.0, -1.0, 0.0, short(x - word.rise), short(y - along)]
            } else {
                [1.0, 0.0, 0.0, -1.0, short(x + along), short(y - word.rise)]
            };
            let glyphs: Vec<u8> = word.text.chars().flat_map(|letter| self.glyph(letter).to_be_bytes()).collect();
            self.content
                .set_line_width(short(BOLDER * word.size))
                .set_font(FONT, short(word.size))
                .set_text_matrix(place);
            self.content.show(Str(&glyphs));
        }
        self.content.end_text();
    }

    /// A character's glyph in the embedded font; an empty box where the font has none.
    fn glyph(&mut self, letter: char) -> u16 {
        let glyph = self.used.remap(self.face.glyph_index(letter).unwrap_or_default().0);
        self.letters.entry(glyph).or_insert(letter);
        glyph
    }

    /// The font with the glyphs that were used.
    fn write_font(&self, pdf: &mut Pdf, font: Ref, id: &mut impl FnMut() -> Ref) -> Result<(), Cause> {
        let (descendant, described, unicode, data) = (id(), id(), id(), id());
        let ems = |units: i16| f32::from(units) * 1000.0 / f32::from(self.face.units_per_em());
        pdf.type0_font(font)
            .base_font(FONT_NAME)
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(descendant)
            .to_unicode(unicode);
        {
            let mut cid = pdf.cid_font(descendant);
            cid.subtype(CidFontType::Type2).base_font(FONT_NAME).system_info(SYSTEM).font_descriptor(described);
            cid.cid_to_gid_map_predefined(Name(b"Identity"));
            let advance = |glyph| self.face.glyph_hor_advance(ttf_parser::GlyphId(glyph)).unwrap_or(0);
            let widths = self.used.remapped_gids().map(|glyph| ems(advance(glyph).cast_signed()));
            cid.widths().consecutive(0, widths);
        }
        let bounds = self.face.global_bounding_box();
        let (low, high) = ((bounds.x_min, bounds.y_min), (bounds.x_max, bounds.y_max));
        let mut descriptor = pdf.font_descriptor(described);
        descriptor.name(FONT_NAME).flags(FontFlags::SYMBOLIC).italic_angle(0.0).stem_v(70.0);
        descriptor.bbox(Rect::new(ems(low.0), ems(low.1), ems(high.0), ems(high.1)));
        descriptor.ascent(ems(self.face.ascender())).descent(ems(self.face.descender()));
        descriptor.cap_height(ems(self.face.capital_height().unwrap_or(self.face.ascender()))).font_file2(data);
        descriptor.finish();
        let mut map = UnicodeCmap::new(Name(b"Letters"), SYSTEM);
        self.letters.iter().for_each(|(glyph, letter)| map.pair(*glyph, *letter));
        pdf.cmap(unicode, &map.finish());
        let part = subsetter::subset(UBUNTU_LIGHT, 0, &self.used)?;
        let packed = compress_to_vec_zlib(&part, 6);
        let mut stream = pdf.stream(data, &packed);
        stream.filter(Filter::FlateDecode).pair(Name(b"Length1"), part.len() as i32);
        Ok(())
    }
}

fn rgb((red, green, blue): Rgb) -> [f32; 3] {
    [red, green, blue].map(|part| short(f64::from(part) / 255.0))
}

/// The number rounded to a hundredth.
fn short(value: f64) -> f32 {
    ((100.0 * value).round() / 100.0) as f32
}

#[cfg(test)]
#[path = "../tests/inside/pdf.rs"]
mod tests;
