//! Error against instructions, drawn: one figure for each family, and one with the comparison of each that says most and the cost per scene.
//!
//! Both axes are logarithmic and span at least a factor of `LEAST_X` and `LEAST_Y`, so that choices that are nearly
//! alike look so. Dots are choices; the dashed line joins the Pareto front: what is left of it and below cannot be had. An
//! error of exactly zero has no place on such an axis: a note says so. Nor has a choice whose instructions nobody has counted.

use cohold_plot::{Dash, Figure, Panel, Series};

use super::counts::{Cost, Processor};
use super::{Comparison, Family, Point};

/// Least ratio of the ends of an axis of instructions.
const LEAST_X: f64 = 4.0;
/// Least ratio of the ends of an axis of errors.
const LEAST_Y: f64 = 30.0;
const MAIN_SCENES: [(&str, &str); 6] = [
    ("none", "one peer"),
    ("power", "power"),
    ("implicit-semi-implicit", "passive wave"),
    ("encoder-filtered", "encoder"),
    ("two-axes-encoder", "2 axes"),
    ("five-bar-libm", "five-bar"),
];

/// A range that holds these values, with room for names around them.
fn range(values: impl Iterator<Item = f64>, least: f64) -> Option<(f64, f64)> {
    let positive = values.filter(|value| *value > 0.0 && value.is_finite()).map(f64::ln);
    let (lo, hi) = positive.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), at| (lo.min(at), hi.max(at)));
    if lo > hi {
        return None;
    }
    let half = (0.6 * (hi - lo)).max(0.5 * least.ln());
    let middle = 0.5 * (lo + hi);
    Some(((middle - half).exp(), (middle + half).exp()))
}

fn panel(family: &Family, comparison: &Comparison, title: String) -> Panel {
    let unit = match comparison.unit {
        "1" => String::new(),
        unit => format!(" ({unit})"),
    };
    let points: Vec<Point> = comparison.points.iter().filter(|point| point.instructions.is_some()).cloned().collect();
    let in_series = points.iter().any(|point| !point.series.is_empty());
    Panel {
        title,
        x_label: format!("Instructions per {}", short(family.instructions_per)),
        y_label: format!("{}{unit}", capitalised(&comparison.error)),
        x_range: range(points.iter().map(|point| place(point).0), LEAST_X),
        // Where there is a legend, the layout makes room for it.
        y_range: range(points.iter().map(|point| point.error), LEAST_Y).filter(|_| !in_series),
        log_x: true,
        log_y: true,
        note: exact(&points),
        series: if in_series { curves(&points) } else { dots(&points) },
        ..Panel::default()
    }
}

/// The choices that have no place on a logarithmic axis.
fn exact(points: &[Point]) -> Option<String> {
    let names: Vec<&str> = points.iter().filter(|point| point.error == 0.0).map(|point| &*point.choice).collect();
    (!names.is_empty()).then(|| format!("{}: no error", names.join(", ")))
}

fn place(point: &Point) -> (f64, f64) {
    (point.instructions.unwrap_or_default() as f64, point.error)
}

/// The front, from left to right.
fn front(points: &[Point]) -> Vec<(f64, f64)> {
    let mut front: Vec<_> = points.iter().filter(|point| point.on_front && point.error > 0.0).map(place).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    front
}

/// Choices with their names: on the front in blue, beaten in orange.
fn dots(points: &[Point]) -> Vec<Series> {
    let chosen = |on_front: bool, color| {
        let chosen: Vec<_> = points.iter().filter(|point| point.on_front == on_front).collect();
        let names = chosen.iter().map(|point| point.label.clone()).collect();
        Series::dots("", color, chosen.into_iter().map(place).collect(), names)
    };
    vec![Series::dashed("", 0, Dash::Dashed, front(points)), chosen(false, 1), chosen(true, 0)]
}

/// How curves are broken, in turn; the second turn is drawn wider.
const DASHES: [Dash; 4] = [Dash::Solid, Dash::Dashed, Dash::Dotted, Dash::DashDot];

/// Choices that belong together as curves, each with its colour and its dash; names on the front only.
fn curves(points: &[Point]) -> Vec<Series> {
    let mut names: Vec<&str> = points.iter().map(|point| point.series.as_str()).collect();
    names.dedup();
    let of = |name: &str| points.iter().filter(|point| point.series == name).cloned().collect::<Vec<Point>>();
    let mut series: Vec<Series> = names
        .iter()
        .enumerate()
        .map(|(color, name)| {
            let line = of(name).iter().map(place).collect();
            Series::dashed(*name, color, DASHES[color % DASHES.len()], line)
                .wide(2.6 + 2.0 * (color / DASHES.len()) as f64)
        })
        .collect();
    for (color, name) in names.iter().enumerate() {
        let labels = of(name).into_iter().map(|point| if point.on_front { point.label } else { String::new() });
        series.push(Series::dots("", color, of(name).iter().map(place).collect(), labels.collect()));
    }
    series.push(Series::dashed("Pareto front", 6, Dash::Dashed, front(points)));
    series
}

/// A label begins with a capital letter.
fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// What instructions are counted for, without the explanation.
fn short(text: &str) -> &str {
    text.split(':').next().unwrap_or(text)
}

/// What the marks mean; the colours of curves are in their own legend.
fn legend(curves: bool, processor: Processor) -> String {
    let beaten = if curves { "" } else { "; orange dots: beaten" };
    format!(
        "Dashed in black, or in blue between named dots: Pareto front{beaten}. Instructions of {}.",
        processor.label()
    )
}

fn family(family: &Family, processor: Processor) -> Figure {
    let panels = family.comparisons.iter().map(|comparison| panel(family, comparison, comparison.title.clone()));
    let curves =
        family.comparisons.iter().flat_map(|comparison| &comparison.points).all(|point| !point.series.is_empty());
    let legend = legend(curves, processor);
    Figure {
        title: family.title.to_owned(),
        caption: format!("{} {}. Against {}. {legend}", family.insight, family.motion, family.reference),
        columns: 2,
        panels: panels.collect(),
        ..Figure::default()
    }
}

/// Bars of instructions of these scenes in f32, (name, text below the bars).
fn bars(costs: &[Cost], scenes: &[(&str, &str)], title: &str) -> Panel {
    let found: Vec<(&Cost, &str)> = scenes
        .iter()
        .filter_map(|(name, text)| Some((costs.iter().find(|cost| cost.scene == *name)?, *text)))
        .collect();
    let heights = found.iter().enumerate().map(|(at, (cost, _))| (at as f64, cost.instructions[0] as f64)).collect();
    Panel {
        title: title.to_owned(),
        y_label: "Instructions per tick".to_owned(),
        categories: found.iter().map(|(_, text)| (*text).to_owned()).collect(),
        series: vec![Series::bars("", 0, heights)],
        ..Panel::default()
    }
}

/// The comparison of every family that says most, and the cost of the main scenes.
fn overview(families: &[Family], costs: &[Cost], processor: Processor) -> Figure {
    let headline = |family: &Family| {
        let comparison = family.comparisons.get(family.headline)?;
        Some(panel(family, comparison, format!("{}: {}", family.title, comparison.title)))
    };
    let mut panels: Vec<Panel> = families.iter().filter_map(headline).collect();
    panels.push(bars(costs, &MAIN_SCENES, "Cost per scene: what a tick must carry, f32"));
    Figure {
        title: "Speed against error: every numerical choice of a peer".to_owned(),
        caption: legend(false, processor),
        columns: 2,
        panels,
        ..Figure::default()
    }
}

/// All of them, each with its name.
pub fn all(families: &[Family], table: &[Cost], processor: Processor) -> Vec<(&'static str, Figure)> {
    let each = families.iter().map(|one| (one.name, family(one, processor)));
    let first = std::iter::once(("speed-against-error", overview(families, table, processor)));
    first.chain(each).collect()
}
