//! Checks a motor's winding, its current sensor, its bridge and the encoder's scale by measured voltage and current.
//!
//! Over a step of a probe, a millisecond, L·Δi = ∫(u − R·i − k·v) dt, whatever happens within it: mean voltage and current, the change of
//! the current and what the encoder moved, which its ticks know all four ([`super::stage`]), give R, L and k by least squares. On a PC all of it is done from
//! records (cohold's `calibrate`), out of a probe that goes as [`way`] says. Here is what has to stand before arming, on the board itself:
//!
//! **Before the loop is closed**, a trial: with the enable low and a voltage at the bridge's inputs, neither current nor motion
//! may come; with it high, the current must change, and along the voltage. Otherwise a loop around the current would run away, or
//! push with all its voltage. Its voltage is what drives half (`TRIAL_SHARE`) of the check's current through the configured winding in a
//! step, I·(R + L/1 ms): no more than 1.1 I flows with that, whatever R and L are, while the free device takes a millisecond or more to come to
//! speed (R·m/k²).
//!
//! **After the check's swing**, [`Electric`]: R and k by u = R·i + k·Δcounts, in percent of what the settings say. The current of a swing
//! is even in time about its middle where the speed is odd, so an error in one (dead time looks like resistance) is none in the other.
//! k holds the encoder's scale and the motor's constant together: a scale that is wrong, with a constant that is wrong the other way, is
//! not reported; nor is less than [`SCALE_PERCENT`].
//!
//! Units: currents in codes, 1/32767 of `motor.full_scale_a`; voltages in counts of the timer.
//!
//! Limits: dead time is within the resistance (so its tolerance is wide), and the swing must be fast enough to make a voltage: one that
//! is too slow to tell the scale to a few percent has not passed.

use core::fmt;

use super::kinematics::Joints;
use super::stage::Flow;
use crate::device::motor::Duty;
use crate::settings::Settings;

/// Steps without voltage that a winding's probe begins with: what the sensor reads then is its zero.
pub const REST_STEPS: u32 = 40;
/// Sign of the probe's voltage in each step after the rest, repeated. Sum and first moment are zero: a rotor that is
/// free to move comes back to where it was, at rest (the Thue–Morse sequence).
pub const WAYS: [i32; 8] = [1, -1, -1, 1, -1, 1, 1, -1];

/// Sign of the voltage of a winding's probe in this step: −1, 0 or 1.
#[inline]
pub fn way(step: u32) -> i32 {
    step.checked_sub(REST_STEPS).map_or(0, alternating)
}

fn alternating(step: u32) -> i32 {
    WAYS.get(step as usize % WAYS.len()).copied().unwrap_or_default()
}

/// Smallest current that counts as one, codes: 1/2048 of full scale, a step of a converter of 12 bits. Means over six
/// steps are sure to a few codes.
pub const LEAST_CODES: i32 = 16;
/// Counts that an encoder may go to and fro by at rest.
const REST_COUNTS: i32 = 2;

/// Share of the check's current that a trial's voltage is for. Two steps the same way after one the other way drive 1.7 times that through a
/// winding whose time constant is a step, and 2.2 times where back-EMF that has just turned helps.
pub(crate) const TRIAL_SHARE: f64 = 0.5;

/// What comes before the loop is closed: so many steps without voltage, with one at the inputs of a bridge that is not enabled (one way,
/// then the other), enabled without voltage until it is awake, and with [`WAYS`] twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Trial {
    step: u32,
    /// Sum along the voltage, codes: of the currents, and once the bridge is enabled of their changes, too. The mean of a slow winding's current
    /// follows the voltage of the step before; how it changed follows its own.
    along: i32,
    /// The last current of the step before, codes.
    last: i32,
}

/// What a trial does next.
pub(crate) enum Next {
    /// Sign of the voltage for the next step, and whether the bridge is enabled.
    Way(i32, bool),
    /// The loop may be closed.
    Passed,
    /// The loop must stay open, and why.
    Failed(Why),
}

/// What stands against closing the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Why {
    /// Current or motion while the bridge was not enabled: the enable line does not work.
    Enable,
    /// The current flows against the voltage: the sensor's sign is wrong.
    Sensor,
    /// No current flows: the circuit is open.
    Open,
}

const DISABLED: u32 = 4;
const AGAINST: u32 = 8;
const AWAKE: u32 = 12;
const DRIVEN: u32 = 16;
const OVER: u32 = DRIVEN + 2 * WAYS.len() as u32;

impl Trial {
    /// Sign of the trial's voltage in this step: −1, 0 or 1.
    fn way(step: u32) -> i32 {
        match step {
            DISABLED..AGAINST => 1,
            AGAINST..AWAKE => -1,
            DRIVEN..OVER => alternating(step - DRIVEN),
            _ => 0,
        }
    }

    /// A step is over: what flowed along the joint since the last one, its mean and its end, codes, and how far the joint is from where it began, counts.
    pub(crate) fn step(&mut self, [mean, last]: [i32; 2], moved_counts: i32) -> Next {
        let step = self.step;
        // What was measured is of the step before; in the first after a change of a voltage that stands it may be that of the other.
        let (before, earlier) = (Self::way(step.wrapping_sub(1)), Self::way(step.wrapping_sub(2)));
        if step > DRIVEN {
            self.along += before * (mean + last - self.last);
        } else if before == earlier {
            self.along += before * mean;
        }
        self.last = last;
        if step <= AWAKE && moved_counts > REST_COUNTS {
            return Next::Failed(Why::Enable);
        }
        match step {
            // Of three steps each way.
            AWAKE if self.along.abs() > 6 * LEAST_CODES => return Next::Failed(Why::Enable),
            AWAKE => self.along = 0,
            OVER if self.along < -(2 * WAYS.len() as i32) * LEAST_CODES => return Next::Failed(Why::Sensor),
            OVER if self.along < 2 * WAYS.len() as i32 * LEAST_CODES => return Next::Failed(Why::Open),
            OVER => return Next::Passed,
            _ => {}
        }
        self.step += 1;
        Next::Way(Self::way(step), step >= AWAKE)
    }
}

/// What the settings say: volts along the motor per code of current, and per count that the joint makes in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Expected {
    per_code: f64,
    per_count: f64,
}

impl Expected {
    /// For steps of `step_s`, s.
    pub(crate) fn build(settings: &Settings, step_s: f64) -> Self {
        let motor = &settings.motor;
        let Joints { counts_per_unit, .. } = Joints::of(settings);
        let along = if motor.reversed { -1.0 } else { 1.0 };
        Self {
            per_code: motor.resistance_ohm * motor.full_scale_a / f64::from(Duty::FULL_SCALE),
            // A constant in newtons per ampere is one in volts per metre per second.
            per_count: along * motor.newton_or_newton_metre_per_a / counts_per_unit / step_s,
        }
    }
}

/// Sums of u = R·i + k·Δcounts, exact: a number of 16 bits times another, 2³¹ times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Sums {
    steps: u32,
    /// mV in as many counts, of the last tick.
    supply: [u16; 2],
    uu: i64,
    ui: i64,
    uc: i64,
    ii: i64,
    ic: i64,
    cc: i64,
}

impl Sums {
    /// One step, and the counts that the joint made in it.
    pub(crate) fn add(&mut self, supply: [u16; 2], flow: Flow, step_counts: i32) {
        let [u, i, c] = [i64::from(flow.voltage), i64::from(flow.mean), i64::from(step_counts)];
        self.steps = self.steps.saturating_add(1);
        self.supply = supply;
        self.uu += u * u;
        self.ui += u * i;
        self.uc += u * c;
        self.ii += i * i;
        self.ic += i * c;
        self.cc += c * c;
    }

    /// The fit; of too little one that no settings expect.
    pub(crate) fn fit(&self, expected: &Expected) -> Electric {
        let [uu, ui, uc, ii, ic, cc] = [self.uu, self.ui, self.uc, self.ii, self.ic, self.cc].map(|sum| sum as f64);
        let determinant = ii * cc - ic * ic;
        let (per_code, per_count) = ((ui * cc - uc * ic) / determinant, (uc * ii - ui * ic) / determinant);
        let variance = (uu - per_code * ui - per_count * uc).max(0.0) / (f64::from(self.steps) - 2.0);
        let [supply_mv, counts] = self.supply.map(f64::from);
        let volts = supply_mv / counts / 1e3;
        // A cast saturates, and takes NaN to 0.
        let percent = |share: f64| (100.0 * volts * share) as i32;
        Electric {
            resistance_percent: percent(per_code / expected.per_code),
            constant_percent: percent(per_count / expected.per_count),
            unsure_percent: percent(libm::sqrt(variance * ii / determinant) / expected.per_count).saturating_abs(),
        }
    }
}

/// Largest deviation of the constant from 100 percent, standard error included, percentage points.
pub const SCALE_PERCENT: i32 = 30;
/// Least and most resistance of the configured winding, percent: warm, with dead time, and within what the loop bears.
pub const RESISTANCE_PERCENT: [i32; 2] = [40, 300];

/// What a check measured of a winding and its scale, percent of the configured values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Electric {
    /// Measured resistance, percent of the configured one.
    pub resistance_percent: i32,
    /// Measured back-EMF per count (motor constant over encoder scale), percent of the configured one.
    pub constant_percent: i32,
    /// Standard error of `constant_percent`, percentage points.
    pub unsure_percent: i32,
}

impl Electric {
    /// Whether the winding is the configured one.
    pub fn is_winding(self) -> bool {
        let [least, most] = RESISTANCE_PERCENT;
        (least..=most).contains(&self.resistance_percent)
    }

    /// Whether the motor's constant and the encoder's scale fit the configured ones.
    pub fn is_scale(self) -> bool {
        let off = self.constant_percent.saturating_sub(100).saturating_abs();
        off.saturating_add(self.unsure_percent) <= SCALE_PERCENT
    }
}

impl fmt::Display for Electric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { resistance_percent, constant_percent, unsure_percent } = self;
        write!(
            f,
            "resistance {resistance_percent} %, back-EMF {constant_percent} ± {unsure_percent} % of the settings'"
        )
    }
}
