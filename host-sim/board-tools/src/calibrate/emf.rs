//! A motor's constant by the voltage that it makes by moving: what is volts per metre per second is newtons per ampere, without a gauge.
//!
//! p·u − R·Δi/((1 − a)·N) = R·s + k·v + b·sgn(i) + o, tick by tick, while the joint moves under slow cosines of current; as of a winding's
//! ([`super::winding`]), v what the encoder says, p what pulses do to samples (`pulses`), b the
//! bridge's dead time. In Δi, p and a are the settings' R and L, for what they add goes with v where the joint is nothing but a mass. Every quarter of a second is fitted by itself; the interval is Student's of what they give.
//!
//! k is in the encoder's metres where a gauge's is in newtons: a scale that is wrong by a factor is wrong in one of them only, and a mass, whose
//! constant goes the other way with the scale, shows it twice. So [`against`] compares.
//!
//! Limits: as good as the supply's voltage is measured, which is not in the interval.

use cohold_core::{device::current::PWM_PERIOD_S, settings::Settings};

use super::board::{Board, Joint, Run, settings};
use super::least_squares::solve;
use super::winding::{MotorReading, pulses};
use super::{Estimate, motion};
use crate::Error;

/// Slow, so that the joint gets fast, Hz.
const FREQUENCIES_HZ: [f64; 2] = [4.0, 6.0];
/// Length of what is fitted by itself, s.
const STRETCH_S: f64 = 0.25;
/// Fewest stretches that make an estimate.
const FEWEST: usize = 4;
/// Share of the constant that the interval holds for the model: a voltage that is constant through each PWM period, a joint that moves as it was
/// read at the tick.
const MODEL: f64 = 0.002;
/// How far apart two ways to the constant may be, beyond their intervals.
pub const APART: f64 = 0.1;

/// Volts per metre or radian per second of the joint in every stretch of a run.
fn constants(run: &Run, joint: &Joint, settings: &Settings) -> Vec<f64> {
    let along = if settings.motor.reversed { -1.0 } else { 1.0 };
    let per_count = along * joint.m_per_count / joint.lever / joint.period_s;
    let seen: Vec<MotorReading> =
        run.stage.iter().map(|stage| MotorReading::of(stage, settings, joint.number)).collect();
    // What a tick measured is of the time since the one before.
    let periods = joint.period_s / PWM_PERIOD_S;
    let passes = settings.motor.resistance_ohm * PWM_PERIOD_S / settings.motor.inductance_h;
    let per_change = settings.motor.resistance_ohm / (-(-passes).exp_m1() * periods);
    // What a tick measured is of the time since the one before.
    let equations: Vec<([f64; 4], f64)> = (seen.windows(2).zip(run.counts.windows(2)))
        .map(|(seen, counts)| {
            let change = seen[1].last_a - seen[0].last_a;
            let before = seen[1].mean_a - change / periods;
            let row = [before, (counts[1] - counts[0]) * per_count, before.signum(), 1.0];
            (row, pulses(passes) * seen[1].mean_v - per_change * change)
        })
        .collect();
    let ticks = (STRETCH_S / joint.period_s).round() as usize;
    // The first begins with what was before the probe.
    let stretches = equations[1.min(equations.len())..].chunks_exact(ticks);
    stretches.filter_map(solve).map(|[_, (constant, _), ..]| constant).collect()
}

/// Moves joint `number` and gives its motor's constant, N/A or N·m/A; none on a board that does not measure currents.
///
/// # Errors
/// The board refused a motion, or the fit does not determine the constant.
pub fn constant(board: &mut dyn Board, number: u32) -> Result<Option<Estimate>, Error> {
    let settings = settings(board)?;
    let joint = Joint::of(&settings, number)?;
    let runs = motion::excite(board, &settings, number, &FREQUENCIES_HZ)?;
    if runs.iter().any(|run| run.stage.len() < run.counts.len()) {
        return Ok(None);
    }
    let found: Vec<f64> = runs.iter().flat_map(|run| constants(run, &joint, &settings)).collect();
    cohold_sim::refuse_if!(
        found.len() < FEWEST,
        "the joint went too far or too fast to see what voltage it makes: raise probe.max_travel_counts"
    );
    let mut constant = Estimate::of(&found);
    constant.within += MODEL * constant.value.abs();
    cohold_sim::refuse_if!(
        constant.within > 0.25 * constant.value.abs(),
        "the voltage that the motor makes by moving tells its constant as {constant}, which says nothing: let go of it, or raise \
             probe.max_duty or probe.max_travel_counts"
    );
    cohold_sim::refuse_if!(
        constant.value < 0.0,
        "the motor makes a voltage against its motion: `calibrate sign` first"
    );
    Ok(Some(constant))
}

/// Refuses a constant by the voltage that is not the one known otherwise.
///
/// # Errors
/// Both constants with their intervals, where they disagree.
pub fn against(by_voltage: Estimate, other: Estimate, way: &str) -> Result<(), Error> {
    let difference = (by_voltage.value - other.value).abs();
    if difference <= APART * other.value.abs() + by_voltage.within + other.within {
        return Ok(());
    }
    Err(format!(
        "the motor's constant is {other} {way}, and {by_voltage} by the voltage that it makes by moving: the encoder's scale is wrong (`calibrate \
         counts`), or the constant, or motor.sense_a"
    ).into())
}
