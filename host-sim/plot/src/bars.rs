//! Bars: one height for each category, with its value at the end.
//!
//! Bars stand on zero, or on the lower edge of a logarithmic axis, and end at the frame at the latest. Those of several
//! series share the room of a category. A bar without a finite value still has its value written: nothing is left out
//! in silence.

use super::panel::{Canvas, NAME, lattice};
use super::sheet::{Anchor, Frame, INK, Mark, PAPER, Text, color};
use super::{Series, Shape, font};
use crate::significant;

/// Part of a category's room that its bars fill together, and that one bar fills at most.
const FILLED: f64 = 0.84;
const WIDEST: f64 = 0.5;

impl Canvas<'_> {
    /// Draws every series of bars.
    pub(super) fn bars(&mut self, series: &[&Series]) {
        let all: Vec<(usize, &[(f64, f64)])> = series.iter().filter_map(|s| heights(s)).collect();
        let unit = (self.x(1.0) - self.x(0.0)).abs();
        let mut written: Vec<Frame> = Vec::new();
        for (number, (color, points)) in all.iter().enumerate() {
            for (at, value) in points.iter().filter(|(at, _)| at.is_finite() && unit.is_finite()) {
                let here = |(_, points): &&(usize, &[(f64, f64)])| points.iter().any(|(x, _)| x.round() == at.round());
                let (count, place) = (all.iter().filter(here).count(), all.iter().take(number).filter(here).count());
                let width = unit * (FILLED / count as f64).min(WIDEST);
                let middle = self.x(*at) + (place as f64 - (count as f64 - 1.0) / 2.0) * width;
                if middle > self.frame.left && middle < self.frame.right {
                    let label = self.bar(middle, width, *value, *color, &written);
                    written.push(label);
                }
            }
        }
    }

    /// Draws one bar and its value, above any value already written there; returns where the value stands.
    fn bar(&mut self, middle: f64, width: f64, value: f64, number: usize, written: &[Frame]) -> Frame {
        let inside = |y: f64| y.clamp(self.frame.top, self.frame.bottom);
        let zero = self.y(0.0);
        let base = if zero.is_finite() { inside(zero) } else { self.frame.bottom };
        let end = if value.is_nan() || self.y(value).is_nan() { base } else { inside(self.y(value)) };
        let half = 0.46 * width;
        let bar = Frame { left: middle - half, right: middle + half, top: base.min(end), bottom: base.max(end) };

        let text = value_text(value);
        let half = font::width(&text, NAME) / 2.0 + 2.0;
        let (down, top) = if end > base { (1.0, end + 4.0) } else { (-1.0, end - NAME - 4.0) };
        let at = |top: f64| Frame { left: middle - half, right: middle + half, top, bottom: top + NAME };
        let free = |area: &Frame| !written.iter().any(|other| other.overlaps(area));
        let label = (0..4).map(|i| at(top + down * NAME * f64::from(i))).find(free).unwrap_or_else(|| at(top));
        let top = label.top.clamp(self.frame.top + 2.0, self.frame.bottom - NAME - 2.0);
        let label = at(top);

        self.out.obstacles.extend(lattice(&bar).into_iter().chain(lattice(&label)));
        self.out.marks.push(Mark::Fill { frames: vec![bar], color: color(number), opacity: 1.0 });
        if label.overlaps(&bar) {
            self.out.marks.push(Mark::Fill { frames: vec![label], color: PAPER, opacity: 0.9 });
        }
        let at = (middle, label.bottom - 4.0);
        let text = Text { at, anchor: Anchor::Middle, size: NAME, color: INK, upward: false, text };
        self.out.marks.push(Mark::Text(text));
        label
    }
}

/// Colour and points of a series of bars.
fn heights(series: &Series) -> Option<(usize, &[(f64, f64)])> {
    match &series.shape {
        Shape::Bars(points) => Some((series.color, points)),
        _ => None,
    }
}

/// Three significant digits without zeros at the end.
fn value_text(value: f64) -> String {
    let text = significant(value, 3).replace('-', "−");
    let decimal = text.contains('.') && !text.contains('e');
    if decimal { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
#[path = "../tests/inside/bars.rs"]
mod tests;
