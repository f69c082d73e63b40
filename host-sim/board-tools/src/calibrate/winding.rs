//! Resistance and inductance of a motor's winding and the zero of its current's sensor, by small voltages to and fro.
//!
//! A [probe](cohold_core::device::winding) of alternating voltage without a loop, at two amplitudes. From one sample of the current to the
//! next i′ = a·i + g·(u − e), with a = exp(−R·T/L) over a PWM period T; summed over the N periods of a tick, exactly,
//!
//! ```text
//! u = r·s + h·Δi + κ·q + o,
//! ```
//!
//! u the mean voltage, s the mean of the samples before each period, Δi what the current changed by; r = (1 − a)/g, h = 1/(g·N). A rotor that
//! is free moves a little under this: its voltage goes with the charge q that has passed, κ = k²/m, and what of it follows the current within
//! the tick is taken out of h (`early`). Dead time in a bridge takes the same from both amplitudes, so the difference of the two is fitted.
//!
//! Two pulses a period, a quarter of it from its ends, give g = (a^¼ + a^¾)/2 · ln(1/a)/R (`pulses`): hence R and L.
//!
//! Each of ten parts is fitted by itself; the interval is Student's of what they give, and a tenth of what the rotor's motion added.
//!
//! Limits: a winding whose time constant is far below a PWM period shows no inductance, and is refused. Friction that holds the rotor in
//! part of each pulse is not in κ, and dead time that stops the current on its way through zero not in the difference: half a microsecond
//! of it is 15 % of L at the most. What the supply's measurement is off by is in no interval.

use cohold_core::device::current::periods_per_tick;
use cohold_core::device::probe::{End, STEP_S};
use cohold_core::device::stage::Measured;
use cohold_core::device::winding::{LEAST_CODES, REST_STEPS, WAYS};
use cohold_core::device::{current::PWM_PERIOD_S, motor::Duty};
use cohold_core::settings::Settings;

use super::board::{Board, Run, run, seen, settings};
use super::least_squares::solve;
use super::{Estimate, Found};
use crate::Error;

/// Parts that are fitted by themselves.
const STRETCHES: usize = 10;
/// Ticks of one, at the least and unless the table `probe` allows less: whole patterns.
const FEWEST: usize = 2 * WAYS.len();
const TICKS: usize = 8 * WAYS.len();
/// Ticks of a probe's rest after which what is read is its own.
const SETTLED: usize = 8;
/// From the sample that ends a tick's mean to the voltage of the next tick: the period of the sample, the tick's own and the step's.
const LATE_PERIODS: f64 = 3.0;
/// Of what a rotor's motion adds to R and L, how much is not believed: friction holds it in part.
const UNSURE: f64 = 0.1;
/// How far voltage and change of the current may point against each other by chance, of all that they can.
const AGAINST: f64 = 0.3;
/// Most of the voltage that the fit may leave unexplained, root mean square.
const MISFIT: f64 = 0.05;
/// Most that the sensor may read at rest, of its range.
const ZERO: f64 = 0.02;

/// Of the probes' largest current, what is aimed at: the rest is for pulses, and for what a data sheet says too much.
const SHARE: f64 = 0.75;
/// Least time constant L/R of a winding that a current loop can be closed around, s: four fifths of a PWM period.
const LEAST_CONSTANT_S: f64 = 0.8 * PWM_PERIOD_S;
/// How much more current than that of the settings' winding may flow, and what of the sensor's range is noise.
const MORE: f64 = 1.3;
const NOISE: f64 = 0.005;

/// Winding data of a motor's data sheet, with their tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sheet {
    /// Resistance R of the winding, Ω.
    pub resistance_ohm: Option<f64>,
    /// Inductance L of the winding, H.
    pub inductance_h: Option<f64>,
    /// Tolerance of both, as a fraction.
    pub tolerance: f64,
}

impl Sheet {
    /// What a board's current loop is set by until the winding is measured; none where the sheet does not say both.
    pub fn found(self) -> Option<[Found; 2]> {
        let of_sheet =
            |key, value: Option<f64>, unit| value.map(|value| Found::number(key, Estimate::new(value, 0.0), unit));
        let resistance = of_sheet("motor.resistance_ohm", self.resistance_ohm, "Ω")?;
        Some([resistance, of_sheet("motor.inductance_h", self.inductance_h, "H")?])
    }
}

/// What current and voltage say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Winding {
    /// Resistance R of the winding, Ω.
    pub resistance_ohm: Estimate,
    /// Inductance L of the winding, H.
    pub inductance_h: Estimate,
    /// What the sensor reads at no current, A.
    pub zero_a: Estimate,
}

/// One motor's side of a [`Measured`], in volts and amperes.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotorReading {
    pub(super) mean_a: f64,
    pub(super) last_a: f64,
    pub(super) mean_v: f64,
    pub(super) supply_v: f64,
}

impl MotorReading {
    pub(super) fn of(stage: &Measured, settings: &Settings, number: u32) -> Self {
        let flow = stage.motors[number as usize - 1];
        let amperes = |codes: i16| f64::from(codes) / f64::from(Duty::FULL_SCALE) * settings.motor.full_scale_a;
        let supply_v = f64::from(stage.supply_mv) / 1e3;
        let mean_v = f64::from(flow.voltage) / f64::from(stage.supply_counts.max(1)) * supply_v;
        Self { mean_a: amperes(flow.mean), last_a: amperes(flow.last), mean_v, supply_v }
    }
}

/// One tick of the equation above, without q.
#[derive(Clone, Copy, Debug)]
struct Row {
    volts: f64,
    before: f64,
    change: f64,
}

/// The ticks of a probe after its rest, `periods` PWM periods each; and the means of the rest.
fn rows(run: &Run, settings: &Settings, number: u32, periods: f64) -> (Vec<Row>, Vec<f64>) {
    let seen: Vec<MotorReading> = run.stage.iter().map(|stage| MotorReading::of(stage, settings, number)).collect();
    let given = |tick: usize| run.duties[tick] * seen[tick].supply_v;
    let rest = REST_STEPS as usize;
    let motor = &settings.motor;
    let kept = (-0.5 * PWM_PERIOD_S * motor.resistance_ohm / motor.inductance_h).exp();
    let rows = (rest..seen.len() - 1).map(|tick| {
        // What was commanded in this tick is what the next one measured. A sample is taken before the voltage that its period adds to the
        // mean: the last period of the mean is the next tick's first.
        let (last, now) = (seen[tick], seen[tick + 1]);
        let (change, from, to) = (now.last_a - last.last_a, given(tick - 1), given(tick));
        // After a negative voltage a sample is half a period older: the first step is longer where it ends, and shorter where it begins. What
        // that is worth, on the average of both, has decayed for as long.
        let longer = 0.5 * kept * (f64::from(u8::from(from < 0.0)) - f64::from(u8::from(to < 0.0)));
        let volts = now.mean_v + (from - to + longer * from.min(to)) / periods;
        let before = now.mean_a - (change - longer * last.last_a) / periods;
        Row { volts, before, change }
    });
    (rows.collect(), seen[SETTLED..=rest].iter().map(|seen| seen.mean_a).collect())
}

/// Variance of what the current changes by in a tick at rest, A²: noise of the sensor.
fn noise(run: &Run, settings: &Settings, number: u32) -> f64 {
    let rest = &run.stage[SETTLED..REST_STEPS as usize];
    let read: Vec<f64> = rest.iter().map(|stage| MotorReading::of(stage, settings, number).last_a).collect();
    let squares = read.windows(2).map(|two| (two[1] - two[0]).powi(2));
    squares.sum::<f64>() / (read.len() - 1) as f64
}

/// What two pulses a period, a quarter of it from its ends, do to the samples between them, of what an even voltage does: a winding that forgets
/// by exp(−`constants`) in a period.
pub(super) fn pulses(constants: f64) -> f64 {
    constants * 0.5 * ((-0.25 * constants).exp() + (-0.75 * constants).exp()) / -(-constants).exp_m1()
}

/// How much of Δi a rotor that moves takes for itself, of κ: its speed follows what has passed by the middle of a tick, not the tick's mean. A
/// current that goes to its new value with this time constant (both in ticks) after `late` of the old one.
fn early(constant: f64, late: f64) -> f64 {
    let left = 1.0 - late;
    let end = (-left / constant).exp();
    let before = late * (1.0 - late) / 2.0;
    let after = constant * ((0.5 - late) * (1.0 - end) - constant + end * (constant + left));
    (before + after) / (1.0 - end)
}

/// R and L of one stretch and what the rotor's motion added to them, and the squares of what is left and of the voltage.
fn fit(rows: &[Row], periods: f64) -> Option<([f64; 4], [f64; 2])> {
    let mean = rows.iter().map(|row| row.before).sum::<f64>() / rows.len() as f64;
    let mut charge = 0.0;
    let equations: Vec<([f64; 4], f64)> = (rows.iter())
        .map(|row| {
            let within = row.before - mean;
            charge += within;
            ([row.before, row.change, charge - 0.5 * within, 1.0], row.volts)
        })
        .collect();
    let [(r, _), (h, _), (kappa, _), (offset, _)] = solve(&equations)?;
    let left: f64 = (equations.iter()).map(|([s, d, q, _], u)| (u - r * s - h * d - kappa * q - offset).powi(2)).sum();
    let given = rows.iter().map(|row| row.volts.powi(2)).sum();
    let mut moved = 0.0;
    let mut found = [f64::NAN; 4];
    for _ in 0..4 {
        let a = 1.0 - r / ((h + moved) * periods);
        if !(a > 0.0 && a < 1.0) {
            return Some(([f64::NAN; 4], [left, given]));
        }
        let constants = -a.ln();
        let resistance = r * pulses(constants);
        let inductance = resistance * PWM_PERIOD_S / constants;
        moved = kappa * early(1.0 / (constants * periods), LATE_PERIODS / periods);
        found = [resistance, inductance, kappa / 2.0, moved * periods * PWM_PERIOD_S];
    }
    Some((found, [left, given]))
}

/// The winding that two probes of joint `number` show, the second of half the voltage.
///
/// # Errors
/// The probes do not determine resistance and inductance, or the currents leave the sensor's range.
pub fn identify(runs: [&Run; 2], settings: &Settings, number: u32) -> Result<Winding, Error> {
    let periods = f64::from(periods_per_tick(settings)?);
    let ticks = |run: &Run| run.stage.len().saturating_sub(REST_STEPS as usize + 1);
    if let Some(few) = runs.map(ticks).into_iter().find(|ticks| *ticks < FEWEST) {
        return Err(format!("{few} ticks of voltage are too few: raise probe.max_s").into());
    }
    let [(full, rest), (half, _)] = runs.map(|run| rows(run, settings, number, periods));
    let split_rows: Vec<Row> = (full.iter().zip(&half))
        .map(|(one, other)| Row {
            volts: one.volts - other.volts,
            before: one.before - other.before,
            change: one.change - other.change,
        })
        .collect();
    let ticks = (split_rows.len() / STRETCHES).min(TICKS) / WAYS.len() * WAYS.len();
    cohold_sim::refuse_if!(ticks < FEWEST, "{} ticks of voltage are too few: raise probe.max_s", split_rows.len());
    let power = |of: fn(&Row) -> f64| split_rows.iter().map(of).sum::<f64>() / split_rows.len() as f64;
    let least = f64::from(LEAST_CODES) / f64::from(Duty::FULL_SCALE) * settings.motor.full_scale_a;
    // What a voltage changes shows its sign in any winding whose change is not gone when it is sampled, also where the current follows slowly.
    let along = power(|row| row.volts * row.change);
    let together = (power(|row| row.volts.powi(2)) * power(|row| row.change.powi(2))).sqrt();
    let square = power(|row| row.before.powi(2));
    cohold_sim::refuse_if!(
        square < (0.5 * least).powi(2),
        "no current flows ({:.1} mA): an open motor, a bridge without supply, or a sensor that is not connected",
        1e3 * square.sqrt()
    );
    // And a winding takes power.
    cohold_sim::refuse_if!(
        along < -AGAINST * together && power(|row| row.volts * row.before) < 0.0,
        "the current flows against the voltage: swap the two wires at the current's sensor"
    );
    let mut found = [const { Vec::new() }; 4];
    let [mut left, mut given] = [0.0; 2];
    for stretch in split_rows.chunks_exact(ticks).take(STRETCHES) {
        let (values, squares) = fit(stretch, periods).ok_or("the current does not change: no winding shows in it")?;
        found.iter_mut().zip(values).for_each(|(found, value)| found.push(value));
        left += squares[0];
        given += squares[1];
    }
    let [mut resistance_ohm, mut inductance_h, moved_ohm, moved_h] = found.map(|values| Estimate::of(&values));
    cohold_sim::refuse_if!(
        resistance_ohm.value.is_nan(),
        "current and voltage are not those of a winding: its current is gone before it is measured (L/R far below a PWM period), or \
                    a wire is loose"
    );
    // What the sensor's noise makes of a voltage, in both probes.
    let noise: f64 = runs.iter().map(|run| noise(run, settings, number)).sum();
    let ticks = (ticks * STRETCHES.min(split_rows.len() / ticks)) as f64;
    let of_noise = ticks * noise * (inductance_h.value / (periods * PWM_PERIOD_S)).powi(2);
    let misfit = ((left - of_noise).max(0.0) / given).sqrt();
    cohold_sim::refuse_if!(
        misfit > MISFIT,
        "current and voltage are not those of a winding: {:.0} % of the voltage is left unexplained, may be {:.0} %; look for a loose \
             wire, and that nothing moves the joint",
        100.0 * misfit,
        100.0 * MISFIT
    );
    resistance_ohm.within += UNSURE * moved_ohm.value.abs();
    inductance_h.within += UNSURE * moved_h.value.abs();
    for (name, estimate) in [("resistance", resistance_ohm), ("inductance", inductance_h)] {
        cohold_sim::refuse_if!(
            !(estimate.value > 0.0 && estimate.within < 0.25 * estimate.value),
            "the {name} comes out at {estimate}, which says nothing: raise probe.max_duty"
        );
    }
    let zeros: Vec<f64> = rest.chunks_exact(4).map(|four| four.iter().sum::<f64>() / 4.0).collect();
    Ok(Winding { resistance_ohm, inductance_h, zero_a: Estimate::of(&zeros) })
}

/// Whether a number may be what the data sheet says.
fn fits(what: &str, found: Estimate, sheet: Option<f64>, tolerance: f64, unit: &str) -> Result<(), Error> {
    let Some(sheet) = sheet else { return Ok(()) };
    if (found.value - sheet).abs() <= tolerance * sheet + found.within {
        return Ok(());
    }
    Err(format!(
        "the {what} is {found} {unit}, the data sheet says {sheet} {unit}, {:.0} % off at the most: another motor, a winding that is shorted in \
         part, a bad contact, or a wrong motor.sense_a",
        100.0 * tolerance
    ).into())
}

/// Supply of the bridges, V; none of a board that measures nothing.
pub fn supply_v(board: &mut dyn Board) -> Result<Option<f64>, Error> {
    Ok(supply_at(board)?.map(|(_, volts)| volts))
}

/// The same, with the number of the tick that measured it.
pub fn supply_at(board: &mut dyn Board) -> Result<Option<(u32, f64)>, Error> {
    let last = seen(board)?;
    Ok(last.stage.map(|stage| (last.number, f64::from(stage.supply_mv) / 1e3)))
}

/// Largest voltage of a probe as a share of the supply, such that a winding as the settings say takes [`SHARE`] of the current of the largest
/// duty of probes in the two ticks that it stands one way; and that current, A.
fn largest(settings: &Settings, supply_v: f64) -> (f64, f64) {
    let (limits, motor) = (&settings.probe, &settings.motor);
    let most = limits.max_duty.min(motor.max_duty);
    let stands_s = 2.0 * settings.timing.control_period_s;
    let reached = -(-stands_s * motor.resistance_ohm / motor.inductance_h).exp_m1();
    let per_share_a = supply_v / motor.resistance_ohm * reached;
    let voltage = (SHARE * most * motor.full_scale_a / per_share_a).min(most);
    (voltage, voltage * per_share_a)
}

/// That the current of a probe was no larger than that of a winding as the settings say.
fn bounded(run: &Run, settings: &Settings, number: u32, most_a: f64) -> Result<(), Error> {
    let read: Vec<_> = run.stage.iter().map(|stage| MotorReading::of(stage, settings, number)).collect();
    let rest = &read[SETTLED.min(read.len())..read.len().min(REST_STEPS as usize)];
    let zero_a = rest.iter().map(|read| read.mean_a).sum::<f64>() / rest.len().max(1) as f64;
    let from_zero = read.iter().flat_map(|read| [read.last_a, read.mean_a]).map(|read_a| (read_a - zero_a).abs());
    let peak_a = from_zero.fold(0.0, f64::max);
    if peak_a <= MORE * most_a + NOISE * settings.motor.sense_a {
        return Ok(());
    }
    Err(Error::Refused(format!(
        "{peak_a:.3} A flowed where a winding of {} Ω and {} H takes {most_a:.3} A at the most: another motor than the data sheet's, or a \
         winding that is shorted in part",
        settings.motor.resistance_ohm, settings.motor.inductance_h
    )))
}

/// Drives joint `number`'s motor to and fro, with a quarter of the voltage first, and gives R, L and the sensor's zero; an error where a winding as
/// the data sheet says cannot be what is behind the bridge. No voltage is larger than takes the probes' current through a winding as
/// the board's settings say. Nothing of a board without a current loop.
pub fn winding(board: &mut dyn Board, number: u32, sheet: Sheet) -> Result<Option<Vec<Found>>, Error> {
    let settings = settings(board)?;
    let (limits, motor) = (&settings.probe, &settings.motor);
    let period_s = settings.timing.control_period_s;
    settings.all_fit(&[("timing.control_period_s", period_s >= STEP_S, "0.001 while a winding is measured")])?;
    let wanted_s = period_s * f64::from(REST_STEPS + (STRETCHES * TICKS) as u32);
    let Some(supply_v) = supply_v(board)? else { return Ok(None) };
    let constant_s = motor.inductance_h / motor.resistance_ohm;
    cohold_sim::refuse_if!(
        constant_s < LEAST_CONSTANT_S,
        "a winding of {} H and {} Ω has a time constant of {:.0} µs, must have {:.0} at the least: between two pulses of the bridge its \
             current is gone before it is measured; put an inductor in series",
        motor.inductance_h,
        motor.resistance_ohm,
        1e6 * constant_s,
        1e6 * LEAST_CONSTANT_S
    );
    let (most, most_a) = largest(&settings, supply_v);
    let mut runs = Vec::new();
    for share in [0.25, 1.0, 0.5] {
        // No less than a probe may be asked for, in digits.
        let line = format!("probe {number} winding {:.5} {:.4}", share * most, wanted_s.min(limits.max_s));
        let run = run(board, number, &line)?;
        match run.end {
            End::Done if run.stage.len() == run.counts.len() => {
                bounded(&run, &settings, number, share * most_a)?;
                runs.push(run);
            }
            End::Unmeasured => return Ok(None),
            End::Done => return Err("the board's records do not have the current".into()),
            end => return Err(format!("{}; if all is well, lower probe.max_duty", end.explain()).into()),
        }
    }
    let Winding { resistance_ohm, inductance_h, zero_a } = identify([&runs[1], &runs[2]], &settings, number)?;
    fits("resistance", resistance_ohm, sheet.resistance_ohm, sheet.tolerance, "Ω")?;
    fits("inductance", inductance_h, sheet.inductance_h, sheet.tolerance, "H")?;
    cohold_sim::refuse_if!(
        zero_a.value.abs() > ZERO * motor.sense_a,
        "the current's sensor reads {zero_a} A while none flows, may be {} A: look at its reference",
        ZERO * motor.sense_a
    );
    Ok(Some(vec![
        Found::number("motor.resistance_ohm", resistance_ohm, "Ω"),
        Found::number("motor.inductance_h", inductance_h, "H"),
        Found::number("plant.current_zero_a", zero_a, "A"),
    ]))
}
