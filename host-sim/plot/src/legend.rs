//! Legends: who is who in a panel, written where no data are.
//!
//! The series with a label, then the panel's note, stand in one box. Of a raster of places inside the frame the box takes the one that
//! covers the fewest obstacles (points of the drawn data), corners first. [`Spot::covered`] tells the layout when even that one covers
//! data, so that it can make room above them, or write the series in columns below all panels ([`below`]), as it does with a box that is
//! wider than its panel.

use super::sheet::{ALERT, Anchor, Dash, Frame, GRID, INK, Mark, PAPER, Point, color};
use super::{Panel, Series, Shape, font, panel};

/// Em of the letters.
const SIZE: f64 = 20.0;
/// From one base line to the next.
const LINE: f64 = 26.0;
/// Length of the sample in front of a label, with the gap after it.
const SAMPLE: f64 = 52.0;
/// Inside the box, around its lines.
const PADDING: f64 = 8.0;
/// Between the box and the frame, and around obstacles.
const CLEARANCE: f64 = 8.0;

/// Where a box stands and how many obstacles it covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spot {
    pub(crate) area: Frame,
    pub(crate) covered: usize,
}

/// The panel's note in lines that fit into its frame.
fn note(panel: &Panel, frame: &Frame) -> Vec<String> {
    let room = frame.width() - 2.0 * (CLEARANCE + PADDING);
    panel.note.iter().flat_map(|note| font::wrap(note, SIZE, room)).collect()
}

/// How wide the entry of each labelled series is.
fn widths(panel: &Panel) -> impl Iterator<Item = f64> {
    labelled(panel).map(|series| SAMPLE + font::width(&series.label, SIZE))
}

/// Width and height of a panel's box; `None` if there is nothing to write.
fn size(panel: &Panel, frame: &Frame) -> Option<(f64, f64)> {
    let labels = widths(panel);
    let note = note(panel, frame).into_iter().map(|line| font::width(&line, SIZE));
    let widths: Vec<f64> = labels.chain(note).collect();
    let widest = widths.iter().copied().reduce(f64::max)?;
    Some((widest + 2.0 * PADDING, widths.len() as f64 * LINE + 2.0 * PADDING - 4.0))
}

/// Whether the labels of the panel's series are too long for a box in it.
pub(crate) fn is_wide(panel: &Panel, frame: &Frame) -> bool {
    widths(panel).any(|width| width + 2.0 * (PADDING + CLEARANCE) > frame.width())
}

/// The best place in the frame for the panel's box.
pub(crate) fn place(panel: &Panel, frame: &Frame, obstacles: &[Point]) -> Option<Spot> {
    const COLUMNS: usize = 12;
    const ROWS: usize = 8;
    let (width, height) = size(panel, frame)?;
    let room = Frame {
        left: frame.left + CLEARANCE,
        top: frame.top + CLEARANCE,
        right: (frame.right - CLEARANCE - width).max(frame.left + CLEARANCE),
        bottom: (frame.bottom - CLEARANCE - height).max(frame.top + CLEARANCE),
    };
    let place = |column: usize, row: usize| {
        let left = room.left + room.width() * column as f64 / COLUMNS as f64;
        let top = room.top + room.height() * row as f64 / ROWS as f64;
        let area = Frame::sized((left, top), width, height);
        let grown = area.grown(CLEARANCE);
        Spot { area, covered: obstacles.iter().filter(|p| grown.contains(**p)).count() }
    };
    // Edges before the middle, top before bottom, right before left: the first of equals is kept.
    let from_edge = |i: usize, last: usize| i.min(last - i);
    let mut cells: Vec<(usize, usize)> = (0..=COLUMNS).flat_map(|c| (0..=ROWS).map(move |r| (c, r))).collect();
    cells.sort_by_key(|(c, r)| (from_edge(*c, COLUMNS) + from_edge(*r, ROWS), r * 2 > ROWS, c * 2 < COLUMNS));
    cells.into_iter().map(|(c, r)| place(c, r)).min_by_key(|spot| spot.covered)
}

/// The height above the data that makes room for the panel's box, as a fraction of the frame.
pub(crate) fn headroom(panel: &Panel, frame: &Frame) -> f64 {
    size(panel, frame).map_or(0.0, |(_, height)| (height + 2.0 * CLEARANCE) / frame.height())
}

/// The box at its place in the frame.
pub(crate) fn marks(panel: &Panel, frame: &Frame, area: Frame) -> Vec<Mark> {
    let mut marks = vec![Mark::fill(area, PAPER, 0.88), Mark::line(area.outline(), GRID, 1.0)];
    let (left, mut base) = (area.left + PADDING, area.top + PADDING + 16.0);
    for series in labelled(panel) {
        marks.extend(entry(series, (left, base)));
        base += LINE;
    }
    for line in note(panel, frame) {
        marks.push(Mark::text((left, base), Anchor::Start, SIZE, ALERT, &line));
        base += LINE;
    }
    marks
}

/// The series with a label in columns, read downwards, from `top` on between two margins, under the name of what they are of if it has
/// one; and where they end.
pub(crate) fn below(panel: &Panel, name: &str, mut top: f64, (left, right): (f64, f64)) -> (Vec<Mark>, f64) {
    let mut marks = Vec::new();
    if !name.is_empty() {
        top += LINE;
        marks.push(Mark::text((left, top), Anchor::Start, SIZE, INK, name));
    }
    let widest = widths(panel).fold(1.0, f64::max);
    let count = labelled(panel).count();
    let columns = (((right - left) / (widest + SAMPLE)) as usize).clamp(1, count.max(1));
    let rows = count.div_ceil(columns);
    let place = |at: usize| {
        (left + (right - left) * (at / rows) as f64 / columns as f64, top + LINE * ((at % rows) as f64 + 1.0))
    };
    marks.extend(labelled(panel).enumerate().flat_map(|(at, series)| entry(series, place(at))));
    (marks, top + LINE * rows as f64)
}

/// The series of a panel that have a label.
pub(crate) fn labelled(panel: &Panel) -> impl Iterator<Item = &Series> {
    panel.series.iter().filter(|series| !series.label.is_empty())
}

/// A sample of a series and its label, which begin at this point of the base line.
fn entry(series: &Series, (left, base): Point) -> Vec<Mark> {
    let (color, middle) = (color(series.color), base - 7.0);
    let square = Frame::sized((left + 8.0, middle - 8.0), 24.0, 16.0);
    let stroke = |dash: Dash| {
        let points = vec![(left, middle), (left + SAMPLE - 10.0, middle)];
        Mark::Line { points, color, width: series.width, dash }
    };
    let at = (left + 20.0, middle);
    let mut marks = match &series.shape {
        Shape::Line { dash, .. } => vec![stroke(*dash)],
        Shape::Dots { .. } | Shape::Intervals(_) => vec![Mark::Disc { at, radius: panel::DOT, color }],
        Shape::Rings(_) => panel::ring(at, color).to_vec(),
        Shape::Bars(_) => vec![Mark::fill(square, color, 1.0)],
        Shape::Region(_) => vec![Mark::fill(square, color, panel::TINT)],
    };
    marks.push(Mark::text((left + SAMPLE, base), Anchor::Start, SIZE, INK, &series.label));
    marks
}

#[cfg(test)]
#[path = "../tests/inside/legend.rs"]
mod tests;
