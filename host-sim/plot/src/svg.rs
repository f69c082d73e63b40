//! The SVG painter: the marks of a sheet as text.
//!
//! Positions are written to a tenth of a pixel, paths relative to their last point, so that nine panels of dense lines
//! stay below 300 kB. Letters stay letters (searchable, selectable); `textLength` fits whatever font the viewer has to
//! the widths the layout counted on. Title and caption are there for screen readers, what made the figure and its data for programs.

use std::fmt::Write;

use super::font;
use super::sheet::{Anchor, Mark, PAPER, Point, Rgb, Sheet, Text};

/// The sheet as an SVG document.
pub(crate) fn render(sheet: &Sheet, about: &str) -> String {
    let (width, height, paper) = (sheet.width, sheet.height, hex(PAPER));
    let (width_mm, height_mm) = (sheet.width_mm, sheet.width_mm * height / width);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" width=\"{width_mm}mm\" height=\"{height_mm:.2}mm\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"Ubuntu,'Segoe UI','DejaVu Sans',Arial,sans-serif\">\n\
         <title>{}</title>\n<desc>{}</desc>\n{}<rect width=\"100%\" height=\"100%\" fill=\"{paper}\"/>\n",
        escape(&sheet.title),
        escape(&sheet.caption),
        metadata("made", about) + &metadata("data", &sheet.data),
    );
    for mark in &sheet.marks {
        // Writing to a String cannot fail.
        let _ = match mark {
            Mark::Line { points, color, width, dash } => {
                let pattern = dash.pattern().iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
                let dash = if pattern.is_empty() { pattern } else { format!(" stroke-dasharray=\"{pattern}\"") };
                let (path, color) = (path(points), hex(*color));
                let stroke =
                    format!("fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"");
                writeln!(out, "<path d=\"{path}\" {stroke}{dash}/>")
            }
            Mark::Fill { frame, color, opacity } => writeln!(out, "{}", filled([frame.corners()], *color, *opacity)),
            Mark::Region { strips, color, opacity } => writeln!(out, "{}", filled(strips, *color, *opacity)),
            Mark::Disc { at: (x, y), radius, color } => {
                writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{}\"/>", hex(*color))
            }
            Mark::Text(text) => writeln!(out, "{}", letters(text)),
        };
    }
    out + "</svg>\n"
}

/// A text for programs, line by line; nothing where there is none.
fn metadata(name: &str, text: &str) -> String {
    let lines: Vec<String> = text.lines().map(escape).collect();
    if lines.is_empty() {
        String::new()
    } else {
        format!("<metadata id=\"{name}\">\n{}\n</metadata>\n", lines.join("\n"))
    }
}

/// A text as one element, or as one for each word when it has indices or powers: viewers do not agree on how
/// `textLength` and shifted spans work together.
fn letters(text: &Text) -> String {
    let (mut words, width) = font::words(&text.text, text.size);
    let shifted = words.iter().any(|word| word.rise != 0.0);
    if !shifted {
        words = vec![font::Word { text: text.text.clone(), x: 0.0, width, rise: 0.0, size: text.size }];
    }
    let ((x, y), color) = (text.at, hex(text.color));
    let (anchor, back) = match text.anchor {
        _ if shifted => ("start", text.anchor.back(width)),
        Anchor::Start => ("start", 0.0),
        Anchor::Middle => ("middle", 0.0),
        Anchor::End => ("end", 0.0),
    };
    let turn = if text.upward { format!(" transform=\"rotate(-90 {x:.1} {y:.1})\"") } else { String::new() };
    let element = |word: &font::Word| {
        format!(
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{}\" text-anchor=\"{anchor}\" textLength=\"{:.1}\" \
             lengthAdjust=\"spacingAndGlyphs\" fill=\"{color}\"{turn}>{}</text>",
            x - back + word.x,
            y - word.rise,
            word.size,
            word.width,
            escape(&word.text),
        )
    };
    words.iter().map(element).collect::<Vec<_>>().join("\n")
}

/// An area of these pieces, each with its corners.
fn filled(pieces: impl IntoIterator<Item = impl AsRef<[Point]>>, color: Rgb, opacity: f64) -> String {
    let pieces: String = pieces.into_iter().map(|corners| path(corners.as_ref()) + "z").collect();
    format!("<path d=\"{pieces}\" fill=\"{}\" fill-opacity=\"{opacity}\"/>", hex(color))
}

/// Path data through these points. Differences are taken between rounded positions, so rounding does not add up.
fn path(points: &[Point]) -> String {
    let tenths: Vec<(i64, i64)> =
        points.iter().map(|(x, y)| ((x * 10.0).round() as i64, (y * 10.0).round() as i64)).collect();
    let mut out = String::new();
    if let Some((x, y)) = tenths.first() {
        out += &format!("M{} {}", tenth(*x), tenth(*y));
    }
    for pair in tenths.windows(2).filter(|pair| pair[0] != pair[1]) {
        match (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1) {
            (dx, 0) => out += &format!("h{}", tenth(dx)),
            (0, dy) => out += &format!("v{}", tenth(dy)),
            (dx, dy) if dy < 0 => out += &format!("l{}{}", tenth(dx), tenth(dy)),
            (dx, dy) => out += &format!("l{} {}", tenth(dx), tenth(dy)),
        }
    }
    out
}

/// A number of tenths as a decimal without what SVG does not need: `-0.5` is `-.5`.
fn tenth(tenths: i64) -> String {
    let (sign, whole, part) = (if tenths < 0 { "-" } else { "" }, tenths.abs() / 10, tenths.abs() % 10);
    match (whole, part) {
        (whole, 0) => format!("{sign}{whole}"),
        (0, part) => format!("{sign}.{part}"),
        (whole, part) => format!("{sign}{whole}.{part}"),
    }
}

fn hex((red, green, blue): Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// The text with what XML reserves escaped and what it forbids left out.
fn escape(text: &str) -> String {
    let text: String = text.chars().filter(|c| !c.is_control()).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
#[path = "../tests/inside/svg.rs"]
mod tests;
