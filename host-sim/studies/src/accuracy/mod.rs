//! Speed against error: every numerical choice, measured against a reference that does not share its way of computing.
//!
//! | module | chooses among | reference |
//! |---|---|---|
//! | `numbers` | f32, f64, I32F32; where sums are kept ([`sums`]) | continuous control (matrix exponential); the same peer in double-double |
//! | `whole_peer` | integrator × decode × control rate | continuous control (matrix exponential); of a self-timed [`mod@line`] what it converges to |
//! | [`integrators`] | forward Euler, semi-implicit, exact, midpoint, backward Euler | closed forms of a contact and of a push |
//! | [`decodes`] | delayed, implicit | closed form of the line's end |
//! | [`filters`] | exact, forward Euler, bilinear | the continuous filter |
//! | [`mechanisms`] | micromath, libm; f32, f64, I32F32 | loop closure by Newton's method in double-double |
//! | [`estimators`] | measured, difference, filtered, adaptive | the motion itself |
//!
//! Beside these choices of a peer stand [`rigid`], what a free rigid body keeps, and [`timed`], errors with times of this machine.
//!
//! A family asks one question in one or more [`Comparison`]s; each has an error with its unit, instructions beside it, and
//! a front of its own. Insights are sentences with the numbers of this run in them; what they claim, the tests hold.

pub mod continuous;
pub mod counts;
pub mod decodes;
pub mod estimators;
pub mod filters;
pub mod integrators;
pub mod line;
pub mod mechanisms;
mod numbers;
pub mod pair;
pub mod picture;
pub mod rigid;
pub mod sums;
pub mod timed;
mod whole_peer;

use cohold_core::settings::Refused;
use cohold_report::Columns;
use rayon::prelude::*;
use serde::Serialize;

/// A choice with its error and its cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Name of the choice.
    pub choice: String,
    /// How wrong it is, in the comparison's unit.
    pub error: f64,
    /// Cost of the choice, in the family's unit; `None` where nobody has counted it, which keeps it off the front.
    pub instructions: Option<u64>,
    /// No other choice of the comparison is as good in one and better in the other.
    pub on_front: bool,
    /// For pictures: the choices that belong together, such as one scheme at several rates; empty for none.
    #[serde(skip)]
    pub series: String,
    /// For pictures: what the choice is called within its series.
    #[serde(skip)]
    pub label: String,
}

/// Choices that can be compared with each other.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Circumstances of the comparison.
    pub title: String,
    /// The error that is compared.
    pub error: String,
    /// Its unit; `1` for a pure number.
    pub unit: &'static str,
    /// The choices with their errors and costs.
    pub points: Vec<Point>,
}

impl Comparison {
    /// Compares (choice, error, instructions if they were counted).
    pub fn new(
        title: impl Into<String>,
        error: impl Into<String>,
        unit: &'static str,
        measured: Vec<(String, f64, Option<u64>)>,
    ) -> Self {
        let counted = |(_, error, count): &(String, f64, Option<u64>)| count.map(|count| (*error, count as f64));
        let front =
            pareto_front(&measured.iter().map(|one| counted(one).unwrap_or((f64::NAN, 0.0))).collect::<Vec<_>>());
        let points = measured
            .into_iter()
            .zip(front)
            .map(|((choice, error, instructions), on_front)| {
                let (series, label) = (String::new(), choice.clone());
                Point { choice, error, instructions, on_front, series, label }
            })
            .collect();
        Self { title: title.into(), error: error.into(), unit, points }
    }

    /// Compares by one of several errors that were measured at once.
    fn of<E>(
        title: &str,
        error: &str,
        unit: &'static str,
        measured: &[(String, E, Option<u64>)],
        pick: impl Fn(&E) -> f64,
    ) -> Self {
        let points = measured.iter().map(|(choice, errors, count)| (choice.clone(), pick(errors), *count)).collect();
        Self::new(title, error, unit, points)
    }

    /// This comparison with choices that are named `SERIES, LABEL` drawn as series.
    #[must_use]
    pub fn in_series(mut self) -> Self {
        for point in &mut self.points {
            if let Some((series, label)) = point.choice.rsplit_once(", ") {
                (point.series, point.label) = (series.to_owned(), label.to_owned());
            }
        }
        self
    }

    /// The error of the choice with this name; NaN where there is none.
    pub fn error_of(&self, choice: &str) -> f64 {
        self.points.iter().find(|point| point.choice == choice).map_or(f64::NAN, |point| point.error)
    }

    /// The instructions of the choice with this name; 0 where there is none, or none were counted.
    pub fn instructions_of(&self, choice: &str) -> u64 {
        self.points.iter().find(|point| point.choice == choice).and_then(|point| point.instructions).unwrap_or(0)
    }
}

/// One numerical choice that a user has.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Family {
    /// Short name of the family.
    pub name: &'static str,
    /// Heading of the family's page.
    pub title: &'static str,
    /// The motion in which the family is measured.
    pub motion: String,
    /// The reference that it is measured against.
    pub reference: &'static str,
    /// What instructions are counted for.
    pub instructions_per: &'static str,
    /// What was measured, comparison by comparison.
    pub comparisons: Vec<Comparison>,
    /// Index of the comparison that says most.
    #[serde(skip)]
    pub headline: usize,
    /// What a user should take from it.
    pub insight: String,
}

type Measure = fn(counts::Processor) -> Result<Family, Refused<'static>>;

/// Every family, in the order of reports.
const FAMILIES: [Measure; 7] = [
    numbers::measure,
    whole_peer::measure,
    integrators::measure,
    decodes::measure,
    filters::measure,
    mechanisms::measure,
    estimators::measure,
];

/// Measures every family, with the instructions of this processor.
///
/// # Errors
/// The first key that is out of range or impossible beside the others.
pub fn families(processor: counts::Processor) -> Result<Vec<Family>, Refused<'static>> {
    FAMILIES.par_iter().map(|measure| measure(processor)).collect()
}

/// The choices of these families: all, or only those that are shown to people, which are those on a front and the first of
/// every series.
pub fn columns<'a>(families: impl IntoIterator<Item = &'a Family>, all: bool) -> Columns {
    let mut rows = Vec::new();
    for family in families {
        for comparison in &family.comparisons {
            let leads = |point: &&Point| {
                let first = comparison.points.iter().find(|other| other.series == point.series);
                all || point.on_front || point.series.is_empty() || first == Some(*point)
            };
            rows.extend(comparison.points.iter().filter(leads).map(|point| (family, comparison, point)));
        }
    }
    let per = rows.first().map_or("", |(family, ..)| family.instructions_per.split(':').next().unwrap_or_default());
    Columns::of(&rows)
        .data("family", |row| row.0.name)
        .means("which numerical choice")
        .value("comparison", |row| row.1.title.as_str())
        .means("under which circumstances")
        .value("measure", |row| row.1.error.as_str())
        .means("which error")
        .value("choice", |row| row.2.choice.as_str())
        .means("what is chosen")
        .significant("error", 3, |row| row.2.error)
        .means("how wrong it is, in the unit of the next column")
        .value("unit", |row| row.1.unit)
        .means("unit of the error; 1 for a pure number")
        .value("instructions", |row| row.2.instructions)
        .means("instructions of one call or tick, as its family counts them; nothing where nobody has counted")
        .head(&format!("instructions per {per}"))
        .value("on_front", |row| row.2.on_front)
        .means("whether no other choice of the comparison is as good in one of the two and better in the other")
        .head("on Pareto front")
        .done()
}

/// Errors within this factor of each other are the same.
const SAME_ERROR: f64 = 1.01;
/// Instruction counts within this factor of each other are the same: the tolerance to which they are reviewed.
const SAME_COUNT: f64 = 1.02;

/// For every (error, instructions) whether nobody beats it: the Pareto front. What has no error to speak of (NaN) is not on it.
///
/// A choice is beaten where another one is no worse in both and clearly better in one. "Clearly" is what the numbers can
/// carry: errors closer than `SAME_ERROR` and counts closer than `SAME_COUNT` are equal, so that f64 is not on a front
/// for a hundredth of a per cent. Being beaten this way has no circles (log error / log 1.01 + log count / log 1.02 falls
/// along it), so a front is never empty.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<bool> {
    points.iter().map(|point| !point.0.is_nan() && !points.iter().any(|other| beats(*other, *point))).collect()
}

/// Whether `a` is no worse than `b` in error and instructions, and clearly better in one.
fn beats(a: (f64, f64), b: (f64, f64)) -> bool {
    let no_worse = a.0 <= b.0 * SAME_ERROR && a.1 <= b.1 * SAME_COUNT;
    no_worse && (a.0 * SAME_ERROR < b.0 || a.1 * SAME_COUNT < b.1)
}

pub(crate) fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0_u64), |(sum, count), value| (sum + value * value, count + 1));
    (sum / count as f64).sqrt()
}

/// The largest magnitude; NaN if there is one.
pub(crate) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    let further =
        |largest: f64, value: f64| if value.abs() > largest || value.is_nan() { value.abs() } else { largest };
    values.into_iter().fold(0.0, further)
}
