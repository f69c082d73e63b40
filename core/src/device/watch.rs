//! Watching encoders while the motors are on: does the device answer its motors, and not against all physics?
//!
//! **Stuck.** A device at rest under a constant force cannot be distinguished from an encoder that is stuck, and does no harm.
//! But a force that changes must move what it acts on, by more than the one count that an encoder with a cut wire, or at rest on
//! an edge, goes to and fro. So: since a joint's encoder last moved further than that, the duties of its motor may not have
//! ranged over more than `safety.stuck_duty`, nor over more than half of what `safety.max_force_n` asks of it, or [`HELD_N`] if
//! that is more: a device set to small forces is checked at small ones. With a stuck encoder the motors go off four to eight
//! ticks after the force has changed by that. It is checked every fourth tick, of which none is that of an exchange where packets are a multiple
//! of four ticks apart: motion that comes back by then is not seen, a force that changes more slowly is; and a force has four ticks to move
//! something.
//!
//! **Runaway.** With an encoder that counts the wrong way, what the controller brakes gets faster. The hand then seems to
//! feed the device a power P = −F·v that no hand has: more than `safety.max_hand_power_w` is not believed. Every tick.
//!
//! Both only where positions come from encoders: the exact readings of a simulator are not to be doubted.
//!
//! What cannot be seen: a stuck encoder while nothing changes the force; one that counts too few or too many; one that
//! counts the wrong way before any force acts. And a device pressed against a stop harder than that, or held by
//! friction of as much, or struck with more power than `safety.max_hand_power_w`, looks broken without being so; so does a contact far
//! beyond its stability that chatters between small limits, 3 N at 4000 N/m, by less than two counts.

use crate::device::kinematics::Joints;
use crate::{device::motor::Duty, num::Scalar, settings::Settings};

/// Limits beyond which encoders are not believed.
#[derive(Clone, Copy, Debug)]
pub struct Watch<S> {
    stuck_codes: i32,
    /// That the device gives the hand, W: the most that a hand can feed it, negative.
    least_power: S,
}

configured!([S: Scalar] Watch<S> { stuck_codes, least_power });

/// Counts that an encoder may go to and fro by without having moved.
const DITHER: u32 = 2;

/// Force on the hand that friction or a firm grip may hold without the encoder moving, N.
pub const HELD_N: f64 = 1.0;

/// Memory of one joint since its encoder last moved beyond dithering.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Still {
    counts: i32,
    low: i16,
    high: i16,
}

impl<S: Scalar> Watch<S> {
    /// From `safety.stuck_duty`, `safety.max_force_n` and `safety.max_hand_power_w`, in the world's units.
    pub fn build(settings: &Settings) -> Self {
        let (safety, motor) = (&settings.safety, &settings.motor);
        // What the largest force on the hand asks of a joint, in a usual pose.
        let full = motor.newton_or_newton_metre_per_a * motor.full_scale_a * Joints::of(settings).usual_per_m;
        let duty = safety.stuck_duty.min((0.5 * safety.max_force_n).max(HELD_N * settings.scale.force) / full);
        Self {
            stuck_codes: (duty * f64::from(Duty::FULL_SCALE)) as i32,
            least_power: S::from_f64(-safety.max_hand_power_w),
        }
    }

    /// Whether it looks for what is stuck in this tick, the first of which is 1.
    #[inline]
    pub fn looks(tick: u32) -> bool {
        tick & 3 == 0
    }

    /// Takes a joint's counts and duty where the watch [looks](Watch::looks): whether its force has changed too much for an encoder that
    /// does not count.
    #[inline]
    pub fn is_stuck(&self, still: &mut Still, counts: i32, Duty(duty): Duty) -> bool {
        if counts.abs_diff(still.counts) > DITHER {
            *still = Still { counts, low: duty, high: duty };
            return false;
        }
        // Without the duty of this tick, which has moved nothing yet.
        let stuck = i32::from(still.high) - i32::from(still.low) > self.stuck_codes;
        (still.low, still.high) = (still.low.min(duty), still.high.max(duty));
        stuck
    }

    /// Takes the power (W) that the device gives the hand, every tick: whether the hand seems to feed in more than a
    /// hand can.
    #[inline]
    pub fn is_too_much(&self, power: S) -> bool {
        power < self.least_power
    }
}
