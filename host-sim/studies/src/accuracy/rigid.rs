//! A free rigid body ([`cohold_core::object::free_body`]) by number type and step: what it keeps, and by how much it turns late.
//!
//! **Kept**: a body of the size of a hand tumbles, turned nearly about its intermediate axis, nobody pushing: the largest change of its
//! energy and of its angular momentum in space as the body shows it, R·I·Ω, both relative. (What is stored of the momentum is kept to the bit.)
//!
//! **Late**: the axis of a symmetric top goes round its momentum at |L|/I, I its inertia across the axis (Euler's closed form); by how much
//! slower it goes here is the midpoint rule's, of second order in the step.
//!
//! Left out: what a step costs.

use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::object::free_body::{Flying, FreeBody, Wrench};
use cohold_core::object::rigid::Rotor;
use cohold_core::object::vector::Moving;
use cohold_report::Columns;
use rayon::prelude::*;

/// Of the body that tumbles.
const MASS_KG: f64 = 0.3;
/// Its principal moments of inertia, kg·m².
const INERTIA: [f64; 3] = [1e-3, 2e-3, 3.5e-3];
/// How it moves (m/s) and turns (rad/s, about its own axes) at first.
const MOVING: [f64; 3] = [0.01, -0.02, 0.015];
const TUMBLING: [f64; 3] = [0.02, 10.0, 0.01];
/// How the top moves (m/s) and turns (rad/s, about its own axes) at first.
const TOP: [f64; 3] = [2e-3, 2e-3, 1e-3];
const SPINNING: [f64; 3] = [0.0, 3.0, 20.0];
/// How long the top turns, s.
const TOP_S: f64 = 10.0;
/// Number types that are compared.
pub const TYPES: usize = 3;
/// Steps from look to look.
const LOOK: u32 = 100;

/// A number type at a step.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Number type of the body's state.
    pub number_type: &'static str,
    /// Control period of the run, ms.
    pub period_ms: f64,
    /// Largest relative change of energy.
    pub energy_drift: f64,
    /// Largest relative change of angular momentum.
    pub momentum_drift: f64,
    /// By how much slower the top's axis goes round than it should, relative.
    pub late: f64,
}

fn norm(parts: [f64; 3]) -> f64 {
    parts.into_iter().map(|part| part * part).sum::<f64>().sqrt()
}

fn dot(one: [f64; 3], other: [f64; 3]) -> f64 {
    one.into_iter().zip(other).map(|(one, other)| one * other).sum()
}

fn cross([ax, ay, az]: [f64; 3], [bx, by, bz]: [f64; 3]) -> [f64; 3] {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

/// Largest changes of energy and angular momentum over so long.
fn tumbled<S: Scalar>(seconds: f64, period_s: f64) -> [f64; 2] {
    let free = FreeBody::<S>::new(MASS_KG, 0.0, INERTIA, period_s);
    let axes = MOVING.map(|velocity| Motion::new(S::ZERO, S::from_f64(velocity)));
    let turning = free.rotor.turning([1.0, 0.2, -0.1, 0.3], TUMBLING);
    let mut state = Flying { moving: Moving::at(axes), turning };
    let shown = |state: &Flying<S>| {
        let body = free.rotor.velocity(&state.turning).map(S::to_f64);
        let carried = [0, 1, 2].map(|at| INERTIA[at] * body[at]);
        state.turning.rotation().map(|row| dot(row.map(S::to_f64), carried))
    };
    let (energy, momentum) = (free.energy_j(&state).to_f64(), shown(&state));
    let mut worst = [0.0_f64; 2];
    let looks = (seconds / period_s / f64::from(LOOK)).ceil() as u64;
    for _ in 0..looks {
        for _ in 0..LOOK {
            free.step(&mut state, &Wrench::default());
        }
        let now = shown(&state);
        let changed = (free.energy_j(&state).to_f64() / energy - 1.0).abs();
        let moved = norm([0, 1, 2].map(|at| now[at] - momentum[at])) / norm(momentum);
        worst = [worst[0].max(changed), worst[1].max(moved)];
    }
    worst
}

/// By how much slower than |L|/I the top's axis goes round.
fn late<S: Scalar>(period_s: f64) -> f64 {
    let rotor = Rotor::<S>::new(TOP, period_s);
    let mut state = rotor.turning([1.0, 0.0, 0.0, 0.0], SPINNING);
    let momentum = [0, 1, 2].map(|at| TOP[at] * SPINNING[at]);
    let about = momentum.map(|part| part / norm(momentum));
    // The body's axis begins along the third of space; round the momentum it begins along `first`.
    let along = about[2];
    let first = [-along * about[0], -along * about[1], 1.0 - along * about[2]];
    let (first, second) = (first.map(|part| part / norm(first)), cross(about, first));
    let second = second.map(|part| part / norm(second));
    let steps = (TOP_S / period_s).round();
    let (mut angle, mut before) = (0.0, 0.0);
    for _ in 0..steps as u64 {
        rotor.coast(&mut state);
        let axis = state.rotation().map(|row| row[2].to_f64());
        let at = dot(axis, second).atan2(dot(axis, first));
        angle += (at - before + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        before = at;
    }
    1.0 - angle / (steps * period_s * norm(momentum) / TOP[0])
}

fn row<S: Scalar>(seconds: f64, period_ms: f64) -> Row {
    let period_s = 1e-3 * period_ms;
    let [energy_drift, momentum_drift] = tumbled::<S>(seconds, period_s);
    Row { number_type: S::NAME, period_ms, energy_drift, momentum_drift, late: late::<S>(period_s) }
}

/// Every number type at each of these steps, over so long; `step` after each.
pub fn study(seconds: f64, periods_ms: &[f64], step: &(dyn Fn() + Sync)) -> Vec<Row> {
    let types: [fn(f64, f64) -> Row; TYPES] = [row::<f32>, row::<f64>, row::<Fixed>];
    let rows: Vec<_> = periods_ms.iter().flat_map(|period_ms| types.map(|of| (of, *period_ms))).collect();
    rows.into_par_iter().map(|(of, period_ms)| of(seconds, period_ms)).inspect(|_| step()).collect()
}

/// The rows as a table.
pub fn columns(rows: &[Row]) -> Columns {
    Columns::of(rows)
        .value("number_type", |row| row.number_type)
        .means("what the body computes in")
        .value("period_ms", |row| row.period_ms)
        .means("step")
        .power("energy_drift", 1, |row| row.energy_drift)
        .means("largest change of energy over the time, relative")
        .power("momentum_drift", 1, |row| row.momentum_drift)
        .means("largest change of the angular momentum in space over the time, as the body shows it, relative")
        .power("late", 1, |row| row.late)
        .means("by how much slower than the closed form a symmetric top's axis goes round its momentum, relative; below 0 faster")
        .done()
}
