//! Mass, friction and delay of a joint from how it moves under known duties. Needs scale, sign and, for newtons, motor constant.
//!
//! m·a + b·v + c·sgn(v) + o = d(t − τ), d the duty, all else in units of full duty. Acceleration is never formed: both sides
//! are weighted with a smooth window φ that vanishes at its ends, with its first three derivatives, and integrated by parts,
//!
//! ```text
//! m·∫xφ″ − b·∫xφ′ + c·∫sgn(v)φ + o·∫φ = ∫d(t − τ)φ,
//! ```
//!
//! so that rounding to counts and noise are averaged instead of amplified (modulating functions; Shinbrot 1957). Every window of
//! every run is one row of a least-squares problem; windows do not overlap, so their errors are independent. τ enters
//! by its derivative and is found by repeating the fit around the last one. The duty stands from tick to tick, and its integral
//! is exact.
//!
//! φ = sin⁴(π·t/L), L the length of a window. Windows in which the joint stands for more than a quarter of the time are left
//! out: friction at rest is any force up to c.
//!
//! **Cogging.** − s·sin(2πq/p) − r·cos(2πq/p) is added on the left, q the place of the joint, which its index has set.
//!
//! Limits: one mass; c the same both ways and at all speeds; τ constant; of cogging the first harmonic. Intervals hold noise, not what the model lacks.

use std::{array::from_fn, f64::consts::PI, f64::consts::TAU};

use cohold_core::device::probe::End;
use cohold_core::settings::Settings;
use cohold_sim::student::student_95;

use super::board::{Board, Joint, Run, Tick, run, say, seen, settings};
use super::least_squares::solve;
use super::{Estimate, Found, Person, Task};
use crate::Error;

const WINDOW_S: f64 = 0.05;
/// Velocity is judged over so many ticks to either side.
const REACH: usize = 4;
/// Below so many counts over that the joint may be standing.
const STANDING_COUNTS: f64 = 2.0;
/// Fewest windows that make a fit.
const FEWEST: usize = 20;
/// Unknowns of a fit without cogging, which has two more.
const PLAIN: usize = 5;
const COGGED: usize = 7;

/// What the motion says, in fractions of full duty per SI unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Duty per acceleration, 1/(m/s²).
    pub mass: Estimate,
    /// Duty per velocity, 1/(m/s).
    pub damping: Estimate,
    /// Duty of dry friction.
    pub dry: Estimate,
    /// By how much force follows duty, s.
    pub delay_s: Estimate,
    /// Number of windows that the fit used.
    pub windows: usize,
}

/// φ and its derivatives, and its integral from 0, at t of a window of length L.
fn window(t: f64, length: f64) -> [f64; 4] {
    let w = PI / length;
    let (s2, c2) = (2.0 * w * t).sin_cos();
    let (s4, c4) = (4.0 * w * t).sin_cos();
    [
        (3.0 - 4.0 * c2 + c4) / 8.0,
        w * (2.0 * s2 - s4) / 2.0,
        w * w * 2.0 * (c2 - c4),
        (3.0 * t - 2.0 * s2 / w + s4 / (4.0 * w)) / 8.0,
    ]
}

/// Sign of the velocity at every tick; 0 where the joint may be standing.
fn signs(counts: &[f64]) -> Vec<f64> {
    (0..counts.len())
        .map(|n| {
            let moved = counts[(n + REACH).min(counts.len() - 1)] - counts[n.saturating_sub(REACH)];
            if moved.abs() <= STANDING_COUNTS { 0.0 } else { moved.signum() }
        })
        .collect()
}

/// The rows of a run around the delay `delay_s`: regressors and right-hand side. With cogging it has so many radians to a metre of the hand.
fn rows(run: &Run, joint: &Joint, per_m: f64, delay_s: f64) -> Vec<([f64; COGGED], f64)> {
    let period = joint.period_s;
    let ticks = ((WINDOW_S / period).round() as usize).max(8);
    let length = ticks as f64 * period;
    let signs = signs(&run.counts);
    // A duty from before the window still acts in it, and one at its end hardly does.
    let lead = (delay_s / period).ceil().max(0.0) as usize + 1;
    let (mut rows, mut start) = (Vec::new(), lead);
    while start + ticks < run.counts.len() {
        let span = start..start + ticks + 1;
        let still = signs[span.clone()].iter().filter(|sign| **sign == 0.0).count();
        if 4 * still <= ticks {
            let (mut row, mut right) = ([0.0; COGGED], 0.0);
            let origin = run.counts[start];
            for n in span {
                let [phi, first, second, _] = window((n - start) as f64 * period, length);
                let x = (run.counts[n] - origin) * joint.m_per_count;
                row[0] += period * x * second;
                row[1] -= period * x * first;
                row[2] += period * signs[n] * joint.m_per_count.signum() * phi;
                row[3] += period * phi;
                let angle = per_m * (run.start_m + run.counts[n] * joint.m_per_count);
                row[5] -= period * angle.sin() * phi;
                row[6] -= period * angle.cos() * phi;
            }
            for n in start - lead..start + ticks + 1 {
                // The duty of tick n acts from then on, late by the delay, until that of the next does.
                let from = (n as f64 - start as f64) * period + delay_s;
                let [early, late] = [from, from + period].map(|t| t.clamp(0.0, length));
                right += run.duties[n] * (window(late, length)[3] - window(early, length)[3]);
                // Its derivative by the delay goes to the other side, with its unknown.
                row[4] -= run.duties[n] * (window(late, length)[0] - window(early, length)[0]);
            }
            rows.push((row, right));
        }
        start += ticks;
    }
    rows
}

/// Fits the runs of a joint.
///
/// # Errors
/// Too little motion to determine mass and friction.
pub fn fit(runs: &[Run], joint: &Joint) -> Result<Motion, Error> {
    let ([mass, damping, dry, _, delay_s], windows) = unknowns::<PLAIN>(runs, joint, 0.0)?;
    Ok(Motion { mass, damping, dry, delay_s, windows })
}

/// The unknowns of the runs of a joint, and the number of windows that the fit used.
fn unknowns<const N: usize>(runs: &[Run], joint: &Joint, per_m: f64) -> Result<([Estimate; N], usize), Error> {
    let mut delay_s = 0.0;
    let mut found = [(0.0, 0.0); N];
    let mut windows = 0;
    for _ in 0..6 {
        let all = runs.iter().flat_map(|run| rows(run, joint, per_m, delay_s));
        let all: Vec<_> = all.map(|(row, right)| (from_fn(|at| row[at]), right)).collect();
        windows = all.len();
        cohold_sim::refuse_if!(
            windows < FEWEST,
            "it moved in {windows} windows of {WINDOW_S} s, which is too little: at least {FEWEST}; let go of it, or raise \
                 probe.max_duty, probe.max_travel_counts or probe.max_s"
        );
        found = solve(&all)
            .ok_or("the motion does not tell mass, friction and delay apart: other frequencies are needed")?;
        delay_s = (delay_s + found[4].0).clamp(-0.002, 0.02);
    }
    let t = student_95((windows - N) as u32);
    let mut estimates = found.map(|(value, error)| Estimate::new(value, t * error));
    estimates[4].value = delay_s;
    Ok((estimates, windows))
}

/// Frequencies that a joint is moved with, Hz: apart enough to tell mass, friction and delay from each other.
const FREQUENCIES_HZ: [f64; 5] = [4.0, 6.0, 9.0, 13.0, 18.0];
/// Weakest duty that is tried, as a fraction of what a probe may.
const WEAKEST: f64 = 0.02;

/// Moves joint `number` with cosines of these frequencies, as hard as the board's limits let it, and gives the runs.
pub(super) fn excite(
    board: &mut dyn Board,
    settings: &Settings,
    number: u32,
    frequencies_hz: &[f64],
) -> Result<Vec<Run>, Error> {
    let mut runs = Vec::new();
    let limits = &settings.probe;
    let most = limits.max_duty.min(settings.motor.max_duty);
    let time_s = limits.max_s.min(2.0);
    for hertz in frequencies_hz {
        let mut duty = most;
        while duty > WEAKEST * most {
            let run = run(board, number, &format!("probe {number} sine {duty:.4} {time_s} {hertz}"))?;
            match run.end {
                End::Done => {
                    runs.push(run);
                    break;
                }
                End::Stopped => return Err("the probe was stopped".into()),
                _ => {}
            }
            // Too far or too fast: travel and speed go with the duty.
            duty *= 0.6;
            board.ticks(0.3)?;
        }
    }
    Ok(runs)
}

/// Moves joint `number` and fits it.
///
/// # Errors
/// The board refused a motion, or the fit does not determine the numbers.
pub fn identify(board: &mut dyn Board, number: u32) -> Result<(Motion, Joint, Settings), Error> {
    let settings = settings(board)?;
    let joint = Joint::of(&settings, number)?;
    let runs = excite(board, &settings, number, &FREQUENCIES_HZ)?;
    let mut motion = fit(&runs, &joint)?;
    if settings.motor.reversed {
        for estimate in [&mut motion.mass, &mut motion.damping, &mut motion.dry] {
            *estimate = estimate.times(-1.0);
        }
    }
    cohold_sim::refuse_if!(motion.mass.value <= 0.0, "the joint speeds up against its motor: `calibrate sign` first");
    cohold_sim::refuse_if!(
        motion.mass.within > 0.25 * motion.mass.value,
        "the motion tells the mass only to {:.0} %: let go of it, or raise probe.max_duty or probe.max_travel_counts",
        100.0 * motion.mass.within / motion.mass.value
    );
    Ok((motion, joint, settings))
}

/// Force at the hand for full duty, N, as the settings have it.
pub fn newton_per_duty(settings: &Settings, joint: &Joint) -> f64 {
    settings.motor.newton_or_newton_metre_per_a * settings.motor.full_scale_a / joint.lever.abs()
}

/// Moves joint `number` and gives its friction: viscous and dry, N at the hand.
///
/// # Errors
/// The board refused a motion, or the fit does not determine the friction.
pub fn friction(board: &mut dyn Board, number: u32) -> Result<Vec<Found>, Error> {
    let (motion, joint, settings) = identify(board, number)?;
    let newton = newton_per_duty(&settings, &joint);
    // A friction below zero is none, as far as the data go.
    let at_least_none = |estimate: Estimate| Estimate { value: estimate.value.max(0.0), ..estimate };
    for (name, estimate) in [("viscous", motion.damping), ("dry", motion.dry)] {
        cohold_sim::refuse_if!(
            estimate.value < -3.0 * estimate.within,
            "{name} friction comes out at {}: something else pushes",
            estimate.times(newton)
        );
    }
    Ok(vec![
        Found::number("device.damping_n_s_per_m", at_least_none(motion.damping.times(newton)), "N·s/m"),
        Found::number("plant.coulomb_n", at_least_none(motion.dry.times(newton)), "N"),
    ])
}

/// Moves joint `number` and gives its mass, kg at the hand, and by how much force follows duty.
///
/// # Errors
/// The board refused a motion, or the fit does not determine the mass.
pub fn inertia(board: &mut dyn Board, number: u32) -> Result<Vec<Found>, Error> {
    let (motion, joint, settings) = identify(board, number)?;
    let newton = newton_per_duty(&settings, &joint);
    let delay = motion.delay_s.times(1.0 / joint.period_s);
    cohold_sim::refuse_if!(
        delay.value > 1.0 + delay.within,
        "force follows duty by {delay} control periods, more than the 1 that a scene can have"
    );
    Ok(vec![
        Found::number("device.mass_kg", motion.mass.times(newton), "kg"),
        Found::number("device.force_delay_ticks", Estimate { value: delay.value.clamp(0.0, 1.0), ..delay }, "ticks"),
    ])
}

/// Largest ratio of an amplitude to the interval of its two parts that noise alone has in 19 of 20 calibrations: √(2·ln 20)/1.96.
const NOISE: f64 = 1.25;

/// Moves joint `number`, the only one, and gives amplitude and place of a cogging of the period that the board was set to. First the person moves
/// the joint past its index, from which the place counts. An amplitude of 0 is one that was not measured.
///
/// # Errors
/// The board refused a motion, the index was not met, or the fit does not determine the numbers.
pub fn cogging(board: &mut dyn Board, person: &mut dyn Person, number: u32) -> Result<Vec<Found>, Error> {
    let settings = settings(board)?;
    let joint = Joint::of(&settings, number)?;
    let fits = settings.encoder.index && settings.axis.count == 1 && settings.scale.position == 1.0;
    settings.all_fit(&[("encoder.index", fits, "true, on one axis with no scale")])?;
    person.please(&Task::HoldButton)?;
    say(board, "home")?;
    person.please(&Task::LetGoOfButton)?;
    let home = seen(board)?;
    person.please(&Task::PassIndex { joint: number })?;
    let met = seen(board)?;
    // The index moves the joint's place and not its counter, which has 16 bits.
    let apart = |tick: Tick| f64::from(tick.at_m) / joint.m_per_count - f64::from(tick.counts[0]);
    cohold_sim::refuse_if!(
        (apart(met) - apart(home)).round().rem_euclid(65536.0) == 0.0,
        "the index was not met: move the joint past it, or look at its wire"
    );
    let mut runs = excite(board, &settings, number, &FREQUENCIES_HZ)?;
    runs.iter_mut().for_each(|run| run.start_m -= f64::from(home.at_m));
    let per_unit = TAU / settings.motor.cogging_period_m_or_rad;
    let ([.., sine, cosine], _) = unknowns::<COGGED>(&runs, &joint, per_unit / joint.lever)?;
    let reversed = if settings.motor.reversed { -1.0 } else { 1.0 };
    let full = reversed * settings.motor.newton_or_newton_metre_per_a * settings.motor.full_scale_a;
    let [sine, cosine] = [sine, cosine].map(|part| part.times(full));
    let value = sine.value.hypot(cosine.value);
    let within = sine.within.max(cosine.within);
    let force = |value| Found::number("plant.cogging_n_or_n_m", Estimate::new(value, within), "N or N·m");
    if value < NOISE * within {
        return Ok(vec![force(0.0)]);
    }
    let at = Estimate::new(-cosine.value.atan2(sine.value), within / value).times(1.0 / per_unit);
    let place = |key| Found::number(key, at, "m or rad");
    Ok(vec![force(value), place("plant.cogging_at_m_or_rad"), place("motor.cogging_at_m_or_rad")])
}
