//! Largest stable stiffness against communication delay, one curve for each place, and against the sampling period.
//!
//! Stiffness is scanned from 1/16 to 8 times its closed form ([`super::closed`]) in steps of 15 %, pockets are followed,
//! and every crossing is closed in by bisection; the largest stable stiffness is the first crossing. Where there is none,
//! the scan goes on upwards, three times by a factor of 8: heavy objects hardly feel a delay of their own. Where even a
//! thousandth of the closed form is unstable, the largest stiffness is 0.
//!
//! While a delay is swept the sampling period is either given or, to show the delay alone, a fortieth of the delay: what
//! sampling adds is then 2.5 %, on every point alike.

use cohold_core::names::Choice;
use cohold_report::Columns;
use rayon::prelude::*;
use serde::Serialize;

use super::closed::largest_stiffness;
use super::{Place, Renderer, Rendering};
use crate::error::Error;
use crate::limit::Limit;
use crate::search::crossings;

/// Samples in a delay, where the sampling shall not matter.
pub const SAMPLES_PER_DELAY: f64 = 40.0;

/// Delays and periods of the maps, s: from the stiffness of a rigid object to the end of the paper's axes.
pub const RANGE_S: [f64; 2] = [1e-3, 80e-3];

/// Points of a curve.
pub const POINTS: usize = 32;

/// Stiffness to 0.1 %.
const TOLERANCE: f64 = 1e-3;

/// One point of a curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Delay or sampling period, s.
    pub time_s: f64,
    /// The first crossing, N/m; absent where every stiffness looked at is stable, 0 where none is.
    pub largest_stiffness_n_per_m: Option<f64>,
    /// Largest stable stiffness in closed form, N/m.
    pub closed_form_n_per_m: f64,
    /// All crossings of the stiffness, ascending, N/m.
    pub crossings: Vec<f64>,
}

impl Point {
    /// Where stability ends and begins in turn, N/m: the crossings, after 0 where even the softest contact is unstable.
    pub fn edges(&self) -> Vec<f64> {
        let softest = self.largest_stiffness_n_per_m.filter(|largest| *largest == 0.0);
        softest.into_iter().chain(self.crossings.iter().copied()).collect()
    }
}

/// What a curve is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sweep {
    /// Delay at one place.
    Delay(Place),
    /// Sampling period, no delay.
    Period,
}

/// One curve of a map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// The delay or the sampling period that is swept.
    pub sweep: Sweep,
    /// The object is a wall.
    pub wall: bool,
    /// Points of the curve, ascending in time.
    pub points: Vec<Point>,
}

/// The stiffness around which to look, N/m, of a scene that can be looked at.
fn scale(rendering: &Rendering) -> Result<f64, Error> {
    rendering.check()?;
    let near = largest_stiffness(rendering);
    Error::within("damping over delay", near, [1e-9, 1e12], "N/m")?;
    Ok(near)
}

/// Whether both maps of the scene can be made: better said before the work than in the middle of it.
///
/// # Errors
/// A number that is out of range, or a delay that the sampled map cannot hold.
pub fn check(base: &Rendering, sampling_s: Option<f64>) -> Result<(), Error> {
    for (base, sweep) in sweeps(base) {
        for time_s in RANGE_S {
            scale(&at(&base, sweep, time_s, sampling_s))?;
        }
    }
    Ok(())
}

/// Every crossing of the contact stiffness, N/m.
///
/// # Errors
/// A number that is out of range, or eigenvalues that do not converge.
pub fn stiffness_limit(rendering: &Rendering) -> Result<Limit, Error> {
    let near = scale(rendering)?;
    let fifths = |octaves: std::ops::RangeInclusive<i32>| {
        (5 * octaves.start()..=5 * octaves.end()).map(|fifth| f64::from(fifth) / 5.0).collect::<Vec<_>>()
    };
    let mut limit = scan(rendering, near, &[vec![-10.0, -7.0], fifths(-4..=3)].concat())?;
    for octave in [3, 6, 9] {
        if limit.stable_at_start && limit.crossings.is_empty() {
            let evaluations = limit.evaluations;
            limit = scan(rendering, near, &fifths(octave..=octave + 3))?;
            limit.evaluations += evaluations;
        }
    }
    Ok(limit)
}

/// Crossings among `near` times 2 to the power of each of `octaves`.
fn scan(rendering: &Rendering, near: f64, octaves: &[f64]) -> Result<Limit, Error> {
    let points: Vec<f64> = octaves.iter().map(|octave| near * octave.exp2()).collect();
    let found = crossings(&points, false, TOLERANCE, |renderer: &mut Renderer, stiffness, radii| {
        radii.push(renderer.polar(rendering, stiffness)?);
        Ok(())
    })?;
    Ok(Limit::new(found, &points))
}

/// The first crossing, N/m; see [`Point::largest_stiffness_n_per_m`].
pub fn first(limit: &Limit) -> Option<f64> {
    if limit.stable_at_start { limit.crossings.first().copied() } else { Some(0.0) }
}

/// [`first`] of [`stiffness_limit`], infinite if no stiffness is unstable, N/m.
///
/// # Errors
/// As [`stiffness_limit`].
pub fn largest(rendering: &Rendering) -> Result<f64, Error> {
    Ok(first(&stiffness_limit(rendering)?).unwrap_or(f64::INFINITY))
}

/// The scene of one point of a curve; `sampling_s` is the sampling period while a delay is swept, if it is given.
pub fn at(base: &Rendering, sweep: Sweep, time_s: f64, sampling_s: Option<f64>) -> Rendering {
    let mut rendering = *base;
    match sweep {
        Sweep::Period => rendering.period_s = time_s,
        Sweep::Delay(place) => {
            rendering.period_s = sampling_s.unwrap_or(time_s / SAMPLES_PER_DELAY);
            rendering = rendering.delayed(place, time_s);
        }
    }
    rendering
}

/// One curve; `done` is called once for every point, from any thread.
///
/// # Errors
/// A number that is out of range, or eigenvalues that do not converge.
pub fn curve(base: &Rendering, sweep: Sweep, sampling_s: Option<f64>, done: impl Fn() + Sync) -> Result<Curve, Error> {
    let [from, to] = RANGE_S;
    let point = |at_point: usize| {
        let time_s = from * (to / from).powf(at_point as f64 / (POINTS - 1) as f64);
        let rendering = at(base, sweep, time_s, sampling_s);
        let limit = stiffness_limit(&rendering)?;
        done();
        Ok(Point {
            time_s,
            largest_stiffness_n_per_m: first(&limit),
            closed_form_n_per_m: largest_stiffness(&rendering),
            crossings: limit.crossings,
        })
    };
    let points = (0..POINTS).into_par_iter().map(point).collect::<Result<_, Error>>()?;
    Ok(Curve { sweep, wall: base.object.is_none(), points })
}

/// The curves of both maps: delay at each of the four places against the object, at the first against a wall, and the
/// sampling period against both. With a wall for an object, only what a wall can feel.
pub fn sweeps(base: &Rendering) -> Vec<(Rendering, Sweep)> {
    let wall = Rendering { object: None, ..*base };
    let mut sweeps = Vec::new();
    if base.object.is_some() {
        sweeps.extend(Place::ALL.iter().map(|place| (*base, Sweep::Delay(*place))));
        sweeps.push((*base, Sweep::Period));
    }
    sweeps.extend([Place::DeviceToCollision, Place::CollisionToDevice].map(|place| (wall, Sweep::Delay(place))));
    sweeps.push((wall, Sweep::Period));
    sweeps
}

/// One row for every crossing: place (1…4, 0 for the sampling period), wall, delay or period, stiffness, whether it is
/// stable just below, and the closed form. Where even the softest contact is unstable, a first row says so with stiffness 0.
pub fn table(curves: &[Curve]) -> Columns {
    let mut rows = Vec::new();
    for curve in curves {
        for point in &curve.points {
            rows.extend(point.edges().into_iter().enumerate().map(|(at, crossing)| (curve, point, at, crossing)));
        }
    }
    let place = |curve: &Curve| match curve.sweep {
        Sweep::Delay(place) => place as usize + 1,
        Sweep::Period => 0,
    };
    Columns::of(&rows)
        .value("place", |row| place(row.0))
        .means("where the delay is: 1 to 4, in the order of the paper; 0 where the sampling period is swept")
        .value("wall", |row| row.0.wall)
        .means("whether the object is a wall")
        .value("time_s", |row| row.1.time_s)
        .means("delay or sampling period")
        .value("stiffness_n_per_m", |row| row.3)
        .means("contact stiffness at which stability ends or begins; 0 where even the softest contact is unstable")
        .value("stable_below", |row| row.2 % 2 == 0)
        .means("whether softer contacts, down to the crossing before, are stable")
        .value("closed_form_n_per_m", |row| row.1.closed_form_n_per_m)
        .means("largest stable stiffness in closed form")
        .done()
}
