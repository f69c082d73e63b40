//! The PNG painter: the marks of a sheet as pixels.
//!
//! A pixel of the sheet is [`DENSITY`] of the picture in each direction, 450 of them an inch: sharp in print and on a screen. The file says how
//! large that is. plotters' bitmap backend fills shapes without smoothing their edges, so all is painted [`SMOOTH`] times larger and averaged down. A
//! line is a filled quadrangle for each segment with a disc at each joint: exact for the zigzags that dense signals become, where joined
//! outlines grow spikes. The built-in font is light: letters are painted twice, a third of a pixel apart.

use plotters::backend::{BitMapBackend, DrawingBackend};
use plotters::style::{FontTransform, RGBAColor, RGBColor, ShapeStyle, TextStyle};

use super::error::Cause;
use super::sheet::{Frame, Mark, PAPER, Point, Rgb, Sheet, Text};
use super::{font, trace};

/// Pixels of the picture for one of the sheet, in each direction.
const DENSITY: u32 = 2;
/// Pixels that are averaged to one of the picture, in each direction.
const SMOOTH: u32 = 2;
/// Pixels that are painted for one of the sheet, in each direction.
const ZOOM: u32 = DENSITY * SMOOTH;

/// The sheet as a PNG file.
pub(crate) fn render(sheet: &Sheet) -> Result<Vec<u8>, Cause> {
    let (width, height) = (sheet.width.max(1.0) as u32, sheet.height.max(1.0) as u32);
    let mut large = vec![PAPER.0; 3 * (width * ZOOM) as usize * (height * ZOOM) as usize];
    let mut painter = Painter(BitMapBackend::with_buffer(&mut large, (width * ZOOM, height * ZOOM)));
    sheet.marks.iter().try_for_each(|mark| painter.paint(mark))?;
    drop(painter);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width * DENSITY, height * DENSITY);
    encoder.set_color(png::ColorType::Rgb);
    let per_metre = (f64::from(width * DENSITY) / sheet.width_mm * 1e3).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit: png::Unit::Meter }));
    let mut writer = encoder.write_header()?;
    let written = writer.write_image_data(&averaged(&large, (width * DENSITY) as usize)).and_then(|()| writer.finish());
    written?;
    Ok(bytes)
}

/// Each pixel the mean of its `SMOOTH` × `SMOOTH` painted ones.
fn averaged(large: &[u8], width: usize) -> Vec<u8> {
    let zoom = SMOOTH as usize;
    let mut out = Vec::with_capacity(large.len() / (zoom * zoom));
    let mut sums = vec![0_u32; 3 * width];
    for block in large.chunks_exact(3 * width * zoom * zoom) {
        sums.fill(0);
        for row in block.chunks_exact(3 * width * zoom) {
            for (sum, pixels) in sums.chunks_exact_mut(3).zip(row.chunks_exact(3 * zoom)) {
                for pixel in pixels.chunks_exact(3) {
                    sum.iter_mut().zip(pixel).for_each(|(s, p)| *s += u32::from(*p));
                }
            }
        }
        out.extend(sums.iter().map(|sum| ((sum + SMOOTH * SMOOTH / 2) / (SMOOTH * SMOOTH)) as u8));
    }
    out
}

struct Painter<'a>(BitMapBackend<'a>);

impl Painter<'_> {
    fn paint(&mut self, mark: &Mark) -> Result<(), Cause> {
        match mark {
            Mark::Line { points, color, width, dash } => {
                let strokes = trace::dashes(points, dash.pattern());
                strokes.iter().try_for_each(|stroke| self.stroke(stroke, *width, &style(*color, 1.0)))
            }
            Mark::Fill { frame, color, opacity } => self.fill(frame, &style(*color, *opacity)),
            Mark::Region { strips, color, opacity } => {
                strips.iter().try_for_each(|corners| self.strip(corners, &style(*color, *opacity)))
            }
            Mark::Disc { at, radius, color } => self.disc(*at, *radius, &style(*color, 1.0)),
            Mark::Text(text) => self.letters(text),
        }
    }

    fn stroke(&mut self, points: &[Point], width: f64, style: &ShapeStyle) -> Result<(), Cause> {
        let half = width / 2.0;
        for pair in points.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            if from.0 == to.0 || from.1 == to.1 {
                let across = if from.0 == to.0 { (half, 0.0) } else { (0.0, half) };
                let (left, right) = (from.0.min(to.0) - across.0, from.0.max(to.0) + across.0);
                let (top, bottom) = (from.1.min(to.1) - across.1, from.1.max(to.1) + across.1);
                self.fill(&Frame { left, top, right, bottom }, style)?;
                continue;
            }
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            let (dx, dy) = ((to.0 - from.0) / length * half, (to.1 - from.1) / length * half);
            let [left, right] =
                [1.0, -1.0].map(|side| [from, to].map(|at| large((at.0 - side * dy, at.1 + side * dx))));
            self.0.fill_polygon([left[0], left[1], right[1], right[0]], style)?;
        }
        // A stroke shorter than it is wide, of a dotted line, has no joint to be seen.
        let length: f64 = points.windows(2).map(|pair| (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1)).sum();
        let joints = if width < 2.0 || length < 1.5 * width {
            &[]
        } else {
            points.get(1..points.len().max(2) - 1).unwrap_or(&[])
        };
        joints.iter().try_for_each(|at| self.disc(*at, half, style))
    }

    fn fill(&mut self, frame: &Frame, style: &ShapeStyle) -> Result<(), Cause> {
        let (left, top) = large((frame.left, frame.top));
        let (right, bottom) = large((frame.right, frame.bottom));
        // The backend excludes the last row and column; a line is at least one pixel wide.
        self.0.draw_rect((left, top), (right.max(left + 1), bottom.max(top + 1)), style, true).map_err(Cause::from)
    }

    /// Column of pixels by column, each by its middle: pieces side by side share none.
    fn strip(&mut self, corners: &[Point; 4], style: &ShapeStyle) -> Result<(), Cause> {
        let zoomed = corners.map(|(x, y)| (x * f64::from(ZOOM), y * f64::from(ZOOM)));
        let [(left, top_left), (right, top_right), (_, bottom_right), (_, bottom_left)] = zoomed;
        for column in (left - 0.5).ceil() as i32..(right - 0.5).ceil() as i32 {
            let share = (f64::from(column) + 0.5 - left) / (right - left);
            let between = |from: f64, to: f64| (from + (to - from) * share).round() as i32;
            let (top, bottom) = (between(top_left, top_right), between(bottom_left, bottom_right));
            if top < bottom {
                self.0.draw_rect((column, top), (column + 1, bottom), style, true)?;
            }
        }
        Ok(())
    }

    fn disc(&mut self, at: Point, radius: f64, style: &ShapeStyle) -> Result<(), Cause> {
        self.0.draw_circle(large(at), (radius * f64::from(ZOOM)).round() as u32, style, true).map_err(Cause::from)
    }

    fn letters(&mut self, text: &Text) -> Result<(), Cause> {
        let (words, width) = font::words(&text.text, text.size);
        let back = text.anchor.back(width);
        let ink = RGBColor(text.color.0, text.color.1, text.color.2);
        let transform = if text.upward { FontTransform::Rotate270 } else { FontTransform::None };
        for word in words {
            // plotters puts the base line half a line below the position.
            let (along, up) = (word.x - back, word.rise + word.size * font::LINE_PER_EM / 2.0);
            let (x, y) = text.at;
            let at = large(if text.upward { (x - up, y - along) } else { (x + along, y - up) });
            let font = font::font(word.size * f64::from(ZOOM)).transform(transform.clone());
            let style = TextStyle::from(font).color(&ink);
            for shift in [0, 1] {
                self.0.draw_text(&word.text, &style, (at.0 + shift, at.1))?;
            }
        }
        Ok(())
    }
}

fn large((x, y): Point) -> (i32, i32) {
    ((x * f64::from(ZOOM)).round() as i32, (y * f64::from(ZOOM)).round() as i32)
}

fn style((red, green, blue): Rgb, opacity: f64) -> ShapeStyle {
    ShapeStyle { color: RGBAColor(red, green, blue, opacity), filled: true, stroke_width: 1 }
}
