//! What the power stage of the motors measured since the tick before: currents, voltages, the bridges' supply, and a temperature.
//!
//! Only a device with a current loop ([`super::current`]) has it. The loop runs once a PWM period and the tick once a control
//! period, so the means are over the PWM periods in between, each with its current as it begins and the voltage applied in it.
//!
//! Units: currents in codes, 1/32767 of `motor.full_scale_a`, as a [`super::motor::Duty`]; a larger current saturates.
//! Voltages in counts of the timer, of which the supply has [`Measured::supply_counts`]. Both along the motor: positive
//! as a positive duty makes them.

use crate::device::AXES;

/// Current and voltage of one motor in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flow {
    /// Mean of the current, codes.
    pub mean: i16,
    /// The last current that was sampled, codes.
    pub last: i16,
    /// Mean of the voltage that the bridge gave, counts; 0 while it is off.
    pub voltage: i16,
}

impl Flow {
    /// From sums over `periods` PWM periods (1 or more) of the currents sampled at their beginnings (codes) and of the voltages
    /// applied (counts). Means are rounded to nearest: truncated toward zero, they would look like a motor of less back-EMF.
    #[inline]
    pub fn of(currents: i32, voltages: i32, last: i32, periods: i32) -> Self {
        // What does not fit is at the end of the numbers: the casts are exact.
        let held = |number: i32| number.max(-i32::from(i16::MAX)).min(i32::from(i16::MAX)) as i16;
        let half = periods / 2;
        let mean = |sum: i32| {
            let away = if sum < 0 { sum.saturating_sub(half) } else { sum.saturating_add(half) };
            held(away.checked_div(periods).unwrap_or_default())
        };
        Self { mean: mean(currents), last: held(last), voltage: mean(voltages) }
    }
}

/// What the power stage measured since the tick before.
// Of halves: it is copied in words all the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(align(4))]
pub struct Measured<const N: usize = AXES> {
    /// Current and voltage of each motor.
    pub motors: [Flow; N],
    /// Supply of the bridges, mV.
    pub supply_mv: u16,
    /// Timer counts that stand for the whole supply.
    pub supply_counts: u16,
    /// How warm the thermistor of a motor is ([`super::thermal::Thermistor::code`]); 0 without one.
    pub thermistor: u8,
}

/// Nothing flows, and there is no supply.
impl<const N: usize> Default for Measured<N> {
    fn default() -> Self {
        Self { motors: [Flow::default(); N], supply_mv: 0, supply_counts: 0, thermistor: 0 }
    }
}
