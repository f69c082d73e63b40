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
//! **Cogging.** A motor of period p pushes its joint, which is at q, with A·sin(2π·(q − q₀)/p). The motor adds the negative of that, with
//! A = `motor.cogging_n_or_n_m`. A wrong place would double the cogging, so it is added only while the encoder's index says where the joint is
//! ([`super::encoder::Encoder::absolute`]), and it is at most [`COGGING_SHARE`] of the largest force. The added force is a spring of up to
//! k = 2π·A/p, which follows the joint d late. So for a moment it gives up to k·d·v². If the damping of the device is at least k·d, motor,
//! cogging and damping together take energy at any motion. *Example:* 0.2 N over 5 mm, 2 ms late, need 0.50 N·s/m.
//!
//! Limits: no amplifier dynamics. Of cogging the first harmonic, for a device of one axis whose joint has a constant lever.

use core::f64::consts::TAU;

use crate::device::kinematics::{Joints, KinematicsName};
use crate::num::{Motion, Scalar};
use crate::settings::{Allowed, Refused, Settings};

/// Velocity at which the whole of `motor.friction_n` acts, m/s.
pub const FROM_REST: f64 = 0.02;
/// Largest cogging that is cancelled, as a share of `safety.max_force_n`.
pub const COGGING_SHARE: f64 = 0.2;
/// By how much the periods in a turn may miss a whole number: 4° of phase for each turn.
const WHOLE: f64 = 0.01;
/// Without this the index gives cogging no place.
const KNOWN: &str = "0 but with encoder.index = true, axis.count = 1 and a period that divides a turn of the joint";

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
    friction: S,
    from_rest: S,
    /// Cogging that it cancels, as a force along the axis, N; periods to a metre or radian of the joint, and where one begins.
    cogging: S,
    periods: S,
    cogging_at: S,
    /// There is any of that.
    pub eases: bool,
}

configured!([S: Scalar] Motor<S> { codes_per_force, force_per_code, max_code, friction, from_rest, cogging, periods, cogging_at, eases });

/// Refuses cogging whose phase is not known, or that is more than a modest share of the largest force.
///
/// # Errors
/// The key, and what it must be.
pub fn check(settings: &Settings) -> Result<(), Refused<'static>> {
    let motor = &settings.motor;
    let max = COGGING_SHARE * settings.safety.max_force_n / Joints::of(settings).usual_per_m;
    settings.within("motor.cogging_n_or_n_m", Allowed::Number { min: 0.0, max })?;
    let parts = TAU / motor.cogging_period_m_or_rad;
    let is_part = (parts - f64::from(parts.round_to_i32())).abs() <= WHOLE;
    let fits = is_part || settings.kinematics.model == KinematicsName::Direct;
    let is_known = fits && settings.encoder.index && settings.axis.count == 1;
    settings.all_fit(&[("motor.cogging_n_or_n_m", is_known || motor.cogging_n_or_n_m == 0.0, KNOWN)])
}

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
            cogging: S::from_f64(motor.cogging_n_or_n_m * Joints::of(settings).usual_per_m),
            periods: S::from_f64(1.0 / motor.cogging_period_m_or_rad),
            cogging_at: S::from_f64(motor.cogging_at_m_or_rad),
            eases: motor.friction_n > 0.0 || motor.cogging_n_or_n_m > 0.0,
        }
    }

    /// Adds to forces along axes that move like this (N) what it takes over of their friction, and what cancels the cogging of the first
    /// joint if its place is known (m or rad).
    #[cold]
    #[inline(never)]
    pub fn eased<const N: usize>(&self, forces: &mut [S; N], axes: &[Motion<S>; N], at: Option<S>) {
        for (force, motion) in forces.iter_mut().zip(axes) {
            *force = *force + (motion.velocity * self.from_rest).limit(self.friction);
        }
        if let (Some(force), Some(at)) = (forces.first_mut(), at) {
            // Whole periods first: so the angle is as exact as the place.
            let periods = (at - self.cogging_at) * self.periods;
            let angle = S::from_f64(TAU) * (periods - S::from_i32(periods.round_to_i32()));
            *force = *force - (self.cogging * angle.sin_cos_fast().0).limit(self.cogging);
        }
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
