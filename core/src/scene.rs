//! A scene: settings, checked once, turned into the models that the tick needs, and no others.
//!
//! [`Models`] says which models a scene can hold. [`Any`] holds any that the lists name, chosen by the settings at run
//! time. An image that will only ever run one scene names its models itself and carries no others:
//!
//! ```
//! use haptic_core::{contact, device, law, object, scene};
//!
//! #[derive(Clone, Copy, Debug, PartialEq)]
//! struct Paddle;
//! impl scene::Models for Paddle {
//!     type Scalar = f32;
//!     type Velocity = device::velocity::filtered::Filtered<f32>;
//!     type Kinematics = device::kinematics::direct::Direct;
//!     type Contact = contact::Contact<f32>;
//!     type Integrator = object::semi_implicit::SemiImplicit<f32>;
//!     type Law = law::power::Power<f32>;
//! }
//! // Settings that ask for other models than these are refused.
//! assert!(scene::Scene::<Paddle>::build(&Default::default()).is_err());
//! ```

use core::marker::PhantomData;

use crate::contact::{AnyRendering, Rendering};
use crate::device::constraint::Hold;
use crate::device::encoder::Encoder;
use crate::device::kinematics::{AnyKinematics, Kinematics};
use crate::device::motor::Motor;
use crate::device::velocity::{AnyVelocity, VelocityEstimator};
use crate::device::watch::Watch;
use crate::law::ladder::Ladder;
use crate::law::{AnyLaw, Law};
use crate::model::{Listed, Model};
use crate::num::Scalar;
use crate::object::{AnyIntegrator, Integrator};
use crate::safety::Guard;
use crate::settings::{Allowed, Refused, Settings, Value};

/// Which models a scene holds.
pub trait Models: Copy + core::fmt::Debug + PartialEq + 'static {
    /// The number type.
    type Scalar: Scalar;
    /// Where velocity comes from.
    type Velocity: VelocityEstimator<Self::Scalar> + Listed<Self::Scalar>;
    /// Joints to axes.
    type Kinematics: Kinematics<Self::Scalar> + Listed<Self::Scalar>;
    /// How contact is rendered.
    type Contact: Rendering<Self::Scalar> + Listed<Self::Scalar>;
    /// How the object advances.
    type Integrator: Integrator<Self::Scalar> + Listed<Self::Scalar>;
    /// What holds the copies together.
    type Law: Law<Self::Scalar> + Listed<Self::Scalar>;
}

/// Any model of every list, chosen by the settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Any<S>(PhantomData<S>);

impl<S: Scalar> Models for Any<S> {
    type Scalar = S;
    type Velocity = AnyVelocity<S>;
    type Kinematics = AnyKinematics<S>;
    type Contact = AnyRendering<S>;
    type Integrator = AnyIntegrator<S>;
    type Law = AnyLaw<S>;
}

/// Everything a peer knows that does not change while it runs.
#[derive(Clone, Copy, Debug)]
pub struct Scene<M: Models> {
    /// T_c, s.
    pub(crate) period: M::Scalar,
    pub(crate) ticks_per_packet: u32,
    /// Axes, and joints, in use.
    pub(crate) axes: usize,
    pub(crate) encoder: Encoder<M::Scalar>,
    pub(crate) velocity: M::Velocity,
    pub(crate) kinematics: M::Kinematics,
    pub(crate) hold: Hold<M::Scalar>,
    pub(crate) motor: Motor<M::Scalar>,
    pub(crate) contact: M::Contact,
    pub(crate) integrator: M::Integrator,
    pub(crate) law: M::Law,
    pub(crate) ladder: Ladder<M::Scalar>,
    pub(crate) guard: Guard<M::Scalar>,
    pub(crate) watch: Watch<M::Scalar>,
}

impl<M: Models> Scene<M> {
    /// Checks the settings and builds the scene. After this the tick cannot fail.
    ///
    /// # Errors
    /// The first key whose value is out of range, impossible beside the others, or names a model that this scene's
    /// [`Models`] do not hold.
    pub fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        settings.check()?;
        held::<M::Scalar, M::Velocity>(settings, "axis.velocity")?;
        held::<M::Scalar, M::Kinematics>(settings, "kinematics.model")?;
        held::<M::Scalar, M::Contact>(settings, "contact.rendering")?;
        held::<M::Scalar, M::Integrator>(settings, "object.integrator")?;
        held::<M::Scalar, M::Law>(settings, "coordination.comm")?;
        Ok(Self {
            period: M::Scalar::from_f64(settings.timing.control_period_s),
            ticks_per_packet: settings.timing.ticks_per_packet,
            axes: settings.axis.count as usize,
            encoder: Encoder::build(settings),
            velocity: M::Velocity::build(settings),
            kinematics: M::Kinematics::build(settings),
            hold: Hold::build(settings),
            motor: Motor::build(settings),
            contact: M::Contact::build(settings),
            integrator: M::Integrator::build(settings),
            law: M::Law::build(settings),
            ladder: Ladder::build(settings),
            guard: Guard::build(settings),
            watch: Watch::build(settings),
        })
    }

    /// Ticks per packet, M.
    pub fn ticks_per_packet(&self) -> u32 {
        self.ticks_per_packet
    }

    /// Axes, and joints, in use.
    pub fn axes(&self) -> usize {
        self.axes
    }

    /// The encoder, for whoever plays the device.
    pub fn encoder(&self) -> &Encoder<M::Scalar> {
        &self.encoder
    }

    /// The motor, for whoever plays the device.
    pub fn motor(&self) -> &Motor<M::Scalar> {
        &self.motor
    }
}

/// Whether the model that `key` names is one that `T` holds.
fn held<S, T: Listed<S>>(settings: &Settings, key: &'static str) -> Result<(), Refused<'static>> {
    match settings.get(key) {
        Some(Value::Text(name)) if !T::NAMES.contains(&name) => {
            Err(Refused { key, value: Value::Text(name), allowed: Allowed::Names(T::NAMES), unit: "" })
        }
        _ => Ok(()),
    }
}
