//! How often the tick comes, and times that a board's parts need, in ticks.
//!
//! The scene asks for a control period of 1, 0.5, 0.25 or 0.2 ms: a whole number of ticks to a millisecond, and of PWM periods to a tick.
//! What takes time, such as a bridge that wakes, is a constant in milliseconds ([`Ms`]) and is counted in the ticks of the rate at hand.

use cohold_core::settings::Timing;

/// Milliseconds, not ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ms(pub u32);

/// How many ticks a millisecond has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// One, which a board has without a scene.
    Khz1 = 1,
    /// Two.
    Khz2 = 2,
    /// Four.
    Khz4 = 4,
    /// Five.
    Khz5 = 5,
}

impl Rate {
    /// All that there are.
    pub const ALL: [Self; 4] = [Self::Khz1, Self::Khz2, Self::Khz4, Self::Khz5];
    /// Their control periods, as a refusal says them.
    pub const PERIODS: &'static str = "0.001, 0.0005, 0.00025 or 0.0002, the periods that the board's tick can have";

    /// The rate of this control period, if a board can have it.
    pub fn of(timing: &Timing) -> Option<Self> {
        Self::ALL.into_iter().find(|rate| rate.period_s() == timing.control_period_s)
    }

    /// The control period T_c, s.
    pub fn period_s(self) -> f64 {
        0.001 / f64::from(self.per_ms())
    }

    /// The same as a number, 1 to 5.
    pub const fn per_ms(self) -> u32 {
        self as u32
    }

    /// How many ticks a time lasts.
    pub const fn ticks(self, Ms(ms): Ms) -> u32 {
        ms.saturating_mul(self.per_ms())
    }
}
