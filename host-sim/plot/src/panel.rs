//! Panels: the inside of one frame, from data to marks.
//!
//! Regions lie at the bottom, then the grid, bars, lines and dots in their order, names, and the frame on top. Beside the marks a panel
//! returns its obstacles: points of what was drawn, close enough together that a box without any covers nothing.
//!
//! Bars stand on zero, or on the lower edge of a logarithmic axis, and end at the frame at the latest. Those of several series share the
//! room of a category. A bar without a finite value still has its value written: nothing is left out in silence.
//!
//! A region is tinted between straight edges, which are those that its outline is drawn along.

use super::range::Axes;
use super::sheet::{Anchor, Dash, FAINT, Frame, GRID, INK, Mark, PAPER, Point, Rgb, color};
use super::{Panel, Series, Shape, Strip, font, significant, trace};

/// Width of the lines of series.
pub(crate) const STROKE: f64 = 2.6;
/// Em of names beside dots and of values on bars.
const NAME: f64 = 19.0;
/// Distance between obstacles along a line.
const SPACING: f64 = 6.0;
/// Radius of dots, pixels.
pub(crate) const DOT: f64 = 7.0;
/// A name stands off its dot by the room between them at most so many times.
const FURTHEST: u32 = 5;
/// Opacity of regions: four on top of each other can still be distinguished.
pub(crate) const TINT: f64 = 0.25;
/// Part of a category's room that its bars fill together, and that one bar fills at most.
const FILLED: f64 = 0.84;
const WIDEST: f64 = 0.5;

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
        panel.series.iter().partition(|s| matches!(s.shape, Shape::Region(_)));
    regions.into_iter().for_each(|series| canvas.region(series));
    canvas.grid(x_ticks, y_ticks);
    let ends = |pixels: Vec<Point>| if panel.off_scale { until_far(pixels, frame) } else { pixels };
    canvas.bars(&others);
    for series in &others {
        match &series.shape {
            Shape::Line { points, dash } => canvas.line(&ends(canvas.pixels(points)), series, *dash),
            Shape::Dots { points, .. } => canvas.dots(points, series.color),
            Shape::Rings(points) => canvas.rings(points, series.color),
            Shape::Intervals(points) => canvas.intervals(points, series),
            Shape::Bars(_) | Shape::Region(_) => {}
        }
    }
    canvas.names(&others);
    canvas.out.marks.push(Mark::line(frame.outline(), INK, 1.5));
    canvas.out
}

/// A frame with its axes and what was drawn in it so far.
struct Canvas<'a> {
    axes: &'a Axes,
    frame: &'a Frame,
    out: Drawing,
}

impl Canvas<'_> {
    fn x(&self, value: f64) -> f64 {
        self.frame.left + self.axes.x.fraction(value) * self.frame.width()
    }

    fn y(&self, value: f64) -> f64 {
        self.frame.bottom - self.axes.y.fraction(value) * self.frame.height()
    }

    fn pixels(&self, points: &[(f64, f64)]) -> Vec<Point> {
        points.iter().map(|(x, y)| (self.x(*x), self.y(*y))).collect()
    }

    fn grid(&mut self, x_ticks: &[f64], y_ticks: &[f64]) {
        let (minor_x, minor_y) = (self.axes.x.minor_ticks(), self.axes.y.minor_ticks());
        let upright = |x: f64| vec![(x, self.frame.top), (x, self.frame.bottom)];
        let level = |y: f64| vec![(self.frame.left, y), (self.frame.right, y)];
        let lines = |xs: &[f64], ys: &[f64], color| -> Vec<Mark> {
            let upright = xs.iter().map(|x| upright(self.x(*x)));
            let level = ys.iter().map(|y| level(self.y(*y)));
            upright.chain(level).map(|points| Mark::line(points, color, 1.0)).collect()
        };
        let marks = [lines(&minor_x, &minor_y, FAINT), lines(x_ticks, y_ticks, GRID)].concat();
        self.out.marks.extend(marks);
    }

    fn line(&mut self, pixels: &[Point], series: &Series, dash: Dash) {
        for points in trace::polylines(pixels, self.frame) {
            for pair in points.windows(2) {
                let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
                let count = (dx.hypot(dy) / SPACING).ceil().max(1.0);
                let between = (0..=count as usize)
                    .map(|i| (pair[0].0 + dx * i as f64 / count, pair[0].1 + dy * i as f64 / count));
                self.out.obstacles.extend(between);
            }
            self.out.marks.push(Mark::Line { points, color: color(series.color), width: series.width, dash });
        }
    }
    /// Tints the region of this series.
    fn region(&mut self, series: &Series) {
        let Shape::Region(strips) = &series.shape else { return };
        let inside = |value: f64, low: f64, high: f64| if value.is_nan() { low } else { value.clamp(low, high) };
        let x = |value: f64| inside(self.x(value), self.frame.left, self.frame.right);
        let y = |value: f64| inside(self.y(value), self.frame.top, self.frame.bottom);
        let corners = |strip: &Strip| {
            let ((left, ..), (right, ..)) = (strip.left, strip.right);
            [(left, strip.left.2), (right, strip.right.2), (right, strip.right.1), (left, strip.left.1)]
                .map(|(at, height)| (x(at), y(height)))
        };
        let strips: Vec<[Point; 4]> = strips.iter().map(corners).collect();
        if !strips.is_empty() {
            self.out.marks.push(Mark::Region { strips, color: color(series.color), opacity: TINT });
        }
    }

    /// Draws every series of bars.
    fn bars(&mut self, series: &[&Series]) {
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
        let at = |top: f64| Frame::sized((middle - half, top), 2.0 * half, NAME);
        let free = |area: &Frame| !written.iter().any(|other| other.overlaps(area));
        let label = (0..4).map(|i| at(top + down * NAME * f64::from(i))).find(free).unwrap_or_else(|| at(top));
        let top = label.top.clamp(self.frame.top + 2.0, self.frame.bottom - NAME - 2.0);
        let label = at(top);

        self.out.obstacles.extend(lattice(&bar).into_iter().chain(lattice(&label)));
        self.out.marks.push(Mark::fill(bar, color(number), 1.0));
        if label.overlaps(&bar) {
            self.out.marks.push(Mark::fill(label, PAPER, 0.9));
        }
        self.out.marks.push(Mark::text((middle, label.bottom - 4.0), Anchor::Middle, NAME, INK, &text));
        label
    }

    /// A stroke with a cross-stroke at either end, and the dot between them.
    fn intervals(&mut self, points: &[(f64, f64, f64)], series: &Series) {
        for (x, y, within) in points.iter().filter(|(_, _, within)| *within > 0.0) {
            let (at, [low, high]) = (self.x(*x), [y - within, y + within].map(|end| self.y(end)));
            self.line(&[(at, low), (at, high)], series, Dash::Solid);
            for end in [low, high] {
                self.line(&[(at - DOT, end), (at + DOT, end)], series, Dash::Solid);
            }
        }
        self.dots(&points.iter().map(|(x, y, _)| (*x, *y)).collect::<Vec<_>>(), series.color);
    }

    fn visible(&self, points: &[(f64, f64)]) -> Vec<Point> {
        self.pixels(points).into_iter().filter(|p| self.frame.contains(*p)).collect()
    }

    fn dots(&mut self, points: &[(f64, f64)], number: usize) {
        let visible = self.visible(points);
        self.out.marks.extend(visible.iter().map(|at| Mark::Disc { at: *at, radius: DOT, color: color(number) }));
        // What covers a dot covers more than what crosses a line.
        let about = |at: &Point| Frame::sized(*at, 0.0, 0.0).grown(DOT - 2.0);
        self.out.obstacles.extend(visible.iter().flat_map(|at| lattice(&about(at))));
    }

    fn rings(&mut self, points: &[(f64, f64)], number: usize) {
        let visible = self.visible(points);
        self.out.marks.extend(visible.iter().flat_map(|at| ring(*at, color(number))));
        self.out.obstacles.extend(visible);
    }

    /// Writes each name beside its dot, where it covers the least.
    fn names(&mut self, series: &[&Series]) {
        let named = series.iter().filter_map(|s| match &s.shape {
            Shape::Dots { points, names } => Some(self.pixels(points).into_iter().zip(names.clone())),
            _ => None,
        });
        let shown = |(at, name): &(Point, String)| self.frame.contains(*at) && !name.is_empty();
        let named: Vec<(Point, String)> = named.flatten().filter(shown).collect();
        let inside = self.frame.grown(-4.0);
        let mut taken: Vec<Frame> = Vec::new();
        for (at, name) in named {
            let (width, gap) = (font::width(&name, NAME), DOT + 5.0);
            let sides =
                [(1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            // Near its dot a name stands beside it; further off a stroke leads to it.
            let place = |(off, (sx, sy)): (f64, (f64, f64))| {
                let (x, y) = (at.0 + sx * (width / 2.0 + gap * off), at.1 + sy * (NAME / 2.0 + gap * off));
                let (left, top) = (x - width / 2.0, y - NAME / 2.0);
                let (left, top) = if off > 1.0 {
                    (left.min(inside.right - width).max(inside.left), top.min(inside.bottom - NAME).max(inside.top))
                } else {
                    (left, top)
                };
                Frame::sized((left, top), width, NAME)
            };
            let cost = |(off, area): &(f64, Frame)| {
                let inside = area.corners().into_iter().all(|corner| self.frame.grown(-3.0).contains(corner));
                let names = taken.iter().filter(|other| area.overlaps(&other.grown(2.0))).count();
                let data = self.out.obstacles.iter().filter(|p| area.grown(DOT - 3.0).contains(**p)).count();
                usize::from(!inside) * 100_000 + names * 1_000 + data + *off as usize
            };
            let places = (1..=FURTHEST).flat_map(|off| sides.map(|side| (f64::from(off), side)));
            if let Some((off, area)) = places.map(|place_at| (place_at.0, place(place_at))).min_by_key(cost) {
                taken.push(area);
                if off > 1.0 {
                    let end = (at.0.clamp(area.left, area.right), at.1.clamp(area.top, area.bottom));
                    self.out.marks.push(Mark::line(vec![at, end], INK, 1.0));
                }
                self.out.marks.push(Mark::text((area.left, area.bottom - 4.0), Anchor::Start, NAME, INK, &name));
            }
        }
        taken.iter().for_each(|area| self.out.obstacles.extend(lattice(area)));
    }
}

/// A ring: a disc with the sheet's colour inside.
pub(crate) fn ring(at: Point, color: Rgb) -> [Mark; 2] {
    [Mark::Disc { at, radius: DOT, color }, Mark::Disc { at, radius: DOT - STROKE, color: PAPER }]
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
fn lattice(area: &Frame) -> Vec<Point> {
    let along = |from: f64, to: f64| {
        let count = ((to - from) / (2.0 * SPACING)).ceil().max(1.0);
        (0..=count as usize).map(move |i| from + (to - from) * i as f64 / count)
    };
    along(area.left, area.right).flat_map(|x| along(area.top, area.bottom).map(move |y| (x, y))).collect()
}

#[cfg(test)]
#[path = "../tests/inside/panel.rs"]
mod tests;
