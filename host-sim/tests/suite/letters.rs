//! Letters of every figure: those that commands draw for a column and for a page, and those that stand in docs/ as they are.

use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{cohold, report};

/// What is hard to read in print is smaller, points.
const LEAST_PT: f64 = 6.0;
const MM_PER_PT: f64 = 25.4 / 72.0;
/// What has no width of its own in millimetres: drawings of how boards are wired are as wide as a page, a picture as a column, mm.
const PAGE_MM: f64 = 180.0;
const COLUMN_MM: f64 = 88.0;

/// What stands between these two.
fn between<'a>(text: &'a str, before: &str, after: &str) -> Option<&'a str> {
    text.split_once(before)?.1.split_once(after).map(|(found, _)| found)
}

/// A number that an element has.
fn attribute(element: &str, name: &str) -> Option<f64> {
    between(element, &format!(" {name}=\""), "\"")?.parse().ok()
}

/// Every size of letters of an SVG, points in print.
fn sizes_pt(svg: &str, usual_mm: f64) -> Vec<f64> {
    let width = between(svg, "viewBox=\"0 0 ", " ").and_then(|width| width.parse::<f64>().ok()).expect("a view box");
    let width_mm = between(svg, " width=\"", "mm\"").and_then(|width| width.parse().ok()).unwrap_or(usual_mm);
    let sizes = svg.split("font-size=\"").skip(1).filter_map(|rest| rest.split('"').next()?.parse::<f64>().ok());
    sizes.map(|size| size * width_mm / width / MM_PER_PT).collect()
}

/// A text of an SVG, and the room that it takes: left, top, right, bottom. Where an SVG does not say how long it is, no letter is wider
/// than this.
fn area(element: &str, usual_size: f64) -> (String, [f64; 4]) {
    const LETTER_EM: f64 = 0.55;
    let words = between(element, ">", "</text>").expect("words").to_owned();
    let [x, y] = ["x", "y"].map(|name| attribute(element, name).expect("a place"));
    let size = attribute(element, "font-size").unwrap_or(usual_size);
    let guess = LETTER_EM * size * words.chars().count() as f64;
    let length = attribute(element, "textLength").unwrap_or(guess);
    let before = match between(element, "text-anchor=\"", "\"") {
        Some("middle") => 0.5 * length,
        Some("end") => length,
        _ => 0.0,
    };
    let (up, down) = (0.72 * size, 0.1 * size);
    let [left, top, right, bottom] = [x - before, y - up, x - before + length, y + down];
    let Some(centre) = between(element, "rotate(-90 ", ")") else { return (words, [left, top, right, bottom]) };
    let (x, y) = centre.split_once(' ').expect("a centre");
    let [x, y] = [x, y].map(|place| place.parse::<f64>().expect("a number"));
    (words, [x + top - y, y + x - right, x + bottom - y, y + x - left])
}

/// Pairs of texts of an SVG that stand on each other, and texts that are cut at its edge.
fn overprint(svg: &str) -> Vec<String> {
    let size = between(svg, "viewBox=\"0 0 ", "\"").expect("a view box");
    let (width, height) = size.split_once(' ').expect("a width and a height");
    let [width, height] = [width, height].map(|length| length.parse::<f64>().expect("a number"));
    let usual_size = attribute(svg.split_once('>').expect("an element").0, "font-size").unwrap_or(f64::NAN);
    let areas: Vec<_> = svg.split("<text").skip(1).map(|element| area(element, usual_size)).collect();
    let mut found = Vec::new();
    for (at, (words, one)) in areas.iter().enumerate() {
        if one[0] < 0.0 || one[1] < 0.0 || one[2] > width || one[3] > height {
            found.push(format!("`{words}` is cut"));
        }
        for (other, two) in &areas[at + 1..] {
            // Places are rounded to a tenth: an index begins where its letter ends.
            let apart = |low: usize, high: usize| one[high] < two[low] + 0.2 || two[high] < one[low] + 0.2;
            if !apart(0, 2) && !apart(1, 3) {
                found.push(format!("`{words}` and `{other}` overlap"));
            }
        }
    }
    found
}

/// The SVGs of a folder and of those in it.
fn drawn(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    let own = files.into_iter().filter(|path| path.extension().is_some_and(|ending| ending == "svg"));
    own.chain(folders.iter().flat_map(|folder| drawn(folder))).collect()
}

/// Of exactly so many figures of a folder every letter, and, unless they are known to meet, no text stands on another.
pub(crate) fn are_readable(folder: &Path, count: usize, apart: bool) {
    let figures = drawn(folder);
    assert_eq!(figures.len(), count, "{}: {figures:?}", folder.display());
    for figure in figures {
        let svg = fs::read_to_string(&figure).expect("a text");
        let name = figure.file_name().expect("a name").to_string_lossy();
        let is_wiring = name.starts_with("assembly-");
        let sizes = sizes_pt(&svg, if is_wiring { PAGE_MM } else { COLUMN_MM });
        let smallest = sizes.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(!sizes.is_empty() && smallest >= LEAST_PT, "{}: {smallest:.2} pt", figure.display());
        // How wide the letters of a drawing are, its viewer's font says; indices stand close to their letters.
        let found = if is_wiring || !apart { Vec::new() } else { overprint(&svg) };
        assert!(found.is_empty(), "{}: {found:#?}", figure.display());
    }
}

/// These commands, each with its figures, as they are or at a width; in a folder of its own.
fn draw(commands: &[(&str, usize)], width: &[&str], apart: bool) {
    for (command, count) in commands {
        let name = command.replace([' ', '='], "-");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("letters").join(width.concat()).join(name);
        let _ = fs::remove_dir_all(&folder);
        let arguments: Vec<&str> = command.split(' ').collect();
        let out = ["--json", "--out", folder.to_str().expect("a name in UTF-8")];
        report(cohold(&[&arguments[..], width, &out].concat()).spawn().expect("cohold runs"));
        are_readable(&folder, *count, apart);
    }
}

/// As they are drawn unless a command is told otherwise, a column wide: powers at the ticks, indices in labels, bands, regions, dots with names, many panels. Those of
/// `accuracy`, which are a page wide, and of `paper reproduce` are read where these commands are tested.
#[test]
fn every_figure_can_be_read_in_a_column() {
    let commands = [
        ("paper", 5),
        ("cooperate --scene matched-line --seconds 1", 1),
        ("stability paper", 1),
        ("stability map --x contact.stiffness_n_per_m=100..5000:8 --y coordination.stiffness_n_per_m=10..5000:8", 1),
        ("stability rendering", 1),
        ("study wave p-plus-d --over object.mass_kg=0.001..1:4:log --seconds 1 --seeds 2", 1),
        ("paper architectures", 1),
        ("accuracy transparency", 1),
    ];
    draw(&commands, &[], true);
}

/// Asked for a column, names of dots of the eight panels of every numerical choice meet; each letter can be read.
#[test]
fn every_numerical_choice_has_letters_in_a_column() {
    draw(&[("accuracy", 8)], &["--width-mm", "88"], false);
}

/// On a page too.
#[test]
fn every_figure_can_be_read_on_a_page() {
    draw(&[("paper", 5), ("stability paper", 1)], &["--width-mm", "180"], true);
}

#[test]
fn every_picture_of_the_docs_can_be_read() {
    are_readable(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs"), 15, true);
}
