//! Data: what a figure shows, as a table that the figure carries.
//!
//! A row for each point, in the units of the axes: panel (from 1), series, name (of a dot or a category), x and y; an interval or a
//! region has its lower and upper edge besides or instead. Lines that begin with `#` say what the panels' axes are. Of a line there are
//! the points inside the horizontal range and one on either side, of many in one column of pixels the lowest and the highest, which is
//! all that is seen of it; numbers have seven digits that count.

use super::error::Cause;
use super::range::Axes;
use super::{DATA_COLUMNS, Figure, Panel, Series, Shape, trace};

/// A row but for panel and series.
type Row = (String, [Option<f64>; 4]);

/// The table as CSV, of panels whose frames are so many pixels wide; empty for a figure that shows nothing.
pub(crate) fn csv(figure: &Figure, axes: &[Axes], widths: &[f64]) -> Result<String, Cause> {
    let mut about = String::new();
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut line = |cells: &[&str]| writer.write_record(cells);
    line(&DATA_COLUMNS.map(|(name, _)| name))?;
    let mut rows_in_all = 0;
    for (number, ((panel, axes), width)) in figure.panels.iter().zip(axes).zip(widths).enumerate() {
        let said = [&panel.title, &panel.x_label, &panel.y_label]
            .map(|text| text.split_whitespace().collect::<Vec<_>>().join(" "));
        about += &format!("# panel {}: {}; x: {}; y: {}\n", number + 1, said[0], said[1], said[2]);
        for series in &panel.series {
            for (name, numbers) in rows(panel, series, axes, *width) {
                let numbers = numbers.map(|number| number.map_or(String::new(), text));
                let [x, y, low, high] = numbers.each_ref().map(String::as_str);
                line(&[&(number + 1).to_string(), &series.label, &name, x, y, low, high])?;
                rows_in_all += 1;
            }
        }
    }
    let table = writer.into_inner()?;
    let table = String::from_utf8(table)?;
    Ok(if rows_in_all == 0 { String::new() } else { about + &table })
}

/// The rows of one series in a frame this many pixels wide.
fn rows(panel: &Panel, series: &Series, axes: &Axes, width: f64) -> Vec<Row> {
    let plain = |(x, y): &(f64, f64)| (String::new(), [Some(*x), Some(*y), None, None]);
    match &series.shape {
        Shape::Line { points, .. } => {
            let inside = |at: Option<usize>| at.and_then(|at| points.get(at)).is_some_and(|(x, _)| axes.x.holds(*x));
            let seen =
                (0..points.len()).filter(|at| [at.checked_sub(1), Some(*at), Some(at + 1)].into_iter().any(inside));
            let seen: Vec<(f64, f64)> = seen.map(|at| points[at]).collect();
            // A gap stays one: its point without a number is a row.
            let runs = seen.chunk_by(|a, b| a.1.is_nan() == b.1.is_nan());
            let kept = runs.flat_map(|run| trace::extremes(run, |(x, _)| (axes.x.fraction(*x) * width).floor()));
            kept.map(|point| plain(&point)).collect()
        }
        Shape::Dots { points, names } => {
            let name = |at: usize| names.get(at).cloned().unwrap_or_default();
            points.iter().enumerate().map(|(at, point)| (name(at), plain(point).1)).collect()
        }
        Shape::Rings(points) => points.iter().map(plain).collect(),
        Shape::Bars(points) => {
            let name = |x: f64| panel.categories.get(x.round() as usize).cloned().unwrap_or_default();
            points.iter().map(|point| (name(point.0), plain(point).1)).collect()
        }
        Shape::Intervals(points) => {
            let row = |(x, y, within): &(f64, f64, f64)| {
                (String::new(), [Some(*x), Some(*y), Some(y - within), Some(y + within)])
            };
            points.iter().map(row).collect()
        }
        Shape::Region(strips) => {
            let edge = |(x, low, high)| (String::new(), [Some(x), None, Some(low), Some(high)]);
            let mut edges: Vec<_> = strips.iter().flat_map(|strip| [strip.left, strip.right]).collect();
            edges.dedup();
            edges.into_iter().map(edge).collect()
        }
    }
}

/// Seven digits that count, as a power of ten where that is much shorter.
fn text(number: f64) -> String {
    let rounded: f64 = format!("{number:.6e}").parse().unwrap_or(number);
    Some(rounded.to_string()).filter(|plain| plain.len() <= 12).unwrap_or(format!("{rounded:e}"))
}

#[cfg(test)]
#[path = "../tests/inside/data.rs"]
mod tests;
