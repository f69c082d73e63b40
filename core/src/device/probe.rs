//! A probe: one motor pushed open loop, for a short time and within hard limits, to learn about the device.
//!
//! Calibration and the check before arming need motion whose cause is known, from a device of which neither scale nor sign
//! may be known yet. So a probe commands a duty, not a force, and its limits are in duty, encoder counts and seconds:
//! largest duty, travel from where it began, counts in one step, duration (table `probe`). At any of them the motor is off in
//! the same tick, and the reason is kept until the next probe. The guards of [`crate::safety`] trip as always.
//!
//! | shape | duty, as a fraction of the largest | for |
//! |---|---|---|
//! | `pulse` | 1 | holding against a gauge |
//! | `swing` | 1, −1, −1, 1, a quarter of the time each | sign, inertia: a device without friction ends where it began, at rest |
//! | `ramp` | from 0 to 1 | the force at which it breaks away |
//! | `sine` | cos 2πft: velocity begins at zero, so it does not drift | friction and inertia, back-EMF |
//! | `winding` | a voltage, a share of the supply: 0, then one way or the other from step to step ([`winding`]) | resistance, inductance |
//!
//! [`Outcome::verdict`]: whatever the device, as long as it is passive and began at rest, a motor cannot have taken work
//! out of it. So W = Σ sign(duty)·Δcounts, duty and counts both along the joint, never falls below zero where the signs of
//! motor and encoder agree, and never rises above it where they do not. A hand that pushes one way gives both, and is
//! recognised: no verdict. Force follows duty late, by a millisecond or two; so the first three steps after a change of sign do not
//! count.
//!
//! A **step** is a millisecond, or a tick where that is longer. The duty changes and motion is judged from step to step, so that a check
//! says the same whatever the tick; limits are looked at in every tick.
//!
//! **With a current loop** the check begins with a trial ([`winding`]), before the loop is closed, and ends with what voltage and current say
//! of the winding and of the encoder's scale ([`Electric`]). A probe ends as soon as a motor's current is [`RUNAWAY`] times what was asked
//! for, and more: a loop around a sensor of the wrong sign drives it there within a tick or two.
//!
//! Units: duty as a fraction of full scale, counts along the joint, s, Hz.
//! Limits: duty steps as the shape does, without a slew limit; counts come from encoders, so a simulated device that gives
//! exact positions does not seem to move.

use core::fmt;

use super::stage::{Flow, Measured};
use super::winding::{self, Electric, Expected, Sums, Trial};
use crate::names::{Choice, words};
use crate::settings::{Allowed, Refused, Settings, Timing, Value};
use crate::{device::motor::Duty, num::Scalar};

words! {
    /// How the duty goes over the time of a probe.
    Shape {
        "pulse" => Pulse, "the same all the time";
        "swing" => Swing, "one way, the other way for twice as long, the first way again";
        "ramp" => Ramp, "evenly up from zero";
        "sine" => Sine, "a cosine";
        "winding" => Winding, "a voltage, none and then one way or the other from step to step";
    }

    /// How a probe ended.
    End {
        "none" => None, "there was no probe yet";
        "running" => Running, "the probe is running";
        "done" => Done, "its time was over";
        "travel" => Travel, "the device went as far as the probe may";
        "speed" => Speed, "the device was faster than probe.max_speed_counts_per_s";
        "stopped" => Stopped, "it was stopped by command or by a fault";
        "current" => Current, "the current was far beyond what was asked for: a short circuit, or a current sensor that lies";
        "unmeasured" => Unmeasured, "nothing measures the current: a winding is for boards with a current loop";
        "enable" => Enable,
            "current or motion while the enable was low: let go of it; else the bridge does not obey its enable";
        "sensor" => Sensor, "the current flows against the voltage: swap the two wires at the current's sensor";
        "open" => Open, "no current flows: look at the motor's wires, the bridge's supply and the current's sensor";
    }

    /// What a probe says about the signs of motor and encoder.
    Verdict {
        "agree" => Agree, "motor and encoder agree";
        "disagree" => Disagree,
            "motor and encoder disagree: change motor.reversed (or encoder.reversed, if the axis points the wrong way)";
        "still" => Still,
            "did not move: let go of it; if nothing holds it, raise probe.check_duty or look at the encoder";
        "unclear" => Unclear, "something else moved it, or it went too far: let go of it, or lower probe.check_duty";
        "stage" => Stage, "so the loop around the current may not be closed";
        "winding" => Winding, "motor and encoder agree, but the current is not that of motor.resistance_ohm: `calibrate winding`";
        "scale" => Scale,
            "motor and encoder agree, but the voltage that the motor makes by moving does not fit the encoder's scale and the \
             motor's constant: one of them is wrong; `calibrate counts`, `calibrate motor`";
    }
}

/// A probe as it is asked for: joint, waveform, duty and duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Number of the joint to push, from 1.
    pub joint: u32,
    /// Waveform of the push.
    pub shape: Shape,
    /// Largest duty, a fraction of full scale (of a winding: voltage, a fraction of the supply); along the joint as `motor.reversed` has it.
    pub duty: f64,
    /// For how long, s.
    pub duration_s: f64,
    /// Frequency of the sine, Hz.
    pub frequency_hz: f64,
}

/// A probe that [`Probe::build`] has checked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Probe<S> {
    joint: usize,
    shape: Shape,
    /// Duty code, negative where positive duty pushes against the joint and the push is along it.
    code: S,
    along: i32,
    /// Ticks of a step, and steps.
    step_ticks: u32,
    steps: u32,
    radians_per_step: S,
    max_travel_counts: i32,
    max_step_counts: i32,
    /// Work at which a verdict is passed, counts.
    verdict_counts: i32,
    check: bool,
    /// Voltage of the trial before a check, mV.
    trial_mv: f64,
    /// Most current, codes: with the loop around it closed, and without.
    most_codes: [i32; 2],
    expected: Expected,
}

/// Factor over the largest duty, plus [`SMALL_CODES`], that a motor's current may not exceed while a loop holds it.
pub const RUNAWAY: i32 = 2;
/// Current that is more than any noise of the sensor, codes: 1/32 of full scale.
pub const SMALL_CODES: i32 = 1024;

/// A step of a probe, s, or a tick where that is longer: duties change, motion and current are judged from step to step, whatever the tick.
pub const STEP_S: f64 = 0.001;

/// Steps after a change of sign that do not count; a force that follows its duty by two is still judged right.
const LATE: u32 = 3;

/// Ticks of a step, and how long it is, s.
fn step(timing: &Timing) -> (u32, f64) {
    // A cast saturates, and a tick is 10 µs or more.
    let ticks = ((STEP_S / timing.control_period_s + 0.5) as u32).max(1);
    (ticks, f64::from(ticks) * timing.control_period_s)
}

/// Travel of the check before arming, in the work that it asks for: an undisturbed swing travels twice its work.
const CHECK_TRAVEL: u32 = 20;

impl<S: Scalar> Probe<S> {
    /// A probe within the limits of the table `probe`.
    ///
    /// # Errors
    /// The number that lies outside the limits of the table `probe`, with its range.
    pub fn build(settings: &Settings, request: &Request) -> Result<Self, Refused<'static>> {
        let limits = &settings.probe;
        let most = limits.max_duty.min(settings.motor.max_duty);
        let (step_ticks, step_s) = step(&settings.timing);
        within("joint", f64::from(request.joint), [1.0, f64::from(settings.axis.count)], "")?;
        within("duty", request.duty, [-most, most], "")?;
        within("duration", request.duration_s, [4.0 * step_s, limits.max_s], "s")?;
        if request.shape == Shape::Sine {
            within("frequency", request.frequency_hz, [0.1, 0.1 / step_s], "Hz")?;
        }
        // Float-to-integer casts saturate.
        let quarter = (request.duration_s / (4.0 * step_s)) as u32;
        let along = if settings.motor.reversed { -1 } else { 1 };
        // The nearest code that is no more than the largest duty.
        let full_scale = f64::from(Duty::FULL_SCALE);
        let most_code = (most * full_scale) as i32;
        let code = (request.duty * full_scale).round_to_i32().clamp(-most_code, most_code);
        Ok(Self {
            joint: request.joint as usize - 1,
            shape: request.shape,
            code: S::from_i32(along * code),
            along,
            step_ticks,
            steps: 4 * quarter.max(1),
            radians_per_step: S::from_f64(core::f64::consts::TAU * request.frequency_hz * step_s),
            max_travel_counts: limits.max_travel_counts as i32,
            max_step_counts: (limits.max_speed_counts_per_s * step_s + 1.0) as i32,
            verdict_counts: limits.check_counts as i32,
            check: false,
            most_codes: [RUNAWAY * code.saturating_abs() + SMALL_CODES, (settings.motor.max_duty * full_scale) as i32],
            trial_mv: {
                let motor = &settings.motor;
                let amperes = winding::TRIAL_SHARE * code.unsigned_abs() as f64 / full_scale * motor.full_scale_a;
                1e3 * amperes * (motor.resistance_ohm + motor.inductance_h / step_s)
            },
            expected: Expected::build(settings, step_s),
        })
    }

    /// The check before arming of `joint` (from 1): a weak swing over a short distance.
    ///
    /// # Errors
    /// A joint that the device does not have, or a key of the check that is out of range.
    pub fn check(settings: &Settings, joint: u32) -> Result<Self, Refused<'static>> {
        let probe = &settings.probe;
        let (duty, duration_s) = (probe.check_duty, probe.check_s);
        // With fewer than 5 steps to a quarter, those that do not count would hide what a hand does.
        within("probe.check_s", duration_s, [20.0 * step(&settings.timing).1, probe.max_s], "s")?;
        let built =
            Self::build(settings, &Request { joint, shape: Shape::Swing, duty, duration_s, frequency_hz: 0.0 })?;
        let travel = CHECK_TRAVEL * probe.check_counts;
        Ok(Self { max_travel_counts: built.max_travel_counts.min(travel as i32), check: true, ..built })
    }

    /// The joint it pushes, from 1.
    pub fn joint(&self) -> u32 {
        self.joint as u32 + 1
    }

    /// How long it takes if nothing ends it, ticks.
    pub fn ticks(&self) -> u32 {
        self.steps.saturating_mul(self.step_ticks)
    }

    /// The trial's voltage at this supply as a share of it, a code: no larger than the duty.
    fn trial_code(&self, supply_mv: u16) -> i32 {
        let code = self.code.round_to_i32();
        // A cast saturates: without a supply it is the duty.
        let wanted = (self.trial_mv / f64::from(supply_mv) * f64::from(Duty::FULL_SCALE)) as i32;
        wanted.min(code.saturating_abs()).saturating_mul(code.signum())
    }

    /// The duty in a step.
    #[inline]
    fn duty(&self, step: u32) -> Duty {
        let code = match self.shape {
            Shape::Pulse => self.code,
            Shape::Swing if (self.steps / 4..self.steps / 4 * 3).contains(&step) => -self.code,
            Shape::Swing => self.code,
            // At most 12,000 steps: 10 s of the shortest.
            Shape::Ramp => self.code * S::from_i32(step as i32).ratio(S::from_i32(self.steps.max(1) as i32)),
            Shape::Winding => self.code * S::from_i32(winding::way(step)),
            Shape::Sine => self.code * (self.radians_per_step * S::from_i32(step as i32)).sin_cos().1,
        };
        Duty(code.limit(self.code.abs()).round_to_i32() as i16)
    }
}

/// Refuses a number outside `[min, max]`.
fn within(key: &'static str, number: f64, [min, max]: [f64; 2], unit: &'static str) -> Result<(), Refused<'static>> {
    if number >= min && number <= max {
        return Ok(());
    }
    Err(Refused { key, value: Value::Number(number), allowed: Allowed::Number { min, max }, unit })
}

/// Outcome of a probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Number of the joint that was pushed, from 1; 0 before the first probe.
    pub joint: u32,
    /// How the probe ended.
    pub end: End,
    /// Largest work W of the motor so far, counts (module page); never below 0.
    pub most_counts: i32,
    /// Smallest work W of the motor so far, counts; never above 0.
    pub least_counts: i32,
    /// Work at which a verdict is passed, counts.
    pub verdict_counts: i32,
    /// Whether the probe was the check before arming.
    pub check: bool,
    /// Electrical measurements at the end of the probe; none without a current loop.
    pub electric: Option<Electric>,
}

impl Outcome {
    /// Whether the check before arming was passed.
    pub fn passed(&self) -> bool {
        self.check && self.verdict() == Verdict::Agree
    }

    /// The verdict of a swing on the signs of motor and encoder.
    pub fn verdict(&self) -> Verdict {
        let enough = self.verdict_counts;
        // A steady push from rest, by a hand or a slope, shows a seventh to a ninth of its most on the wrong side; right
        // signs show no more than a count of rounding. Division by a constant: no panic.
        let hardly = enough / 16;
        if matches!(self.end, End::Enable | End::Sensor | End::Open | End::Current) {
            return Verdict::Stage;
        }
        match (self.most_counts, self.least_counts) {
            (most, least) if most < enough && least > -enough => Verdict::Still,
            _ if self.end != End::Done => Verdict::Unclear,
            (most, least) if most >= enough && least >= -hardly => match self.electric {
                Some(electric) if !electric.is_winding() => Verdict::Winding,
                Some(electric) if !electric.is_scale() => Verdict::Scale,
                _ => Verdict::Agree,
            },
            (most, least) if least <= -enough && most <= hardly => Verdict::Disagree,
            _ => Verdict::Unclear,
        }
    }
}

/// The outcome in words, for the operator.
impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { joint, end, most_counts, least_counts, verdict_counts, check, electric } = self;
        write!(f, "joint {joint} {}", end.name())?;
        if !matches!(end, End::None | End::Running) {
            write!(f, " work {most_counts} {least_counts} of {verdict_counts}")?;
        }
        write!(f, ": {}", end.explain())?;
        if !check || matches!(end, End::None | End::Running) {
            return Ok(());
        }
        let verdict = self.verdict();
        write!(f, "; {}: {}", verdict.name(), verdict.explain())?;
        match electric {
            Some(electric) => write!(f, "; {electric}"),
            None => Ok(()),
        }
    }
}

/// A probe that runs, and the outcome of the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Probing<S> {
    probe: Probe<S>,
    /// The step that follows.
    step: u32,
    /// Ticks of this step that are over, and the sums of current and voltage in them.
    over: u32,
    flows: [i32; 2],
    /// What this step does, and whether the bridges are enabled in it.
    doing: (Duty, bool),
    /// Where the joint was when the probe began, and when this step did, counts; none before the first tick.
    places: Option<(i32, i32)>,
    /// Sign of the last duty, along the joint, and for how many more steps the force may still be the old one.
    pushing: i32,
    late: u32,
    work: i32,
    /// What comes before the loop is closed: of a check with a current loop.
    trial: Option<Trial>,
    sums: Sums,
    outcome: Outcome,
}

/// What the bridges are to do for a probe.
pub(crate) struct Push<const N: usize> {
    pub(crate) duties: [Duty; N],
    pub(crate) enable: bool,
    pub(crate) open: bool,
}

impl<S: Scalar> Probing<S> {
    /// A probe that begins with the next tick.
    pub(crate) fn of(probe: Probe<S>) -> Self {
        let outcome = Outcome {
            joint: probe.joint(),
            end: End::Running,
            verdict_counts: probe.verdict_counts,
            check: probe.check,
            ..Outcome::default()
        };
        Self { probe, outcome, ..Self::default() }
    }

    /// What came of it.
    pub(crate) fn outcome(&self) -> Outcome {
        self.outcome
    }

    /// Ends it, unless it has ended.
    pub(crate) fn end(&mut self, end: End) {
        if self.outcome.end == End::Running {
            self.outcome.end = end;
        }
    }

    /// One tick, with every joint's counts and what the power stage measured since the last; nothing when it is over.
    #[inline]
    pub(crate) fn tick<const N: usize>(
        &mut self,
        mut counts: impl Iterator<Item = i32>,
        stage: Option<&Measured<N>>,
    ) -> Option<Push<N>> {
        let now = counts.nth(self.probe.joint).unwrap_or_default();
        let begins = self.places.is_none();
        if begins && stage.is_some() && self.probe.check {
            self.trial = Some(Trial::default());
        }
        let (start, last) = *self.places.get_or_insert((now, now));
        let (moved, step) = (now.saturating_sub(start).saturating_abs(), now.saturating_sub(last));
        if moved > self.probe.max_travel_counts {
            self.end(End::Travel);
        }
        if step.saturating_abs() > self.probe.max_step_counts {
            self.end(End::Speed);
        }
        let flow = stage
            .and_then(|stage| Some((*stage.motors.get(self.probe.joint)?, [stage.supply_mv, stage.supply_counts])));
        if let Some((flow, _)) = flow {
            let [closed_most, open_most] = self.probe.most_codes;
            let most = if self.is_open() { open_most } else { closed_most };
            if i32::from(flow.mean).abs().max(i32::from(flow.last).abs()) >= most {
                self.end(End::Current);
            }
            let [current, voltage] = self.flows;
            self.flows = [current.saturating_add(flow.mean.into()), voltage.saturating_add(flow.voltage.into())];
        } else if self.is_open() {
            self.end(End::Unmeasured);
        }
        self.over += 1;
        if begins || self.over >= self.probe.step_ticks {
            let [current, voltage] = core::mem::take(&mut self.flows);
            let ticks = core::mem::take(&mut self.over).cast_signed();
            let flow = flow.map(|(flow, supply)| (Flow::of(current, voltage, flow.last.into(), ticks), supply));
            self.places = Some((start, now));
            self.next(moved, step, flow);
        }
        if self.outcome.end != End::Running {
            return None;
        }
        let (duty, enable) = self.doing;
        let mut duties = [Duty::OFF; N];
        if let Some(own) = duties.get_mut(self.probe.joint) {
            *own = duty;
        }
        Some(Push { duties, enable, open: self.is_open() })
    }

    /// No loop is closed around the current.
    fn is_open(&self) -> bool {
        self.trial.is_some() || self.probe.shape == Shape::Winding
    }

    /// A step is over: so far from where the probe began and in it, counts, and what flowed in it, from which supply, mV and counts.
    #[inline(never)]
    fn next(&mut self, moved: i32, step: i32, flow: Option<(Flow, [u16; 2])>) {
        if self.late == 0 {
            self.work = self.work.saturating_add(step.saturating_mul(self.pushing));
            // Not before there is a voltage to be compared with.
            if let (Some((flow, supply)), true) = (flow, self.pushing != 0) {
                self.sums.add(supply, flow, step);
            }
        }
        self.outcome.most_counts = self.outcome.most_counts.max(self.work);
        self.outcome.least_counts = self.outcome.least_counts.min(self.work);
        self.late = self.late.saturating_sub(1);
        self.doing = (Duty::OFF, true);
        if let (Some(trial), Some((flow, [supply_mv, _]))) = (&mut self.trial, flow) {
            match trial.step([flow.mean, flow.last].map(|code| self.probe.along * i32::from(code)), moved) {
                winding::Next::Way(way, enabled) => {
                    // At most ±32767, and a sign.
                    let code = self.probe.trial_code(supply_mv).saturating_mul(way) as i16;
                    self.doing = (Duty(code), enabled);
                }
                winding::Next::Passed => self.trial = None,
                winding::Next::Failed(why) => self.end(match why {
                    winding::Why::Enable => End::Enable,
                    winding::Why::Sensor => End::Sensor,
                    winding::Why::Open => End::Open,
                }),
            }
        }
        if self.trial.is_none() {
            if self.step >= self.probe.steps {
                if flow.is_some() && self.probe.check {
                    self.outcome.electric = Some(self.sums.fit(&self.probe.expected));
                }
                self.end(End::Done);
            }
            let duty = self.probe.duty(self.step);
            self.doing = (duty, true);
            self.step += 1;
            let pushing = i32::from(duty.0).signum().saturating_mul(self.probe.along);
            if pushing != self.pushing {
                (self.pushing, self.late) = (pushing, LATE);
            }
        }
    }
}
