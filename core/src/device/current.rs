//! The current loop of one motor: proportional and integral, in whole numbers, once a PWM period.
//!
//! Design: the zero of the controller cancels the winding, so that one number is left to choose, the crossover ω_c =
//! 2π·`motor.current_loop_hz`: K_p = ω_c·L, K_i = ω_c·R. What is measured at the start of a period acts through the next one, 1.5
//! periods late on average, which leaves a phase margin of 90° − 360°·f·75 µs: 63° at 1 kHz (3 % of overshoot), 36° at 2 kHz (38 %).
//! A winding of half the configured inductance gives twice the crossover.
//!
//! The tick ([`CurrentLoop`]) scales the gains by the supply and hands them over; the step of a period ([`Controller::step`]) divides
//! nothing, calls nothing and needs no FPU. The same bits come out on a board and on a PC.
//!
//! Anti-windup: the voltage is held within [`MOST_VOLTAGE`] of the supply (the rest is time to sample in), the integral within the
//! same, and while the voltage is at its limit the integral does not grow further that way.
//!
//! Units: currents in codes, 1/32767 of `motor.full_scale_a`, so that a [`Duty`] is the reference; voltages in timer counts, of which
//! full supply has as many as `counts`; gains and integral in 2⁻²⁰ counts (per code).
//!
//! Invariants: |result| ≤ limit whatever comes in; no reference beyond `motor.max_duty`; no overflow: an error has 32 bits and a
//! gain 31, so their product has 63.
//!
//! Limits: R and L are what the settings say, neither saturation of the iron nor ripple is modelled; a current that
//! does not follow its reference is for [`super::stage_watch`] to detect.

use core::f64::consts::TAU;
use core::ops::RangeInclusive;

use super::motor::Duty;
use crate::settings::{Allowed, Refused, Settings};

/// PWM frequency, and rate of the current loop, Hz.
pub const PWM_HZ: u32 = 20_000;
/// Length of a PWM period, s.
pub const PWM_PERIOD_S: f64 = 1.0 / PWM_HZ as f64;
/// Range of supplies that the gains are scaled for, mV; a supply outside counts as the nearest end.
pub const SUPPLY_MV: RangeInclusive<u32> = 6_000..=60_000;
/// Largest voltage of the loop, as a share of the supply.
pub const MOST_VOLTAGE: f64 = 0.95;

/// Fractional bits of gains and integral.
const FRACTION: u32 = 20;
/// Gains, in 2⁻²⁰ counts: from where rounding them is an error of 1 % up to where products still fit.
const GAINS: [f64; 2] = [50.0, (1_u32 << 30) as f64];

/// What the settings say of the loop, for any supply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentLoop {
    /// K_p, 2⁻²⁰ counts·mV per code.
    proportional: f32,
    /// K_i over one period, 2⁻²⁰ counts·mV per code.
    integral: f32,
    /// Counts·mV per m/s or rad/s of the joint.
    forward: f32,
    /// Largest voltage, counts.
    limit: i32,
    /// Largest reference, codes.
    most: i32,
}

/// Gains and limits for the supply of this moment, which the tick hands to the step of each PWM period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gains {
    /// Proportional gain K_p, 2⁻²⁰ counts per code.
    pub proportional: i32,
    /// Integral gain K_i over one PWM period, 2⁻²⁰ counts per code.
    pub integral: i32,
    /// Largest voltage of either sign, timer counts.
    pub limit: i32,
    /// Largest reference current of either sign, codes.
    pub most: i32,
}

/// PWM periods in one control period.
///
/// # Errors
/// A control period that is not a whole number of PWM periods.
pub fn periods_per_tick(settings: &Settings) -> Result<u32, Refused<'static>> {
    let periods = settings.timing.control_period_s * f64::from(PWM_HZ);
    // From a tenth of a period to 2000: the cast is exact.
    let whole = (periods + 0.5) as u32;
    let fits = whole > 0 && (periods - f64::from(whole)).abs() < 1e-6;
    let allowed = Allowed::Only("with a current loop a whole number of PWM periods of 0.00005");
    if fits { Ok(whole) } else { Err(settings.refuses("timing.control_period_s", allowed)) }
}

/// Part of `motor.sense_a` that a sensor measures, 3.07 V of 3.3 V. Its amplifier ends 0.2 V below its supply (TI SBOS808E, INA240: 3.10 V).
pub const REACHED: f64 = 0.86;

/// Mean delay of the current behind its reference, s: the area between a unit step of the reference and the response to
/// it. Summed sample by sample that area is 1/ω_c in any such loop; half a PWM period of it lies before the step.
pub fn lag_s(settings: &Settings) -> f64 {
    1.0 / (TAU * settings.motor.current_loop_hz) - 0.5 * PWM_PERIOD_S
}

impl CurrentLoop {
    /// From the table `motor`, for a PWM timer in which `counts` stands for the full supply.
    ///
    /// # Errors
    /// A winding whose gains cannot be written as whole numbers for every supply of [`SUPPLY_MV`]; a sensor that does not measure
    /// a tenth more than the largest reference ([`REACHED`]); a control period that is not a whole number of PWM periods.
    pub fn build(settings: &Settings, counts: u16) -> Result<Self, Refused<'static>> {
        periods_per_tick(settings)?;
        let motor = &settings.motor;
        let volts_per_code = motor.full_scale_a / f64::from(Duty::FULL_SCALE);
        let crossover = TAU * motor.current_loop_hz;
        // What 1 V is at 1 mV of supply.
        let volt = 1e3 * f64::from(counts.max(1)) * f64::from(1_u32 << FRACTION);
        let (per_henry, per_ohm) =
            (crossover * volts_per_code * volt, crossover * PWM_PERIOD_S * volts_per_code * volt);
        let within = |key, per_unit: f64| {
            let (low, high) = (f64::from(*SUPPLY_MV.start()), f64::from(*SUPPLY_MV.end()));
            let [min, max] = [GAINS[0] * high / per_unit, GAINS[1] * low / per_unit];
            settings.within(key, Allowed::Number { min, max })
        };
        within("motor.inductance_h", per_henry)?;
        within("motor.resistance_ohm", per_ohm)?;
        let least = 1.1 * motor.max_duty * motor.full_scale_a / REACHED;
        settings.within("motor.sense_a", Allowed::Number { min: least, max: f64::MAX })?;
        let towards = if motor.reversed { -1.0 } else { 1.0 };
        let forward = if motor.back_emf_forward { towards * motor.newton_or_newton_metre_per_a } else { 0.0 };
        Ok(Self {
            proportional: (per_henry * motor.inductance_h) as f32,
            integral: (per_ohm * motor.resistance_ohm) as f32,
            forward: (forward * 1e3 * f64::from(counts)) as f32,
            limit: (MOST_VOLTAGE * f64::from(counts)) as i32,
            most: (motor.max_duty * f64::from(Duty::FULL_SCALE)) as i32,
        })
    }

    /// The gains at this supply (mV).
    #[inline]
    pub fn gains(&self, supply_mv: u32) -> Gains {
        let per_mv = per_mv(supply_mv);
        Gains {
            // Within GAINS, to rounding: checked when it was built.
            proportional: (self.proportional * per_mv) as i32,
            integral: (self.integral * per_mv) as i32,
            limit: self.limit,
            most: self.most,
        }
    }

    /// The expected back-EMF of a joint at this speed (m/s or rad/s), counts: 0 unless `motor.back_emf_forward`.
    #[inline]
    pub fn forward(&self, joint_speed: f32, supply_mv: u32) -> i32 {
        // A cast saturates, and takes NaN to 0.
        (self.forward * joint_speed * per_mv(supply_mv)) as i32
    }
}

fn per_mv(supply_mv: u32) -> f32 {
    1.0 / supply_mv.clamp(*SUPPLY_MV.start(), *SUPPLY_MV.end()) as f32
}

/// State of one motor's loop; at rest when it begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Controller {
    /// Voltage so far, 2⁻²⁰ counts.
    integral: i64,
}

impl Controller {
    /// The voltage for the next PWM period, counts, that brings the `measured` current (codes) toward the reference.
    /// `forward` is the expected back-EMF, counts.
    #[inline(always)]
    pub fn step(&mut self, gains: &Gains, Duty(reference): Duty, measured: i32, forward: i32) -> i32 {
        let reference = i32::from(reference).max(-gains.most).min(gains.most);
        let error = i64::from(reference.saturating_sub(measured));
        let limit = i64::from(gains.limit) << FRACTION;
        let wanted = error * i64::from(gains.proportional) + self.integral + (i64::from(forward) << FRACTION);
        let given = wanted.max(-limit).min(limit);
        if wanted == given || (wanted > 0) != (error > 0) {
            self.integral = (self.integral + error * i64::from(gains.integral)).max(-limit).min(limit);
        }
        ((given + (1 << (FRACTION - 1))) >> FRACTION) as i32
    }
}

/// Converts a reading of the analogue-to-digital converter to a current; the default gives no current.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sensor {
    /// Reading of the converter at zero current, converter steps.
    pub zero: i32,
    /// Codes per step of the converter, 2⁻¹²: a sensor of 1 % of full scale to one of a hundred times it.
    codes_per_step: i32,
}

/// Fractional bits of [`Sensor::codes_per_step`].
const SCALE: u32 = 12;

impl Sensor {
    /// For a converter of this many bits (8 to 16) that spans −`motor.sense_a` to `motor.sense_a`, its zero in the middle until it
    /// has been measured.
    pub fn build(settings: &Settings, bits: u32) -> Self {
        let half = 1_i32 << (bits.clamp(8, 16) - 1);
        let motor = &settings.motor;
        let per_step = f64::from(Duty::FULL_SCALE) * motor.sense_a / motor.full_scale_a / f64::from(half);
        // A cast saturates: at most 2³¹, times 17 bits.
        Self { zero: half, codes_per_step: (per_step * f64::from(1_u32 << SCALE) + 0.5) as i32 }
    }

    /// The current that a reading of the converter stands for, codes.
    #[inline(always)]
    pub fn codes(self, read: u16) -> i32 {
        let codes = (i64::from(i32::from(read) - self.zero) * i64::from(self.codes_per_step)) >> SCALE;
        codes.max(-i64::from(i32::MAX)).min(i64::from(i32::MAX)) as i32
    }
}
