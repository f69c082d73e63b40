//! Letters of every figure: those that commands draw for a column and for a page, and those that stand in docs/ as they are.

use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{host_sim, report};

/// What is hard to read in print is smaller, points.
const LEAST_PT: f64 = 6.0;
const MM_PER_PT: f64 = 25.4 / 72.0;
/// What has no width of its own in millimetres is printed as wide as a page, mm.
const PAGE_MM: f64 = 180.0;

/// What stands between these two.
fn between<'a>(text: &'a str, before: &str, after: &str) -> Option<&'a str> {
    text.split_once(before)?.1.split_once(after).map(|(found, _)| found)
}

/// Every size of letters of an SVG, points in print.
fn sizes_pt(svg: &str) -> Vec<f64> {
    let width = between(svg, "viewBox=\"0 0 ", " ").and_then(|width| width.parse::<f64>().ok()).expect("a view box");
    let width_mm = between(svg, " width=\"", "mm\"").and_then(|width| width.parse().ok()).unwrap_or(PAGE_MM);
    let sizes = svg.split("font-size=\"").skip(1).filter_map(|rest| rest.split('"').next()?.parse::<f64>().ok());
    sizes.map(|size| size * width_mm / width / MM_PER_PT).collect()
}

/// The SVGs of a folder and of those in it.
fn drawn(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    let own = files.into_iter().filter(|path| path.extension().is_some_and(|ending| ending == "svg"));
    own.chain(folders.iter().flat_map(|folder| drawn(folder))).collect()
}

/// Of exactly so many figures of a folder every letter.
fn are_readable(folder: &Path, count: usize) {
    let figures = drawn(folder);
    assert_eq!(figures.len(), count, "{}: {figures:?}", folder.display());
    for figure in figures {
        let sizes = sizes_pt(&fs::read_to_string(&figure).expect("a text"));
        let smallest = sizes.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(!sizes.is_empty() && smallest >= LEAST_PT, "{}: {smallest:.2} pt", figure.display());
    }
}

/// These commands, each with its figures, at this width; in a folder of its own.
fn draw(commands: &[(&str, usize)], width_mm: &str) {
    for (command, count) in commands {
        let name = command.replace([' ', '='], "-");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("letters").join(width_mm).join(name);
        let _ = fs::remove_dir_all(&folder);
        let arguments: Vec<&str> = command.split(' ').collect();
        let out = ["--json", "--width-mm", width_mm, "--out", folder.to_str().expect("a name in UTF-8")];
        report(host_sim(&[&arguments[..], &out].concat()).spawn().expect("host-sim runs"));
        are_readable(&folder, *count);
    }
}

/// A column wide: powers at the ticks, indices in labels, bands, regions, dots with names, many panels.
#[test]
fn no_letter_of_a_figure_in_a_column_is_smaller_than_six_points() {
    let commands = [
        ("paper", 5),
        ("reproduce", 8),
        ("cooperate --scene matched-line --seconds 1", 1),
        ("stability paper", 1),
        ("stability map --x contact.stiffness_n_per_m=100..5000:8 --y coordination.stiffness_n_per_m=10..5000:8", 1),
        ("stability rendering", 1),
        ("study wave p-plus-d --over object.mass_kg=0.001..1:4:log --seconds 1 --seeds 2", 1),
        ("compare wave p-plus-d --seconds 1 --seeds 2", 1),
        ("architectures", 1),
        ("accuracy", 9),
        ("accuracy transparency", 1),
    ];
    draw(&commands, "88");
}

#[test]
fn no_letter_of_a_figure_on_a_page_is_smaller_than_six_points() {
    draw(&[("paper", 5), ("stability paper", 1)], "180");
}

#[test]
fn no_letter_of_a_picture_of_the_docs_is_smaller_than_six_points() {
    are_readable(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs"), 11);
}
