//! Panels: the inside of one frame, from data to marks.
//!
//! Regions lie at the bottom, then the grid, bars, lines and dots in their order, names, and the frame on top. Beside
//! the marks a panel returns its obstacles: points of what was drawn, close enough together that a box without any
//! covers nothing.

use super::range::Axes;
use super::sheet::{Dash, FAINT, Frame, GRID, INK, Mark, Point, color};
use super::{Panel, Series, Shape, trace};

/// Width of the lines of series.
pub(crate) const STROKE: f64 = 2.6;
/// Em of names beside dots and of values on bars.
pub(super) const NAME: f64 = 19.0;
/// Distance between obstacles along a line.
const SPACING: f64 = 6.0;

/// What one panel puts on the sheet.
#[derive(Debug, Default)]
pub(crate) struct Drawing {
    pub(crate) marks: Vec<Mark>,
    pub(crate) obstacles: Vec<Point>,
}

/// Draws a panel into its frame, with grid lines at these values.
pub(crate) fn draw(panel: &Panel, axes: &Axes, frame: &Frame, x_ticks: &[f64], y_ticks: &[f64]) -> Drawing {
    let mut canvas = Canvas { axes, frame, out: Drawing::default() };
    let (regions, others): (Vec<&Series>, Vec<&Series>) =
        panel.series.iter().partition(|s| matches!(s.shape, Shape::Cells { .. }));
    regions.into_iter().for_each(|series| canvas.region(series));
    canvas.grid(x_ticks, y_ticks);
    let ends = |pixels: Vec<Point>| if panel.off_scale { until_far(pixels, frame) } else { pixels };
    canvas.bars(&others);
    for series in &others {
        match &series.shape {
            Shape::Line { points, dash } => canvas.line(&ends(canvas.pixels(points)), series.color, *dash),
            Shape::Steps(points) => canvas.line(&trace::steps(&ends(canvas.pixels(points))), series.color, Dash::Solid),
            Shape::Dots { points, .. } => canvas.dots(points, series.color),
            Shape::Bars(_) | Shape::Cells { .. } => {}
        }
    }
    canvas.names(&others);
    let mut outline = frame.corners();
    outline.push((frame.left, frame.top));
    canvas.out.marks.push(Mark::Line { points: outline, color: INK, width: 1.5, dash: Dash::Solid });
    canvas.out
}

/// A frame with its axes and what was drawn in it so far; `bars`, `dots` and `region` add the other shapes.
pub(super) struct Canvas<'a> {
    pub(super) axes: &'a Axes,
    pub(super) frame: &'a Frame,
    pub(super) out: Drawing,
}

impl Canvas<'_> {
    pub(super) fn x(&self, value: f64) -> f64 {
        self.frame.left + self.axes.x.fraction(value) * self.frame.width()
    }

    pub(super) fn y(&self, value: f64) -> f64 {
        self.frame.bottom - self.axes.y.fraction(value) * self.frame.height()
    }

    pub(super) fn pixels(&self, points: &[(f64, f64)]) -> Vec<Point> {
        points.iter().map(|(x, y)| (self.x(*x), self.y(*y))).collect()
    }

    fn grid(&mut self, x_ticks: &[f64], y_ticks: &[f64]) {
        let (minor_x, minor_y) = (self.axes.x.minor_ticks(), self.axes.y.minor_ticks());
        let upright = |x: f64| vec![(x, self.frame.top), (x, self.frame.bottom)];
        let level = |y: f64| vec![(self.frame.left, y), (self.frame.right, y)];
        let lines = |xs: &[f64], ys: &[f64], color| -> Vec<Mark> {
            let upright = xs.iter().map(|x| upright(self.x(*x)));
            let level = ys.iter().map(|y| level(self.y(*y)));
            upright.chain(level).map(|points| Mark::Line { points, color, width: 1.0, dash: Dash::Solid }).collect()
        };
        let marks = [lines(&minor_x, &minor_y, FAINT), lines(x_ticks, y_ticks, GRID)].concat();
        self.out.marks.extend(marks);
    }

    fn line(&mut self, pixels: &[Point], number: usize, dash: Dash) {
        for points in trace::polylines(pixels, self.frame) {
            for pair in points.windows(2) {
                let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
                let count = (dx.hypot(dy) / SPACING).ceil().max(1.0);
                let between = (0..=count as usize)
                    .map(|i| (pair[0].0 + dx * i as f64 / count, pair[0].1 + dy * i as f64 / count));
                self.out.obstacles.extend(between);
            }
            self.out.marks.push(Mark::Line { points, color: color(number), width: STROKE, dash });
        }
    }
}

/// The points up to the first that is further outside than the frame is high, once they were inside: what follows in a
/// run that diverges would only fill the panel.
fn until_far(mut pixels: Vec<Point>, frame: &Frame) -> Vec<Point> {
    let near = frame.grown(frame.height());
    let far = |(_, y): &Point| *y < near.top || *y > near.bottom;
    let inside = pixels.iter().position(|p| frame.contains(*p)).unwrap_or(pixels.len());
    if let Some(i) = pixels.iter().skip(inside).position(far) {
        pixels.truncate(inside + i + 1);
    }
    pixels
}

/// Points on and in a rectangle, close enough together to be met by any box over it.
pub(super) fn lattice(area: &Frame) -> Vec<Point> {
    let along = |from: f64, to: f64| {
        let count = ((to - from) / (2.0 * SPACING)).ceil().max(1.0);
        (0..=count as usize).map(move |i| from + (to - from) * i as f64 / count)
    };
    along(area.left, area.right).flat_map(|x| along(area.top, area.bottom).map(move |y| (x, y))).collect()
}

#[cfg(test)]
#[path = "../tests/inside/panel.rs"]
mod tests;
