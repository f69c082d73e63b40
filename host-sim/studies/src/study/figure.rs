//! A study as a picture: the figure of merit along the first axis, a panel for each network; without an axis, along the networks.
//!
//! What is drawn at a value of the first axis is the best point of an entrant, or the least of those that may be taken there, as the mean
//! over all seeds with its 95 % interval; where none may be taken, a ring at the least of what there is. Every entrant has a dash of its
//! own, so that no colour has to tell.

use std::ops::Range;

use cohold_plot::{Dash, Figure, Panel, Series, Shape, ShareY, Strip};
use cohold_report::label;

use super::Study;
use super::answers::{Answer, Goal, Standing, by_point};
use crate::estimate::Estimate;
use crate::sweep::{METRICS, Plan, Row, estimate};

/// Panels of one figure.
const PANELS: usize = 6;
/// Networks along a horizontal axis that fit a column of a journal.
const NAMES: usize = 4;
/// Longest name in a legend, letters.
const LONGEST: usize = 60;
/// Black, and the colours of entrants before it.
const BLACK: usize = 6;
const DASHES: [Dash; 4] = [Dash::Solid, Dash::Dashed, Dash::DashDot, Dash::Dotted];
/// From this ratio of its ends on an axis is logarithmic.
const DECADE: f64 = 10.0;
/// Width of the line that goes through what may not be taken, too.
const THIN: f64 = 1.0;
/// Part of a name's room that the entrants beside each other fill.
const BESIDE: f64 = 0.6;

/// What is drawn of an entrant at a place.
#[derive(Clone, Copy, Debug)]
struct Spot {
    x: f64,
    found: Estimate,
    allowed: bool,
    best: bool,
}

/// What runs along the horizontal axis.
enum Along {
    /// The first key, which is a number.
    Numbers(Vec<f64>),
    /// The first key's values, or networks.
    Names(Vec<String>),
}

/// The runs of all points, the answers, and what is asked.
struct Found<'a> {
    runs: Vec<Option<&'a [Row]>>,
    answers: &'a [Answer],
    goal: &'a Goal,
}

/// What a search has not run.
#[derive(Clone, Copy)]
struct Spared {
    /// Some runs of a point.
    some: bool,
    /// All runs of one.
    all: bool,
}

impl Study {
    /// The figures, of so many panels each that they can be read.
    pub fn figures(&self, rows: &[Row], answers: &[Answer], goal: &Goal) -> Vec<Figure> {
        let found = Found { runs: by_point(self, rows), answers, goal };
        let panels: Vec<Panel> = match self.grid().axes.first() {
            None => {
                let networks: Vec<usize> = (0..self.networks.len()).collect();
                let panel = |some: &[usize]| {
                    let whole = 0..self.grid().points();
                    let spot = |entrant, x: usize| self.spot(&found, entrant, some[x], whole.clone(), x as f64);
                    let of = |entrant| (0..some.len()).filter_map(|x| spot(entrant, x)).collect();
                    let spots: Vec<Vec<Spot>> = (0..self.entrants.len()).map(of).collect();
                    let names = some.iter().map(|at| self.networks[*at].name.clone()).collect();
                    self.panel(String::new(), &spots, &Along::Names(names), goal)
                };
                networks.chunks(NAMES).map(panel).collect()
            }
            Some(axis) => {
                let numbers: Option<Vec<f64>> = axis.values.iter().map(|value| value.parse().ok()).collect();
                let along = numbers.map_or_else(|| Along::Names(axis.values.clone()), Along::Numbers);
                let each = self.grid().points() / axis.values.len().max(1);
                let panel = |network: usize| {
                    let x = |at: usize| if let Along::Numbers(numbers) = &along { numbers[at] } else { at as f64 };
                    let spot =
                        |entrant, at: usize| self.spot(&found, entrant, network, at * each..(at + 1) * each, x(at));
                    let of = |entrant| (0..axis.values.len()).filter_map(|at| spot(entrant, at)).collect();
                    let spots: Vec<Vec<Spot>> = (0..self.entrants.len()).map(of).collect();
                    let title =
                        if self.networks.len() > 1 { self.networks[network].name.clone() } else { String::new() };
                    self.panel(title, &spots, &along, goal)
                };
                (0..self.networks.len()).map(panel).collect()
            }
        };
        let spared = Spared {
            some: found.runs.iter().flatten().any(|runs| runs.len() < self.seeds() as usize),
            all: found.runs.iter().any(Option::is_none),
        };
        panels.chunks(PANELS).map(|panels| self.sheet(panels.to_vec(), goal, spared)).collect()
    }

    /// What is drawn of these points of the grid: the best one, else the least that may be taken, else the least.
    fn spot(&self, found: &Found<'_>, entrant: usize, network: usize, grid: Range<usize>, x: f64) -> Option<Spot> {
        let first = (entrant * self.networks.len() + network) * self.grid().points();
        let of_point = |at: usize| {
            let runs = found.runs[first + at]?;
            let allowed = found.goal.standing(runs) == Standing::Allowed;
            let answer = found.answers.iter().find(|one| (one.entrant, one.network) == (entrant, network));
            let best = answer.and_then(|answer| answer.best.as_ref()).is_some_and(|best| best.point == first + at);
            Some(Spot { x, found: estimate(runs, found.goal.metric)?, allowed, best })
        };
        let rank = |spot: &Spot| (!spot.best, !spot.allowed);
        grid.filter_map(of_point)
            .min_by(|one, other| rank(one).cmp(&rank(other)).then(one.found.mean.total_cmp(&other.found.mean)))
    }

    /// A panel with the spots of each entrant.
    fn panel(&self, title: String, spots: &[Vec<Spot>], along: &Along, goal: &Goal) -> Panel {
        let key = self.grid().keys().next().filter(|_| !self.grid().axes.is_empty());
        let (mut bands, mut marks) = (Vec::new(), Vec::new());
        for (entrant, spots) in spots.iter().enumerate() {
            let (color, dash) = (entrant % BLACK, DASHES[entrant % DASHES.len()]);
            let name = short(&self.entrants[entrant].name);
            // Names have room for all entrants beside each other.
            let beside = BESIDE * ((entrant as f64 + 0.5) / self.entrants.len() as f64 - 0.5);
            let x = |spot: &Spot| if let Along::Names(_) = along { spot.x + beside } else { spot.x };
            let at = |spot: &Spot| (x(spot), spot.found.mean);
            let allowed = || spots.iter().filter(|spot| spot.allowed);
            if let Along::Numbers(_) = along {
                let runs = || spots.chunk_by(|one, other| one.allowed && other.allowed).filter(|run| run[0].allowed);
                bands.push(Series::region("", color, runs().flat_map(strips).collect()));
                // A thin line through all, rings included, so that the dash tells whose they are.
                marks.push(Series::dashed("", color, dash, spots.iter().map(at).collect()).wide(THIN));
                let line = |run: &[Spot]| run.iter().map(at).chain([(f64::NAN, f64::NAN)]).collect::<Vec<_>>();
                marks.push(Series::dashed(name, color, dash, runs().flat_map(line).collect()));
                let best = spots.iter().filter(|spot| spot.best).map(at).collect();
                marks.push(Series::dots("", color, best, Vec::new()));
            } else {
                let number = (entrant + 1).to_string();
                let interval = |spot: &Spot| (x(spot), spot.found.mean, spot.found.within_95.unwrap_or(0.0));
                marks.push(Series::intervals(format!("{number}: {name}"), color, allowed().map(interval).collect()));
                let numbers = allowed().map(|_| number.clone()).collect();
                marks.push(Series::dots("", color, allowed().map(at).collect(), numbers));
            }
            let rings = spots.iter().filter(|spot| !spot.allowed).map(at).collect();
            marks.push(Series::rings("", color, rings));
        }
        let (log_x, categories) = match along {
            Along::Numbers(numbers) => (is_wide(numbers.iter().copied()), Vec::new()),
            Along::Names(names) => (false, names.clone()),
        };
        Panel {
            title,
            x_label: key.map(label).unwrap_or_default(),
            y_label: label(&METRICS[goal.metric].name()),
            log_x,
            categories,
            series: bands.into_iter().chain(marks).collect(),
            ..Panel::default()
        }
    }

    /// A figure of these panels, with names in the first one.
    fn sheet(&self, mut panels: Vec<Panel>, goal: &Goal, spared: Spared) -> Figure {
        let series = || panels.iter().flat_map(|panel| &panel.series);
        let means = || series().flat_map(means);
        // A stroke that reaches 0 has no end on a logarithmic axis; a band is cut.
        let log_y = is_wide(means()) && series().flat_map(strokes).all(|end| end > 0.0);
        let [low, high] = [f64::min, f64::max].map(|pick| means().reduce(pick));
        let y_range = low.zip(high).map(|(low, high)| {
            let lowest = if log_y { low / 2.0 } else { f64::NEG_INFINITY };
            let ends = series().flat_map(|series| strokes(series).into_iter().chain(edges(series)));
            let (low, high) = ends.fold((low, high), |(low, high), end| (low.min(end.max(lowest)), high.max(end)));
            let by = 0.06 * (high - low);
            if log_y { (low / 1.2, high * 1.2) } else { (low - by, high + by) }
        });
        let is_ring = |series: &Series| matches!(&series.shape, Shape::Rings(points) if !points.is_empty());
        let (ringed, banded) = (series().any(is_ring), panels.iter().all(|panel| panel.categories.is_empty()));
        for (at, panel) in panels.iter_mut().enumerate() {
            (panel.log_y, panel.y_range) = (log_y, y_range);
            panel.series.iter_mut().filter(|_| log_y).for_each(cut);
            if at > 0 {
                panel.series.iter_mut().for_each(|series| series.label.clear());
            } else if ringed {
                panel.series.push(Series::rings("may not be taken", BLACK, Vec::new()));
            }
        }
        Figure {
            caption: self.caption(goal, spared, ringed, banded),
            columns: if panels.len() > 1 && banded { 2 } else { 1 },
            share_x: banded,
            share_y: ShareY::All,
            panels,
            ..Figure::default()
        }
    }

    /// What the reader sees.
    fn caption(&self, goal: &Goal, spared: Spared, ringed: bool, banded: bool) -> String {
        let seeds = self.seeds();
        let mut text = format!(
            "Means of {}{seeds} seeds, {} s each, with their 95 % intervals (Student){}.",
            if spared.some { "up to " } else { "" },
            self.seconds(),
            if banded { " as bands" } else { "" }
        );
        if banded {
            text += " Dots: the best points";
            text += &if seeds > 1 { format!(", chosen on {} of the seeds.", seeds / 2) } else { ".".to_owned() };
        }
        if ringed {
            text += " Rings: unstable in a run, or where a hand lets go";
            for bound in &goal.bounds {
                let name = label(&METRICS[bound.metric].name());
                text += &format!(", or {} above {}", name[..1].to_lowercase() + &name[1..], bound.most);
            }
            text += ".";
        }
        text += " Without a mark: a run failed";
        if spared.all {
            text += ", or not run because not stable in every mode";
        }
        text + "."
    }
}

/// A name without the tables of its keys, no longer than a legend has room for.
fn short(name: &str) -> String {
    let part = |part: &str| part.split_once('.').filter(|_| part.contains('=')).map_or(part, |(_, key)| key).to_owned();
    let short = name.split(',').map(part).collect::<Vec<_>>().join(", ");
    if short.chars().count() <= LONGEST { short } else { short.chars().take(LONGEST - 1).chain(['…']).collect() }
}

/// Whether these numbers need a logarithmic axis.
fn is_wide(numbers: impl Iterator<Item = f64> + Clone) -> bool {
    let [least, most] = [f64::min, f64::max].map(|pick| numbers.clone().reduce(pick));
    least.zip(most).is_some_and(|(least, most)| least > 0.0 && most >= DECADE * least)
}

/// The band between neighbours.
fn strips(run: &[Spot]) -> Vec<Strip> {
    let side = |spot: &Spot| {
        let within = spot.found.within_95.unwrap_or(0.0);
        (spot.x, spot.found.mean - within, spot.found.mean + within)
    };
    run.windows(2).map(|pair| Strip { left: side(&pair[0]), right: side(&pair[1]) }).collect()
}

/// Of a band what a logarithmic axis can show: what reaches 0 goes to its lower edge.
fn cut(series: &mut Series) {
    let Shape::Region(strips) = &mut series.shape else { return };
    for strip in strips {
        for side in [&mut strip.left, &mut strip.right] {
            side.1 = side.1.max(f64::MIN_POSITIVE);
        }
    }
}

/// The means that a series shows.
fn means(series: &Series) -> Vec<f64> {
    let means: Vec<f64> = match &series.shape {
        Shape::Line { points, .. } | Shape::Rings(points) => points.iter().map(|(_, y)| *y).collect(),
        Shape::Intervals(points) => points.iter().map(|(_, y, _)| *y).collect(),
        _ => Vec::new(),
    };
    means.into_iter().filter(|mean| mean.is_finite()).collect()
}

/// The ends of the intervals that a series shows as strokes.
fn strokes(series: &Series) -> Vec<f64> {
    let Shape::Intervals(points) = &series.shape else { return Vec::new() };
    points.iter().flat_map(|(_, y, within)| [y - within, y + within]).collect()
}

/// The edges of its bands.
fn edges(series: &Series) -> Vec<f64> {
    let Shape::Region(strips) = &series.shape else { return Vec::new() };
    strips.iter().flat_map(|strip| [strip.left, strip.right]).flat_map(|(_, low, high)| [low, high]).collect()
}
