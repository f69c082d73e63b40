//! From joints to the axes of the task, and from axis forces back to joint forces.
//!
//! | name | mechanism | joints | axes |
//! |---|---|---|---|
//! | `direct` | each joint is an axis | 2 slides | 2 |
//! | `capstan` | a motor drives a paddle through a capstan | 1 turning | 1 |
//! | `five-bar` | two motors on a base, two links each, one hand | 2 turning | 2 |
//!
//! Design: one call gives positions, velocities and the Jacobian J of a pose; velocities are J·q̇ and joint forces
//! Jᵀ·F, from the same J, so that the power at the joints is the power at the axes to rounding: τ·q̇ = F·ẋ.
//!
//! Units: joints m or rad, axes m; J in m/m or m/rad; joint forces N or N·m.

pub mod capstan;
pub mod five_bar;

use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};
use crate::{device::AXES, model::Model};

pub use crate::names::{KinematicsName, Maths};

/// Where the axes are, and how the joints move them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose<S> {
    /// Position (m) and velocity (m/s) of every axis.
    pub axes: [Motion<S>; AXES],
    /// How axes move with joints, `jacobian[axis][joint]`, m per m or m per rad.
    pub jacobian: [[S; AXES]; AXES],
}

impl<S: Scalar> Pose<S> {
    /// The pose of a device whose joints are its axes: the Jacobian is the identity.
    #[inline]
    pub fn direct(axes: [Motion<S>; AXES]) -> Self {
        Self { axes, jacobian: [[S::ONE, S::ZERO], [S::ZERO, S::ONE]] }
    }

    /// The pose at `positions` (m), with the velocities that `jacobian` gives to the joints' motion.
    #[inline]
    fn moving(positions: [S; AXES], jacobian: [[S; AXES]; AXES], joints: [Motion<S>; AXES]) -> Self {
        let ([x, y], [[xa, xb], [ya, yb]], [a, b]) = (positions, jacobian, joints);
        let axes = [
            Motion { position: x, velocity: xa * a.velocity + xb * b.velocity },
            Motion { position: y, velocity: ya * a.velocity + yb * b.velocity },
        ];
        Self { axes, jacobian }
    }

    /// Joint forces (N or N·m) that act on the axes like `forces` (N): the transpose of the Jacobian.
    #[inline]
    pub fn joint_forces(&self, forces: [S; AXES]) -> [S; AXES] {
        let ([[xa, xb], [ya, yb]], [x, y]) = (self.jacobian, forces);
        [xa * x + ya * y, xb * x + yb * y]
    }
}

/// A mechanism.
pub trait Kinematics<S: Scalar>: Model<S> {
    /// The pose for the joints' positions (m or rad, zero where the encoders were first read) and velocities.
    fn forward(&self, joints: [Motion<S>; AXES]) -> Pose<S>;
}

/// No mechanism between joints and axes: for slides, and for simulated devices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Direct;

impl<S: Scalar> Model<S> for Direct {
    type State = ();
    fn build(_: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self)
    }
}

impl<S: Scalar> Kinematics<S> for Direct {
    #[inline]
    fn forward(&self, joints: [Motion<S>; AXES]) -> Pose<S> {
        Pose::direct(joints)
    }
}

list! {
    /// Any one of the mechanisms.
    AnyKinematics, named by KinematicsName in kinematics.model {
        Direct(Direct),
        Capstan(capstan::Capstan<S>),
        FiveBar(five_bar::FiveBar<S>),
    }
}

impl<S: Scalar> AnyKinematics<S> {
    /// [`Kinematics::forward`].
    #[inline]
    pub fn forward(&self, joints: [Motion<S>; AXES]) -> Pose<S> {
        each!(self: Direct | Capstan | FiveBar, model => model.forward(joints))
    }
}

impl Maths {
    /// Sine and cosine of an angle in rad.
    #[inline]
    fn sin_cos<S: Scalar>(self, angle: S) -> (S, S) {
        match self {
            Self::Libm => angle.sin_cos(),
            Self::Micromath => angle.sin_cos_fast(),
        }
    }
}

/// What encoders, estimators and current loops need to know about a mechanism's joints.
#[derive(Clone, Copy, Debug)]
pub struct Joints {
    /// Encoder counts per m of a slide, or per rad of a joint that turns.
    pub counts_per_unit: f64,
    /// The most that a joint moves (m or rad) when the hand moves by one metre, for plausibility limits.
    pub most_per_m: f64,
    /// The same in a usual pose.
    pub usual_per_m: f64,
}

impl Joints {
    /// Of the mechanism that the settings name.
    pub fn of(settings: &Settings) -> Self {
        let kinematics = &settings.kinematics;
        let slide = settings.encoder.counts_per_m;
        let turning = settings.encoder.counts_per_rev / core::f64::consts::TAU;
        let (counts_per_unit, usual_per_m, least_sine) = match kinematics.model {
            KinematicsName::Direct => (slide, 1.0, 1.0),
            KinematicsName::Capstan => (turning, kinematics.capstan_ratio / kinematics.paddle_radius_m, 1.0),
            KinematicsName::FiveBar => (turning, 1.0 / kinematics.proximal_m, five_bar::MIN_ELBOW_SINE),
        };
        Self { counts_per_unit, most_per_m: usual_per_m / least_sine, usual_per_m }
    }
}
