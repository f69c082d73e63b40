//! Error against instructions, drawn: one figure for each family, and one with the first comparison of each.
//!
//! Both axes are logarithmic. Dots are choices, with their names; the line joins the Pareto front. What is left of it and
//! below cannot be had. An error of exactly zero has no place on such an axis and is left out of the picture, not of the
//! tables.

use std::path::{Path, PathBuf};

use super::counts::ARCHITECTURE;
use super::{Comparison, Family};
use crate::report::ReportError;
use crate::report::plot::{Dash, Figure, Panel, Series, draw};

/// One comparison.
fn panel(family: &Family, comparison: &Comparison, title: String) -> Panel {
    let dots = |on_front: bool| {
        let chosen: Vec<_> = comparison.points.iter().filter(|point| point.on_front == on_front).collect();
        let points = chosen.iter().map(|point| (point.instructions as f64, point.error)).collect();
        (points, chosen.iter().map(|point| point.choice.clone()).collect())
    };
    let ((front, front_names), (beaten, beaten_names)) = (dots(true), dots(false));
    let mut line: Vec<(f64, f64)> = front;
    let joined = Series::dots("", 0, line.clone(), front_names);
    line.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    let unit = match comparison.unit {
        "1" => String::new(),
        unit => format!(" ({unit})"),
    };
    Panel {
        title,
        x_label: format!("Instructions per {}", short(family.instructions_per)),
        y_label: format!("{}{unit}", comparison.error),
        log_x: true,
        log_y: true,
        series: vec![Series::dashed("", 0, Dash::Dashed, line), Series::dots("", 1, beaten, beaten_names), joined],
        ..Panel::default()
    }
}

/// What instructions are counted for, without the explanation.
fn short(text: &str) -> &str {
    text.split(':').next().unwrap_or(text)
}

fn legend() -> String {
    format!("Blue, joined: Pareto front. Orange: beaten. Instructions of {ARCHITECTURE}, counted under callgrind.")
}

/// All comparisons of a family.
pub fn family(family: &Family) -> Figure {
    let panels: Vec<Panel> =
        family.comparisons.iter().map(|comparison| panel(family, comparison, comparison.title.clone())).collect();
    Figure {
        title: family.title.to_owned(),
        caption: format!("{} {}. Against {}. {}", family.insight, family.motion, family.reference, legend()),
        columns: 2,
        panels,
        ..Figure::default()
    }
}

/// The first comparison of every family.
pub fn overview(families: &[Family]) -> Figure {
    let first = |family: &Family| {
        let comparison = family.comparisons.first()?;
        Some(panel(family, comparison, format!("{}: {}", family.title, comparison.title)))
    };
    Figure {
        title: "Speed against error: every numerical choice of a peer".to_owned(),
        caption: legend(),
        columns: 2,
        panels: families.iter().filter_map(first).collect(),
        ..Figure::default()
    }
}

/// Draws all of them into a folder; returns the paths.
///
/// # Errors
/// A file that cannot be written.
pub fn write(families: &[Family], folder: &Path) -> Result<Vec<PathBuf>, ReportError> {
    let mut written = draw(&overview(families), &folder.join("speed-against-error"))?;
    for one in families {
        written.extend(draw(&family(one), &folder.join(one.name))?);
    }
    Ok(written)
}
