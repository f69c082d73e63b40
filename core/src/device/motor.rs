//! Joint force to the duty of a motor amplifier in current mode, and back.
//!
//! Design: force = constant · current and current = full scale · duty, so one product each way; the duty is rounded to
//! the nearest code, ties away from zero, and held within `motor.max_duty`.
//!
//! Units: N for a slide, N·m for a joint that turns; duty in 1/32767 of full scale.
//!
//! Invariants: |duty| ≤ max_duty whatever comes in; NaN gives no duty at all.
//!
//! **Friction.** Of the dry friction of an axis the motor takes over a force f = `motor.friction_n` that goes with the velocity, from
//! −f to f within [`FROM_REST`] either way. While f is less than the friction, motor and friction together take energy at any velocity,
//! however late or noisy the one is that f goes by: the friction takes more than f·|v|, and the motor gives at the most that.
//!
//! Limits: no amplifier dynamics, no compensation of cogging.

use crate::{num::Motion, num::Scalar, settings::Settings};

/// Velocity at which the whole of `motor.friction_n` acts, m/s.
pub const FROM_REST: f64 = 0.02;

/// Signed duty of an amplifier; [`Duty::FULL_SCALE`] is full current.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Duty(pub i16);

impl Duty {
    /// The code of full current.
    pub const FULL_SCALE: i16 = i16::MAX;
    /// The code of zero current.
    pub const OFF: Self = Self(0);
}

/// Motor and amplifier of every joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor<S> {
    /// Codes per N or N·m; negative where positive duty pushes against the axis.
    codes_per_force: S,
    force_per_code: S,
    /// Largest code, a whole number ≤ [`Duty::FULL_SCALE`].
    max_code: S,
    /// Dry friction that it takes over, N, and that for each m/s from rest on.
    pub friction: S,
    from_rest: S,
}

configured!([S: Scalar] Motor<S> { codes_per_force, force_per_code, max_code, friction, from_rest });

impl<S: Scalar> Motor<S> {
    /// From the table `motor`.
    pub fn build(settings: &Settings) -> Self {
        let motor = &settings.motor;
        let full_scale_force = motor.newton_or_newton_metre_per_a * motor.full_scale_a;
        let full_scale_force = if motor.reversed { -full_scale_force } else { full_scale_force };
        let full_scale_code = f64::from(Duty::FULL_SCALE);
        let max_code = (motor.max_duty * full_scale_code) as i32;
        Self {
            codes_per_force: S::from_f64(full_scale_code / full_scale_force),
            force_per_code: S::from_f64(full_scale_force / full_scale_code),
            max_code: S::from_i32(max_code.clamp(0, i32::from(Duty::FULL_SCALE))),
            friction: S::from_f64(motor.friction_n),
            from_rest: S::from_f64(motor.friction_n / FROM_REST),
        }
    }

    /// Forces along axes that move like this (N), with what it takes over of their friction.
    #[cold]
    #[inline(never)]
    pub fn eased<const N: usize>(&self, mut forces: [S; N], axes: &[Motion<S>; N]) -> [S; N] {
        for (force, motion) in forces.iter_mut().zip(axes) {
            *force = *force + (motion.velocity * self.from_rest).limit(self.friction);
        }
        forces
    }

    /// Duty for a force along the joint (N or N·m), and whether the force was more than the duty limit gives.
    #[inline]
    pub fn duty(&self, joint_force: S) -> (Duty, bool) {
        let wanted = joint_force * self.codes_per_force;
        // At most ±32767, and no NaN: the cast is exact.
        let code = wanted.limit(self.max_code);
        (Duty(code.to_code()), code != wanted)
    }

    /// Force along the joint (N or N·m) that a duty gives: the inverse of [`Motor::duty`], to half a code.
    #[inline]
    pub fn joint_force(&self, duty: Duty) -> S {
        S::from_i32(i32::from(duty.0)) * self.force_per_code
    }
}
