//! A clutch between the device and the shared world: opened, the device moves freely while the world stands where it
//! was; closed again, both go on from where each of them is. For a leader whose workspace is smaller than the
//! follower's (Hannaford 1989 calls it indexing).
//!
//! **Design**: a transformer between device and world whose ratio r goes from 1 to 0 and back over `safety.clutch_s`,
//!
//! > ẋ = r·ẋ_device,   F_device = r·F,   so   F·ẋ = F_device·ẋ_device whatever r is and does.
//!
//! So opening and closing make no energy. In the world the device comes to rest where it was, and the contact holds the object to
//! that place; no other force, no other position than before. What the hand feels changes in a tick by the change of F, as ever, and by
//! no more than |F|·T_c/clutch_s for the ratio. The world's position of the device is the sum of its shares, which is where the offset
//! that is left comes from: Δx = r·Δx_device, with the r under which the force of that tick acted.
//!
//! **Limits**: of the free axis alone; an axis that is held on its line stays held. The offset stays until the encoders are set to
//! zero ([`crate::safety::Command::Home`]). Speed and workspace are judged of the device, not of the world.

use crate::num::{Motion, Scalar};
use crate::settings::Settings;

/// The clutch's speed: the change of its ratio in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Clutch<S> {
    /// Change of the ratio in a tick.
    step: S,
}

configured!([S: Scalar] Clutch<S> { step });

/// State of a clutch: its ratio, and the offset between device and world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip<S> {
    /// r, from 0, open, to 1.
    ratio: S,
    open: bool,
    /// The world's position of the device less its own, m.
    offset: S,
    /// Where the device was at the last tick, m.
    last: S,
}

impl<S: Scalar> Default for Slip<S> {
    fn default() -> Self {
        Self { ratio: S::ONE, open: false, offset: S::ZERO, last: S::ZERO }
    }
}

impl<S: Scalar> Slip<S> {
    /// Whether the clutch is fully closed and no offset is left, as if there were no clutch.
    pub fn is_none(&self) -> bool {
        !self.open && self.ratio == S::ONE && self.offset == S::ZERO
    }

    /// The share r of the world's force that the device feels, 0 to 1.
    pub fn ratio(&self) -> S {
        self.ratio
    }

    /// Motion of the device in the shared world (m, m/s), at the present ratio and offset.
    pub fn of(&self, device: Motion<S>) -> Motion<S> {
        Motion { position: device.position + self.offset, velocity: self.ratio * device.velocity }
    }

    /// Opens the clutch, or closes it, from the next tick on; `device` is where the device is now, m.
    pub fn turn(&mut self, open: bool, device: S) {
        self.open = open;
        self.last = device;
    }

    /// Closes the clutch at once and keeps the offset: for a peer that renders no force yet.
    pub fn close(&mut self) {
        *self = Self { offset: self.offset, ..Self::default() };
    }
}

impl<S: Scalar> Clutch<S> {
    /// The clutch of these settings: closing it takes `safety.clutch_s`.
    pub fn build(settings: &Settings) -> Self {
        Self { step: S::from_f64(settings.timing.control_period_s / settings.safety.clutch_s) }
    }

    /// Advances the clutch by one tick, and returns the motion of the device in the shared world, m and m/s.
    pub fn carry(&self, slip: &mut Slip<S>, device: Motion<S>) -> Motion<S> {
        slip.offset = slip.offset - (S::ONE - slip.ratio) * (device.position - slip.last);
        slip.last = device.position;
        slip.ratio = if slip.open {
            (slip.ratio - self.step).max(S::ZERO)
        } else if slip.ratio + self.step < S::ONE {
            slip.ratio + self.step
        } else {
            S::ONE
        };
        slip.of(device)
    }
}
