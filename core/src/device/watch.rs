//! Watching encoders while the motors are on: does the device answer its motors, and not against all physics?
//!
//! **Stuck.** A device at rest under a constant force cannot be told from an encoder that is stuck, and does no harm. But
//! a force that changes must move what it acts on, by more than the one count that an encoder with a cut wire, or at rest on
//! an edge, goes to and fro. So: since a joint's encoder last counted further than that, the duties of its motor may not
//! have ranged over more than `safety.stuck_duty`. What follows: with a stuck encoder the force changes by no more than
//! that before the motors go off. Looked at once a packet period, in the tick before the packet is due: motion that comes
//! back by then is not seen, force that changes more slowly is.
//!
//! **Runaway.** With an encoder that counts the wrong way, what the controller brakes gets faster. The hand then seems to
//! feed the device a power P = −F·v that no hand has: more than `safety.max_hand_power_w` is not believed. Every tick.
//!
//! Both only where positions come from encoders: the exact readings of a simulator are not to be doubted.
//!
//! What cannot be seen: a stuck encoder while nothing changes the force, or where `safety.max_force_n` keeps the duties within
//! `safety.stuck_duty` of each other; one that counts too few or too many; one that counts the wrong way before any force
//! acts. And a device pressed against a stop harder than `safety.stuck_duty`, or struck with more power than
//! `safety.max_hand_power_w`, looks broken without being so.

use crate::{device::motor::Duty, num::Scalar, settings::Settings};

/// What is not believed.
#[derive(Clone, Copy, Debug)]
pub struct Watch<S> {
    stuck_codes: i32,
    /// That the device gives the hand, W: the most that a hand can feed it, negative.
    least_power: S,
}

/// Counts that an encoder may go to and fro by without having moved.
const DITHER: u32 = 2;

/// One joint since its encoder last counted further than it dithers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Still {
    counts: i32,
    low: i16,
    high: i16,
}

impl<S: Scalar> Watch<S> {
    /// From `safety.stuck_duty` and `safety.max_hand_power_w`.
    pub fn build(settings: &Settings) -> Self {
        let safety = &settings.safety;
        Self {
            stuck_codes: (safety.stuck_duty * f64::from(Duty::FULL_SCALE)) as i32,
            least_power: S::from_f64(-safety.max_hand_power_w),
        }
    }

    /// A joint's counts and duty, once a packet period: its force has changed too much for an encoder that does not count.
    #[inline]
    pub fn is_stuck(&self, still: &mut Still, counts: i32, Duty(duty): Duty) -> bool {
        *still = if counts.abs_diff(still.counts) <= DITHER {
            Still { counts: still.counts, low: still.low.min(duty), high: still.high.max(duty) }
        } else {
            Still { counts, low: duty, high: duty }
        };
        i32::from(still.high) - i32::from(still.low) > self.stuck_codes
    }

    /// The power (W) that the device gives the hand, every tick: whether the hand seems to feed it more than a hand can.
    #[inline]
    pub fn is_too_much(&self, power: S) -> bool {
        power < self.least_power
    }
}
