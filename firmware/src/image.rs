//! What the image is made for: how many motors the board has, along how many axes the object is shared, and by which laws.
//!
//! The usual image is for devices of one or two motors and one shared axis, with the laws of cohold-core. The feature `all-laws` adds those
//! of cohold-laws. The second image (feature `three-axes`) is for three motors and an object that is shared along all of their axes. It names
//! its law and its kind of mechanism, and carries no other, so that what it has three of still fits into ITCM. A third one (feature
//! `moteus`) has the first one's laws, for a motor with a controller of its own, and a fourth (feature `spi-encoders`) differs from the
//! first in what reads its joints. Any of them may talk by USB in place of Ethernet (feature `usb`).
//!
//! The feature `fixed-point` makes an image that computes in fixed point. It is for virtual boards, which measure the cost. Do not put it
//! on a board with motors: nothing proves that its tick cannot panic.

/// The numbers that the peer computes with.
#[cfg(not(feature = "fixed-point"))]
pub type Real = f32;
/// The numbers that the peer computes with.
#[cfg(feature = "fixed-point")]
pub type Real = cohold_core::num::Fixed;

#[cfg(not(feature = "three-axes"))]
mod made_for {
    use cohold_core::device::AXES;

    /// Joints that have a motor and an encoder.
    pub const JOINTS: usize = AXES;
    /// Axes along which the object is shared.
    pub const SHARED: usize = 1;
    /// Any law, chosen by the settings.
    #[cfg(not(any(feature = "all-laws", feature = "fixed-point")))]
    pub type Law = cohold_core::law::AnyLaw<super::Real>;
    /// Any law, chosen by the settings.
    #[cfg(feature = "all-laws")]
    pub type Law = cohold_laws::EveryLaw<super::Real>;
    /// The passive wave.
    #[cfg(feature = "fixed-point")]
    pub type Law = cohold_core::law::wave::PassiveWave<super::Real>;
    /// The peer.
    pub type Peer = cohold_core::peer::Peer<super::Real, Law>;
}

#[cfg(feature = "three-axes")]
mod made_for {
    use cohold_core::{device::kinematics::AnySpatial, law::wave::PassiveWave};

    /// Joints that have a motor and an encoder.
    pub const JOINTS: usize = 3;
    /// Axes along which the object is shared.
    pub const SHARED: usize = 3;
    /// The passive wave on every axis.
    pub type Law = PassiveWave<super::Real>;
    /// The peer.
    pub type Peer = cohold_core::peer::Peer<super::Real, Law, SHARED, JOINTS, AnySpatial<super::Real>>;
}

pub use made_for::{JOINTS, Law, Peer, SHARED};

/// What a tick commands.
pub type Actuators = cohold_core::peer::Actuators<Real, JOINTS>;

/// What a drive may say against being driven.
#[cfg(feature = "spi-encoders")]
pub use crate::as5047p::Trouble;
/// What a drive may say against being driven.
#[cfg(not(feature = "spi-encoders"))]
pub use crate::moteus::Trouble;

/// The image has a current loop.
pub const CURRENT_LOOP: bool = !cfg!(any(feature = "three-axes", feature = "moteus"));
