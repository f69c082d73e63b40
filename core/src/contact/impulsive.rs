//! Impulsive contact of one device and the object: each impact is a pulse of one tick, ΔQ/T_c (architectures paper §2.1).
//!
//! The object has no spring: until the device reaches it, it moves freely. At tick n both ends of the step from n − 1 to n
//! are known, of the device as it was sensed; if device and object have changed places on the way, they met where the two
//! straight lines cross (in closed form; both Euler integrators move the object along exactly that line, the exact one
//! strays from it by at most F·T_c²/(8·m_O)). There they exchange momentum by their velocities now, the device with the mass
//! that the scene gives it; the object goes on from the place of the impact, and the device feels −ΔQ/T_c for one control
//! period. No crossing is missed at any speed that the guard lets pass.
//!
//! **Settling**: a motor force may act up to a tick late and the pulse lasts a tick, so velocities say nothing about an
//! impact before [`SETTLING`] ticks; until then the object moves freely. If the device is then past the surface and still
//! approaches (a heavy object, or a pulse that the limits cut), that is the next impact.
//!
//! **Saturation**: [`crate::safety`] stands above the pulse as above any force. What it let through is read back from the
//! command and booked beside what was wanted ([`super::Impacts`]): the object always takes the whole of ΔQ, and the hand
//! feels the rest of it never, or as the next impact. One-sided contacts only; units N, N·s, m.

use super::continuous::Contact;
use super::impact::{Exchange, exchange};
use super::rendering::{Press, Rendering, Strikes, Touch};
use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::{Allowed, Refused, Settings};

/// Ticks after an impact until the device's velocity tells of its pulse: one of delay, one of pulse.
pub const SETTLING: u32 = 2;

/// Impacts between device and object.
#[derive(Clone, Copy, Debug)]
pub struct Impulsive<S> {
    contact: Contact<S>,
    period: S,
    /// 1/T_c.
    rate: S,
    /// 1/m_O.
    object_inverse: S,
    /// 1/m of the device.
    device_inverse: S,
    restitution: S,
}

impl<S: Scalar> Model<S> for Impulsive<S> {
    type State = ();

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        if !settings.contact.one_sided {
            let allowed = Allowed::Only("\"continuous\", unless contact.one_sided is true: an impact has a side");
            return Err(settings.refuses("contact.rendering", allowed));
        }
        let (period, contact, object) = (settings.timing.control_period_s, &settings.contact, &settings.object);
        Ok(Self {
            contact: Contact::build(settings),
            period: S::from_f64(period),
            rate: S::from_f64(1.0 / period),
            object_inverse: S::from_f64(1.0 / object.mass_kg),
            device_inverse: S::from_f64(1.0 / contact.device_mass_kg),
            restitution: S::from_f64(contact.restitution),
        })
    }
}

impl<S: Scalar> Rendering<S> for Impulsive<S> {
    fn clear_of(&self, position: S) -> S {
        self.contact.clear_of(position)
    }

    fn touch(&self, state: &mut Strikes<S>, device: Motion<S>, object: &mut Motion<S>, commanded: S) -> Touch<S> {
        if state.pulse != S::ZERO {
            // The device feels the reaction; of a force the other way nothing was delivered.
            let toward = if state.pulse < S::ZERO { -commanded } else { commanded };
            state.delivered.add(self.period * (-toward).max(S::ZERO));
        }
        state.pulse = S::ZERO;
        let past = self.contact.past(device.position - object.position);
        state.settling = state.settling.saturating_sub(1);
        if past > S::ZERO && state.settling == 0 {
            let against = self.contact.past(object.velocity - device.velocity);
            let masses = [self.object_inverse, self.device_inverse];
            if let Some(Exchange { impulse: [impulse], changes: [[change], _], lost_j }) =
                exchange([against], [S::ONE], masses, self.restitution)
            {
                // How much of the step was left after the crossing; nothing if they overlapped before it.
                let gap = state.before.map_or(S::ZERO, |[device, object]| self.contact.past(object - device));
                let after = if gap > S::ZERO { past.ratio(past + gap) } else { S::ZERO };
                let change = self.contact.past(change);
                object.velocity = object.velocity + change;
                object.position = object.position + after * self.period * change;
                state.pulse = self.contact.past(self.rate * impulse);
                state.settling = SETTLING;
                state.count = state.count.saturating_add(1);
                state.wanted.add(impulse);
                state.lost.add(lost_j);
            }
        }
        state.before = Some([device.position, object.position]);
        Touch { pushing: S::ZERO, felt: state.pulse }
    }

    fn press(&self, state: &mut Strikes<S>, device: Motion<S>, object: &mut Motion<S>, commanded: S) -> Press<S> {
        let Touch { felt: pulse, .. } = self.touch(state, device, object, commanded);
        Press { pulse, ..Press::default() }
    }
}
