//! Regions: the cells of a grid that are inside, as one tinted shape.
//!
//! Borders lie half way between centres, in whole pixels, so that neighbouring cells neither overlap nor leave a seam.
//! Cells next to each other in a row are one rectangle.

use super::panel::Canvas;
use super::sheet::{Frame, Mark, color};
use super::{Series, Shape};

/// Opacity of regions: four on top of each other can still be told apart.
pub(crate) const TINT: f64 = 0.25;

impl Canvas<'_> {
    /// Tints the cells inside.
    pub(super) fn region(&mut self, series: &Series) {
        let Shape::Cells { xs, ys, inside } = &series.shape else { return };
        if xs.is_empty() {
            return;
        }
        let columns = edges(&xs.iter().map(|x| self.x(*x)).collect::<Vec<_>>(), self.frame.left, self.frame.right);
        let rows = edges(&ys.iter().map(|y| self.y(*y)).collect::<Vec<_>>(), self.frame.top, self.frame.bottom);
        let mut frames = Vec::new();
        for (row, cells) in inside.chunks(xs.len().max(1)).take(ys.len()).enumerate() {
            let mut column = 0;
            for run in cells.chunk_by(|a, b| a == b) {
                let (start, end) = (columns[column], columns[column + run.len()]);
                column += run.len();
                let (top, bottom) = (rows[row].min(rows[row + 1]), rows[row].max(rows[row + 1]));
                if run[0] && start < end && top < bottom {
                    frames.push(Frame { left: start, right: end, top, bottom });
                }
            }
        }
        if !frames.is_empty() {
            self.out.marks.push(Mark::Fill { frames, color: color(series.color), opacity: TINT });
        }
    }
}

/// The borders of cells around these centres, in whole pixels and inside the limits: one more than there are centres.
fn edges(centres: &[f64], low: f64, high: f64) -> Vec<f64> {
    let inside = |v: f64| if v.is_nan() { low } else { v.clamp(low, high).round() };
    let middle = |a: f64, b: f64| (a + b) / 2.0;
    let count = centres.len();
    let at = |i: usize| centres[i.min(count - 1)];
    let border = |i: usize| match i {
        _ if count == 1 => {
            if i == 0 {
                low
            } else {
                high
            }
        }
        0 => 1.5 * at(0) - 0.5 * at(1),
        _ if i == count => 1.5 * at(count - 1) - 0.5 * at(count - 2),
        _ => middle(at(i - 1), at(i)),
    };
    if count == 0 { Vec::new() } else { (0..=count).map(|i| inside(border(i))).collect() }
}

#[cfg(test)]
#[path = "../tests/inside/region.rs"]
mod tests;
