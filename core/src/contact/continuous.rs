//! Continuous contact: F_LC = K_LC·δ + B_LC·δ̇, the force on the object; the device feels its reaction.
//!
//! δ is how far the device is past where contact begins. Two-sided, as in the papers' analysis, the device is held to
//! the object in both directions; with play it moves freely within ±gap; one-sided, it pushes from its own side only
//! (architectures paper §2.2: F = K·x + B·ẋ if x > 0 else 0, so that damping may pull for as long as x > 0).
//! A scene with neither gap nor side has no contact detection at all.

use super::grip::Grip;
use super::rendering::{Giving, Press, Rendering, Strikes, Touch};
use crate::num::{Configured, Motion, Scalar};
use crate::object::port::{Port, met_midway};
use crate::settings::{Refused, Settings};
use crate::{model::Model, names::Side};

/// How far the device and the object are from contact, by the kind of contact.
#[derive(Clone, Copy, Debug)]
enum Surface<S> {
    /// Two-sided contact: the device is held to the object all the time.
    Held,
    /// Free within ± this distance, m.
    Play(S),
    /// In contact where the device is past the surface; the sign points from device to object.
    OneSided { sign: S },
}

impl<S: Scalar> Configured for Surface<S> {
    fn configuration(&self, each: &mut dyn FnMut(u64)) -> bool {
        let (which, number) = match self {
            Self::Held => (0, S::ZERO),
            Self::Play(gap) => (1, *gap),
            Self::OneSided { sign } => (2, *sign),
        };
        each(which);
        number.configuration(each)
    }
}

/// Spring and damper between device and object.
#[derive(Clone, Copy, Debug)]
pub struct Contact<S> {
    stiffness: S,
    damping: S,
    /// K_LC·T_c/2 + B_LC, N·s/m.
    impedance: S,
    /// T_c/2, or T_c with backward Euler, s.
    meeting_s: S,
    surface: Surface<S>,
    /// How far from a device at rest an object is put, one-sided; 0 otherwise.
    clearance: S,
}

configured!([S: Scalar] Contact<S> { stiffness, damping, impedance, meeting_s, surface, clearance });

impl<S: Scalar> Contact<S> {
    /// The contact that the scene describes.
    pub fn build(settings: &Settings) -> Self {
        let contact = &settings.contact;
        let gap = S::from_f64(contact.gap_m);
        let sign = match contact.side {
            Side::Left => S::ONE,
            Side::Right => -S::ONE,
        };
        Self {
            impedance: S::from_f64(met_midway(contact.stiffness_n_per_m, contact.damping_n_s_per_m, settings)),
            meeting_s: S::from_f64(met_midway(1.0, 0.0, settings)),
            stiffness: S::from_f64(contact.stiffness_n_per_m),
            damping: S::from_f64(contact.damping_n_s_per_m),
            surface: match (contact.one_sided, contact.gap_m > 0.0) {
                (true, _) => Surface::OneSided { sign },
                (false, true) => Surface::Play(gap),
                (false, false) => Surface::Held,
            },
            clearance: if contact.one_sided { sign * gap } else { S::ZERO },
        }
    }

    /// Position (m) at which to put an object so that a device at `position` (m) does not touch it before crossing the gap.
    pub fn clear_of(&self, position: S) -> S {
        position + self.clearance
    }

    /// This contact with another stiffness (N/m) and damping (N·s/m); surface and period stay.
    #[must_use]
    pub fn with_gains(self, stiffness: S, damping: S) -> Self {
        Self { stiffness, damping, impedance: stiffness * self.meeting_s + damping, ..self }
    }

    /// How far a device at this distance (m) from the object is past the surface, where contact has a side; or how fast.
    pub(super) fn past(&self, distance: S) -> S {
        match self.surface {
            Surface::OneSided { sign } => sign * distance,
            Surface::Held | Surface::Play(_) => distance,
        }
    }

    /// K_LC·T_c + B_LC, N·s/m, its z where forces are found in stages: the slip that leaves the spring with the limits' force is taken at the end of
    /// the tick there, and not in its middle.
    pub(crate) fn staged_impedance(&self, period_s: S) -> S {
        self.stiffness * period_s + self.damping
    }

    /// A tick of the way back of a slip, for a device at this distance (m) from the object ([`super::grip`]).
    pub(crate) fn recover(&self, grip: &mut Grip<S>, distance: S, period_s: S) {
        let past = match self.surface {
            Surface::Held => distance,
            Surface::Play(gap) => distance - distance.limit(gap),
            Surface::OneSided { sign } => sign * (sign * distance).max(S::ZERO),
        };
        if !matches!(self.surface, Surface::Held) {
            grip.part(past);
        }
        grip.recover(past, self.stiffness, period_s);
    }

    /// How far the spring is pressed, m, if device and object touch.
    #[inline]
    fn depth(&self, distance: S) -> Option<S> {
        match self.surface {
            Surface::Held => Some(distance),
            Surface::Play(gap) if distance > gap => Some(distance - gap),
            Surface::Play(gap) if distance < -gap => Some(distance + gap),
            Surface::OneSided { sign } if sign * distance > S::ZERO => Some(distance),
            Surface::Play(_) | Surface::OneSided { .. } => None,
        }
    }

    /// F_LC on the object, N.
    #[inline]
    pub fn force(&self, device: Motion<S>, object: Motion<S>) -> S {
        match self.depth(device.position - object.position) {
            Some(depth) => self.stiffness * depth + self.damping * (device.velocity - object.velocity),
            None => S::ZERO,
        }
    }

    /// The contact as a port of the object: through the tick the object moves against the spring, while the device is
    /// held as it was sensed.
    #[inline]
    pub fn port(&self, device: Motion<S>, object: Motion<S>) -> Press<S> {
        let Some(depth) = self.depth(device.position - object.position) else { return Press::default() };
        let force = self.stiffness * depth + self.damping * device.velocity;
        let toward = if matches!(self.surface, Surface::Held) { S::ZERO } else { depth };
        Press { port: Port::new(force, self.impedance), toward, pulse: S::ZERO }
    }
}

impl<S: Scalar> Model<S> for Contact<S> {
    type State = ();
    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self::build(settings))
    }
}

impl<S: Scalar> Rendering<S> for Contact<S> {
    fn clear_of(&self, position: S) -> S {
        self.clear_of(position)
    }
    #[inline]
    fn touch(
        &self,
        _: &mut Strikes<S>,
        device: Motion<S>,
        object: Motion<S>,
        _: Giving<'_, S>,
    ) -> (Motion<S>, Touch<S>) {
        let force = self.force(device, object);
        (object, Touch { pushing: force, felt: force })
    }
    #[inline]
    fn press(
        &self,
        _: &mut Strikes<S>,
        device: Motion<S>,
        object: Motion<S>,
        _: Giving<'_, S>,
    ) -> (Motion<S>, Press<S>) {
        (object, self.port(device, object))
    }
}
