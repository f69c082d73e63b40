//! How warm a motor's winding is, from the current that flowed through it: I²t.
//!
//! One thermal mass: the leaky mean ([`super::leaky`]) of the square of the current over τ = `motor.thermal_s` may not pass
//! the square of `motor.continuous_a`. A constant current i from cold is too much after −τ·ln(1 − (continuous/i)²), to within
//! 2⁻¹⁰·τ; one up to `continuous_a` never is. Squares are first summed for that long, so that `f32` does not lose them.
//!
//! **It limits.** From half of that square on, the largest force of every axis falls with what is left of it, to that of [`LASTS`] of
//! `continuous_a` ([`super::envelope`] has the same for the hand). So a winding comes near its limit and stays below, however long a hand
//! presses, and only one that carries more than was asked for is a fault.
//!
//! **A thermistor** ([`Thermistor`]), if there is one, adds a second limit: the force falls from half of the way between 25 °C and
//! `motor.max_temperature_c` on, to a 32nd there. It can only take force away. Limits: it shows the place where it is glued, which follows
//! the winding late, so the model above stays on; the force falls in steps of a 64th.
//!
//! Units: A, A². Limits: the surroundings are as warm as where `continuous_a` was measured; a restart begins cold, so who restarts
//! waits; the copper's own, faster time is within τ; what the current does between two readings is not in its mean.

use crate::{device::leaky::Leaky, num::Scalar, settings::Settings};

/// Means that τ is resolved into.
const STEPS: f64 = 1024.0;

/// Share of `motor.continuous_a` that a winding near its limit is left: sensors are off by less than the rest.
pub const LASTS: f64 = 0.9;

/// What [`Thermistor::code`] gives at `motor.max_temperature_c`; a thermistor that is open or shorted gives one more.
pub const HOT: u8 = 62;

/// The thermistor at a motor, below a resistor as large as its own is at 25 °C: its reading, of 65536, where the force begins to fall, and 65536 times
/// the codes for each of them below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermistor([i32; 2]);

impl Thermistor {
    /// From `motor.thermistor_b_k` and `motor.max_temperature_c`; none without `motor.thermistor`.
    pub fn build(settings: &Settings) -> Option<Self> {
        let motor = &settings.motor;
        let reads = |celsius: f64| {
            let ohms = libm::exp(motor.thermistor_b_k * (1.0 / (celsius + 273.15) - 1.0 / 298.15));
            65536.0 * ohms / (1.0 + ohms)
        };
        let near = reads(0.5 * (25.0 + motor.max_temperature_c));
        let steep = 65536.0 * f64::from(HOT) / (near - reads(motor.max_temperature_c));
        // The next whole numbers: no later than at the limit.
        let this = [near, steep].map(|number| number as i32 + 1);
        motor.thermistor.then_some(Self(this))
    }

    /// How warm the motor is, from the share of the reference over the thermistor, of 65536: 0 up to where the force begins to fall.
    ///
    /// Open or shorted is what reads within a 64th of either end: -39 °C and 125 °C are not.
    #[inline]
    pub fn code(&self, read: u16) -> u8 {
        let Self([near, steep]) = self;
        // Less than 2¹⁶ times 2¹¹.
        let code = (((near - i32::from(read)) * steep) >> 16).clamp(0, HOT.into()) as u8;
        let broken = read.wrapping_add(1024) < 2048;
        if broken { HOT + 1 } else { code }
    }
}

/// The thermal limit of one motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal<S> {
    leaky: Leaky<S>,
    /// Readings to a step of the mean, and 1 over them and over the square of the limit, 1/A².
    readings: u32,
    share: S,
}

configured!([S: Scalar] Thermal<S> { leaky, readings, share });

/// Mean square of one motor's current, as a share of its limit, and the readings since it was last taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Heat<S> {
    /// From 0 to 1, at which it is too warm.
    pub mean: S,
    sum: S,
    readings: u32,
}

impl<S: Scalar> Thermal<S> {
    /// From `motor.continuous_a` and `motor.thermal_s`, for one reading every `period_s` (s).
    pub fn build(settings: &Settings, period_s: f64) -> Self {
        let motor = &settings.motor;
        // At most 10 s of 10 µs: the cast is exact.
        let readings = ((motor.thermal_s / STEPS / period_s) as u32).max(1);
        Self {
            leaky: Leaky::new(period_s * f64::from(readings), motor.thermal_s),
            readings,
            share: S::from_f64(1.0 / (f64::from(readings) * motor.continuous_a * motor.continuous_a)),
        }
    }

    /// Takes one reading of the current, A; true if the winding is warmer than it may be.
    #[inline]
    pub fn is_too_warm(&self, heat: &mut Heat<S>, current_a: S) -> bool {
        // In each reading its share: a sum of squares would leave the range of fixed point.
        heat.sum = heat.sum + current_a * (current_a * self.share);
        heat.readings += 1;
        if heat.readings >= self.readings {
            *heat = Heat { mean: self.leaky.after(heat.mean, heat.sum), ..Heat::default() };
        }
        heat.mean > S::ONE
    }
}
