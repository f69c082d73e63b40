//! A drawing as SVG, in the colours of the wires, on white.

use std::fmt::Write as _;

use crate::netlist::Symbol;
use crate::sheet::{Anchor, Body, Drawing, half};

/// What the file holds.
pub fn svg(drawing: &Drawing, title: &str) -> String {
    let (width, height) = drawing.size;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
         height=\"{height:.0}\" font-family=\"Ubuntu,'Segoe UI','DejaVu Sans',Arial,sans-serif\" fill=\"#222\">\n\
         <title>{title}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        title = escaped(title)
    );
    for line in &drawing.lines {
        let [(x1, y1), (x2, y2)] = line.ends;
        let _ = writeln!(out, "<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" {}/>", stroke(&line.colour));
    }
    for ((x, y), colour) in &drawing.dots {
        let _ = writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.2\" fill=\"{}\"/>", shade(colour));
    }
    drawing.bodies.iter().for_each(|body| out += &drawn(body));
    for text in &drawing.texts {
        let anchor = match text.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let weight = if text.is_bold() { " font-weight=\"600\"" } else { "" };
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{}\" text-anchor=\"{anchor}\"{weight}>{}</text>",
            text.x,
            text.y,
            text.size,
            escaped(&text.text)
        );
    }
    out + "</svg>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A wire's colour as ink: dark enough on white.
fn shade(colour: &str) -> &'static str {
    match colour.split(',').next().unwrap_or_default() {
        "red" => "#b91c1c",
        "orange" => "#c2570c",
        "yellow" => "#a16207",
        "green" => "#15803d",
        "blue" => "#1d4ed8",
        "violet" => "#7e22ce",
        "brown" => "#78350f",
        "grey" | "white" => "#6b7280",
        "network cable" | "USB cable" => "#0f766e",
        "open" => "#9ca3af",
        _ => "#111",
    }
}

fn stroke(colour: &str) -> String {
    let wide = if colour.contains("mm²") || colour.ends_with("cable") { 2.4 } else { 1.5 };
    let dash = if colour.starts_with("white") { " stroke-dasharray=\"7 3\"" } else { "" };
    format!("stroke=\"{}\" stroke-width=\"{wide}\"{dash}", shade(colour))
}

/// A part: a frame, or its symbol in the middle between two leads.
fn drawn(body: &Body) -> String {
    let [(left, top), (right, bottom)] = body.corners;
    let ink = "fill=\"none\" stroke=\"#222\" stroke-width=\"1.5\"";
    if body.symbol == Symbol::Box {
        let (width, height) = (right - left, bottom - top);
        return format!(
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" rx=\"3\" {ink}/>\n"
        );
    }
    let (x, y, half) = ((left + right) / 2.0, top, half());
    let (a, b) = (x - half, x + half);
    let way = if body.turned { -1.0 } else { 1.0 };
    let frame = format!("M{a:.1} {:.1}H{b:.1}V{:.1}H{a:.1}Z", y - 6.0, y + 6.0);
    let (shape, reach) = match body.symbol {
        Symbol::Resistor => (frame, half),
        Symbol::Fuse => (format!("{frame}M{a:.1} {y:.1}H{b:.1}"), half),
        Symbol::Capacitor => (format!("M{:.1} {:.1}v16M{:.1} {:.1}v16", x - 3.0, y - 8.0, x + 3.0, y - 8.0), 3.0),
        Symbol::Diode => {
            let (back, tip) = (x - 8.0 * way, x + 8.0 * way);
            let (high, low) = (y - 7.0, y + 7.0);
            (format!("M{back:.1} {high:.1}V{low:.1}L{tip:.1} {y:.1}ZM{tip:.1} {high:.1}V{low:.1}"), 8.0)
        }
        Symbol::Clamp => {
            // Its cathode, with bent ends, is its first end.
            let (back, tip) = (x + 8.0 * way, x - 8.0 * way);
            let (high, low) = (y - 7.0, y + 7.0);
            let bar = format!("M{:.1} {:.1}L{tip:.1} {high:.1}V{low:.1}l4 4", tip - 4.0, high - 4.0);
            (format!("M{back:.1} {high:.1}V{low:.1}L{tip:.1} {y:.1}Z{bar}"), 8.0)
        }
        Symbol::Star => {
            return format!(
                "<path d=\"M{left:.1} {y:.1}H{right:.1}\" {ink}/>\n<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"#222\"/>\n"
            );
        }
        // Closed, and opened by what is pressed.
        Symbol::Contact => {
            let (high, low) = (y - 8.0, y + 5.0);
            (
                format!(
                    "M{a:.1} {y:.1}H{:.1}L{:.1} {high:.1}M{:.1} {low:.1}V{y:.1}H{b:.1}M{:.1} {high:.1}V{:.1}",
                    x - 12.0,
                    x + 16.0,
                    x + 12.0,
                    x + 12.0,
                    y
                ),
                half,
            )
        }
        // Open, and closed by what is pressed.
        Symbol::Button => {
            let (hinge, high, rest) = (x - 12.0, y - 9.0, x + 12.0);
            (format!("M{a:.1} {y:.1}H{hinge:.1}L{:.1} {high:.1}M{rest:.1} {y:.1}H{b:.1}", x + 10.0), half)
        }
        Symbol::Wire | Symbol::Box => {
            (format!("M{a:.1} {y:.1}H{b:.1}M{a:.1} {:.1}v8M{b:.1} {:.1}v8", y - 4.0, y - 4.0), half)
        }
    };
    format!("<path d=\"{shape}M{left:.1} {y:.1}H{:.1}M{:.1} {y:.1}H{right:.1}\" {ink}/>\n", x - reach, x + reach)
}
