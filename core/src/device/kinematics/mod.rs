//! From joints to the axes of the task, and from axis forces back to joint forces.
//!
//! | name | mechanism | joints | axes |
//! |---|---|---|---|
//! | `direct` | each joint is an axis | 2 or 3 slides | 2 or 3 |
//! | `capstan` | a motor drives a paddle through a capstan | 1 turning | 1 |
//! | `five-bar` | two motors on a base, two links each, one hand | 2 turning | 2 |
//! | `arm` | two links on a turning base, the outer one held by a parallelogram | 3 turning | 3 |
//!
//! Design: one call gives positions, velocities and the Jacobian J of a pose; velocities are J·q̇ and joint forces
//! Jᵀ·F, from the same J, so that the power at the joints is the power at the axes to rounding: τ·q̇ = F·ẋ.
//!
//! Units: joints m or rad, axes m; J in m/m or m/rad; joint forces N or N·m.

pub mod arm;
pub mod capstan;
pub mod five_bar;

use crate::num::{Configured, Motion, Scalar};
use crate::settings::{Allowed, Refused, Settings};
use crate::{device::AXES, model::Model};

pub use crate::names::{KinematicsName, Maths};

/// Pose of a device: position and velocity of its axes, and the Jacobian of the joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<S, const N: usize = AXES> {
    /// Position (m) and velocity (m/s) of every axis.
    pub axes: [Motion<S>; N],
    /// How axes move with joints, `jacobian[axis][joint]`, m per m or m per rad.
    pub jacobian: [[S; N]; N],
}

impl<S: Scalar, const N: usize> Pose<S, N> {
    /// The pose of a device whose joints are its axes: the Jacobian is the identity.
    #[inline]
    pub fn direct(axes: [Motion<S>; N]) -> Self {
        let mut jacobian = [[S::ZERO; N]; N];
        for (at, row) in jacobian.iter_mut().enumerate() {
            if let Some(own) = row.get_mut(at) {
                *own = S::ONE;
            }
        }
        Self { axes, jacobian }
    }

    /// The pose at `positions` (m), with the velocities that `jacobian` gives to the joints' motion.
    #[inline]
    fn moving(positions: [S; N], jacobian: [[S; N]; N], joints: [Motion<S>; N]) -> Self {
        let mut axes = positions.map(Motion::at);
        for (axis, row) in axes.iter_mut().zip(&jacobian) {
            let moved = row.iter().zip(&joints).map(|(share, joint)| *share * joint.velocity);
            axis.velocity = moved.reduce(|sum, one| sum + one).unwrap_or(S::ZERO);
        }
        Self { axes, jacobian }
    }

    /// Joint forces (N or N·m) that act on the axes like `forces` (N): the transpose of the Jacobian.
    #[inline]
    pub fn joint_forces(&self, forces: [S; N]) -> [S; N] {
        let mut rows = self.jacobian.iter().zip(&forces);
        let mut joints = [S::ZERO; N];
        if let Some((row, force)) = rows.next() {
            joints = row.map(|share| share * *force);
        }
        for (row, force) in rows {
            for (joint, share) in joints.iter_mut().zip(row) {
                *joint = *joint + *share * *force;
            }
        }
        joints
    }

    /// Whether the Jacobian is zero, by which a mechanism reports that its pose is singular.
    #[inline]
    pub fn is_singular(&self) -> bool {
        self.jacobian.as_flattened().iter().all(|share| *share == S::ZERO)
    }
}

/// A mechanism: how its joints move the hand along the axes of the task.
pub trait Kinematics<S: Scalar, const N: usize = AXES>: Model<S> {
    /// The pose for the joints' positions (m or rad, zero where the encoders were first read) and velocities.
    fn forward(&self, joints: [Motion<S>; N]) -> Pose<S, N>;
}

/// No mechanism between joints and axes: for slides, and for simulated devices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Direct;

configured!([] Direct {});

impl<S: Scalar> Model<S> for Direct {
    type State = ();
    fn build(_: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self)
    }
}

impl<S: Scalar, const N: usize> Kinematics<S, N> for Direct {
    #[inline]
    fn forward(&self, joints: [Motion<S>; N]) -> Pose<S, N> {
        Pose::direct(joints)
    }
}

/// Declares a list of mechanisms with as many axes, which is a mechanism itself.
macro_rules! mechanisms {
    ($(#[$doc:meta])* $Any:ident of $N:literal, $words:literal { $( $Variant:ident($model:ty), )+ }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        #[allow(missing_docs)]
        pub enum $Any<S: Scalar> { $( $Variant($model) ),+ }

        impl<S: Scalar> $Any<S> {
            /// The mechanism that the settings name.
            ///
            /// # Errors
            /// A mechanism of another number of axes, or link lengths with which it cannot be assembled.
            pub fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
                Ok(match settings.kinematics.model {
                    $( KinematicsName::$Variant => Self::$Variant(<$model as Model<S>>::build(settings)?), )+
                    _ => return Err(settings.refuses("kinematics.model", Allowed::Only($words))),
                })
            }

            /// The pose for these joint motions ([`Kinematics::forward`]).
            // Compiled into its caller as it stands, where the copies below still are copies.
            #[inline(always)]
            pub fn forward(&self, joints: [Motion<S>; $N]) -> Pose<S, $N> {
                // Copies for each: what one mechanism is handed or gives in memory would be there for all.
                match self { $( Self::$Variant(model) => {
                    let mut own = [Motion::REST; $N];
                    own.copy_from_slice(&joints);
                    let Pose { axes, jacobian } = model.forward(own);
                    Pose { axes, jacobian }
                } ),+ }
            }
        }

        impl<S: Scalar> Configured for $Any<S> {
            fn configuration(&self, each: &mut dyn FnMut(u64)) -> bool {
                match self { $(
                    Self::$Variant(model) => KinematicsName::$Variant.configuration(each) & model.configuration(each)
                ),+ }
            }
        }

        impl<S: Scalar> Model<S> for $Any<S> {
            type State = ();

            fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
                Self::build(settings)
            }
        }

        impl<S: Scalar> Kinematics<S, $N> for $Any<S> {
            #[inline(always)]
            fn forward(&self, joints: [Motion<S>; $N]) -> Pose<S, $N> {
                self.forward(joints)
            }
        }
    };
}

mechanisms! {
    /// Any one of the mechanisms in the plane.
    AnyKinematics of 2, "\"direct\", \"capstan\" or \"five-bar\" where axis.count is 1 or 2" {
        Direct(Direct),
        Capstan(capstan::Capstan<S>),
        FiveBar(five_bar::FiveBar<S>),
    }
}

mechanisms! {
    /// Any one of the mechanisms in space.
    AnySpatial of 3, "\"direct\" or \"arm\" where axis.count is 3" {
        Direct(Direct),
        Arm(arm::Arm<S>),
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
    /// The most that a joint moves (m or rad) when the hand moves by one metre in a usual pose.
    pub usual_per_m: f64,
}

impl Joints {
    /// The joints of the mechanism that the settings name.
    pub fn of(settings: &Settings) -> Self {
        let kinematics = &settings.kinematics;
        let slide = settings.encoder.counts_per_m;
        let turning = settings.encoder.counts_per_rev / core::f64::consts::TAU;
        let (counts_per_unit, usual_per_m, least_sine) = match kinematics.model {
            KinematicsName::Direct => (slide, 1.0, 1.0),
            KinematicsName::Capstan => (turning, kinematics.capstan_ratio / kinematics.paddle_radius_m, 1.0),
            KinematicsName::FiveBar => (turning, 1.0 / kinematics.proximal_m, five_bar::MIN_ELBOW_SINE),
            KinematicsName::Arm => {
                (turning, 1.0 / kinematics.proximal_m.min(kinematics.distal_m), arm::MIN_ELBOW_COSINE)
            }
        };
        Self { counts_per_unit, most_per_m: usual_per_m / least_sine, usual_per_m }
    }
}
