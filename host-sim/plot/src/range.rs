//! Ranges: what part of its data each panel shows.
//!
//! A range found from data holds the finite values (positive ones on a logarithmic axis) of the points inside the horizontal range, and
//! zero under bars; then a margin is added. Panels that share an axis of the same kind get the
//! union; [`Panel::off_scale`] panels add to it only if there is nothing else.

use super::scale::{Scale, showable};
use super::{Figure, Panel, Series, Shape, ShareY};

/// Both scales of one panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axes {
    pub(crate) x: Scale,
    pub(crate) y: Scale,
    /// The vertical range was found from data, so it may be widened.
    pub(crate) y_auto: bool,
    /// Panels with equal numbers share the vertical range.
    pub(crate) y_group: usize,
}

type Range = Option<(f64, f64)>;

/// The axes of every panel.
pub(crate) fn resolve(figure: &Figure) -> Vec<Axes> {
    let x_groups: Vec<usize> = (0..figure.panels.len()).map(|i| if figure.share_x { 0 } else { i }).collect();
    let y_group = |i: usize| match figure.share_y {
        ShareY::None => i,
        ShareY::Rows => i / figure.columns.max(1),
        ShareY::All => 0,
    };
    let y_groups: Vec<usize> = (0..figure.panels.len()).map(y_group).collect();

    let given = figure.panels.iter().map(|p| (p.x_range, found_x(p), p.log_x && p.categories.is_empty()));
    let xs = join(&figure.panels, &x_groups, given.collect());
    let given = figure.panels.iter().zip(&xs).map(|(p, x)| (p.y_range, found_y(p, x), p.log_y));
    let ys = join(&figure.panels, &y_groups, given.collect());
    let axes = xs.into_iter().zip(ys).zip(figure.panels.iter().zip(y_groups));
    axes.map(|((x, y), (panel, y_group))| Axes { x, y, y_auto: panel.y_range.is_none(), y_group }).collect()
}

/// One scale for each panel from (given range, found range, logarithmic): its own if given, else its group's union.
fn join(panels: &[Panel], groups: &[usize], ranges: Vec<(Range, Range, bool)>) -> Vec<Scale> {
    let union = |group: usize, log: bool, off_scale: bool| {
        let members =
            panels.iter().zip(groups).zip(&ranges).filter(|((panel, other), (.., kind))| {
                **other == group && *kind == log && (off_scale || !panel.off_scale)
            });
        members.filter_map(|(_, (given, found, _))| given.or(*found)).reduce(hull)
    };
    let scale = |(group, (given, _, log)): (&usize, &(Range, Range, bool))| {
        let range = given.or_else(|| union(*group, *log, false)).or_else(|| union(*group, *log, true));
        Scale::new(range.unwrap_or((f64::NAN, f64::NAN)), *log)
    };
    groups.iter().zip(&ranges).map(scale).collect()
}

fn found_x(panel: &Panel) -> Range {
    if !panel.categories.is_empty() {
        return Some((-0.6, panel.categories.len() as f64 - 0.4));
    }
    let range = extent(panel.series.iter().flat_map(span).map(|(x, _)| x), panel.log_x)?;
    // Dots and bars need room beside the outermost ones; lines and regions end at the frame.
    let separate = panel
        .series
        .iter()
        .any(|s| matches!(s.shape, Shape::Dots { .. } | Shape::Rings(_) | Shape::Intervals(_) | Shape::Bars(_)));
    Some(margin(range, panel.log_x, if separate { (0.1, 0.1) } else { (0.0, 0.0) }))
}

fn found_y(panel: &Panel, x: &Scale) -> Range {
    let visible = panel.series.iter().flat_map(span).filter(|(at, _)| x.holds(*at)).map(|(_, y)| y);
    let bars = panel.series.iter().any(|s| matches!(s.shape, Shape::Bars(_)));
    let region = panel.series.iter().any(|s| matches!(s.shape, Shape::Region(_)));
    let (mut lo, mut hi) = extent(visible, panel.log_y)?;
    // Bars stand on the axis and carry their values at the end; regions fill the panel to its edge.
    let sides = match (bars, region, panel.log_y) {
        (true, _, true) => (0.25, 0.15),
        (true, _, false) => {
            (lo, hi) = (lo.min(0.0), hi.max(0.0));
            (if lo < 0.0 { 0.15 } else { 0.0 }, if hi > 0.0 { 0.15 } else { 0.0 })
        }
        (_, true, _) => (0.0, 0.0),
        _ => (0.06, 0.06),
    };
    Some(margin((lo, hi), panel.log_y, sides))
}

fn margin(range: (f64, f64), log: bool, (below, above): (f64, f64)) -> (f64, f64) {
    let wide = Scale::new(range, log).widened(below, above);
    (wide.lo, wide.hi)
}

fn extent(values: impl Iterator<Item = f64>, log: bool) -> Range {
    values.filter(|v| showable(*v, log)).map(|v| (v, v)).reduce(hull)
}

fn hull(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Points that span a series: its own, or the corners of a region.
fn span(series: &Series) -> Vec<(f64, f64)> {
    match &series.shape {
        Shape::Line { points, .. } | Shape::Dots { points, .. } | Shape::Bars(points) | Shape::Rings(points) => {
            points.clone()
        }
        Shape::Intervals(points) => {
            points.iter().flat_map(|(x, y, within)| [(*x, y - within), (*x, *y), (*x, y + within)]).collect()
        }
        Shape::Region(strips) => {
            let corners = |(x, low, high): (f64, f64, f64)| [(x, low), (x, high)];
            strips.iter().flat_map(|strip| [corners(strip.left), corners(strip.right)].concat()).collect()
        }
    }
}

#[cfg(test)]
#[path = "../tests/inside/range.rs"]
mod tests;
