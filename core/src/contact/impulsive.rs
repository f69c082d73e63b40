//! Impulsive contact of one device and the object: each impact is a train of force pulses of total impulse ΔQ (architectures paper §2.1).
//!
//! The object has no spring: until the device reaches it, it moves freely. At tick n both ends of the step from n − 1 to n
//! are known, of the device as it was sensed; if device and object have changed places on the way, they met where the two
//! straight lines cross (in closed form; both Euler integrators move the object along exactly that line, the exact one
//! strays from it by at most F·T_c²/(8·m_O)). There they exchange the impulse ΔQ that their present velocities ask for, the
//! device with the mass that the scene gives it. No crossing is missed at any speed below `safety.max_speed_m_per_s`.
//!
//! **What is felt is what acts**: a pulse lasts a tick, and [`crate::safety::Limits`] limit it: F = ΔQ/T_c if the limits of force and slew
//! allow that, and otherwise as much as they allow. The object takes T_c·F in the same tick, not ΔQ, and the impulse still
//! owed is given in the ticks that follow; the last pulse gives what is left, since a force may fall at once. So the momentum of object and
//! device together is conserved in every tick, to rounding; with a motor that acts a tick late, a tick later. An impact dissipates only
//! what restitution below 1 takes; during the pulses kinetic energy is lower by what they have yet to return. ΔQ is decided
//! once, but pulses end early once the two separate as fast as restitution asks for, whoever pulled them apart.
//!
//! **Settling**: a motor force may act up to a tick late and the pulse lasts a tick, so velocities say nothing about an
//! impact before [`SETTLING`] ticks after the last pulse; until then the object moves freely.
//!
//! **Resting**: an approach slower than one encoder count per tick, or one that comes within [`CHATTER`] ticks after
//! settling, is no impact but resting contact: until the two part, contact is the spring and damper of the same table,
//! one-sided, and a port where the object is moved by ports: a steady push F sinks in by F/K_LC. The depth of the device past
//! the surface by then compresses the spring at once. After a plastic impact within the limits that is at most 2.5 ticks of
//! the approach, v·2.5·T_c, and the spring gives back less than was lost while 6·K_LC·T_c² is less than the reduced mass, as
//! it is wherever such a spring is stable at all; where its force is at a limit, it slips ([`super::grip`]).
//! The spring is that of [`super::continuous`], with the same effects of sampling, except that it never pulls.
//!
//! **Mass**: no energy is generated while `contact.device_mass_kg` is at most the mass that the hand moves; a peer cannot know
//! that mass, so a simulator, which does, refuses larger values. Limits: one-sided contacts only; the motor's own duty limit is
//! not known here (`motor.max_duty` below `safety.max_force_n` would take from the device alone). Units N, N·s, m, J.

use super::continuous::Contact;
use super::impact::{Exchange, exchange};
use super::rendering::{Giving, Press, Rendering, Strikes, Touch};
use crate::device::kinematics::Joints;
use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::{Allowed, Refused, Settings};

/// Ticks after a pulse until the device's velocity shows it: one of delay, one of pulse.
pub const SETTLING: u32 = 2;

/// Ticks after [`SETTLING`] within which another impact is chatter: in a hop that short, settling takes longer than the flight.
pub const CHATTER: u32 = 2 * SETTLING;

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
    /// 1/(1/m_O + 1/m), kg.
    reduced: S,
    restitution: S,
    /// Slowest approach that is an impact, m/s.
    slowest: S,
}

configured!([S: Scalar] Impulsive<S> {
    contact, period, rate, object_inverse, device_inverse, reduced, restitution, slowest
});

impl<S: Scalar> Model<S> for Impulsive<S> {
    type State = ();

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        if !settings.contact.one_sided {
            let allowed = Allowed::Only("\"continuous\", unless contact.one_sided is true: an impact has a side");
            return Err(settings.refuses("contact.rendering", allowed));
        }
        let (period, contact, object) = (settings.timing.control_period_s, &settings.contact, &settings.object);
        let Joints { counts_per_unit, most_per_m, .. } = Joints::of(settings);
        let [object_inverse, device_inverse] = [1.0 / object.mass_kg, 1.0 / contact.device_mass_kg];
        Ok(Self {
            contact: Contact::build(settings),
            period: S::from_f64(period),
            rate: S::from_f64(1.0 / period),
            object_inverse: S::from_f64(object_inverse),
            device_inverse: S::from_f64(device_inverse),
            reduced: S::from_f64(1.0 / (object_inverse + device_inverse)),
            restitution: S::from_f64(contact.restitution),
            slowest: S::from_f64(1.0 / (counts_per_unit * most_per_m * period)),
        })
    }
}

/// What contact does in this tick.
enum Act<S> {
    /// A pulse of this force (N), which the object has taken.
    Pulse(S),
    /// The object is pushed by the contact's spring and damper in this tick.
    Spring,
}

impl<S: Scalar> Impulsive<S> {
    /// The spring and damper of resting contact.
    pub(super) fn spring(&self) -> &Contact<S> {
        &self.contact
    }

    #[inline]
    fn act(
        &self,
        state: &mut Strikes<S>,
        device: Motion<S>,
        object: &mut Motion<S>,
        (limits, commanded): Giving<'_, S>,
    ) -> Act<S> {
        let past = self.contact.past(device.position - object.position);
        let approach = self.contact.past(device.velocity - object.velocity);
        let before = state.before.replace([device.position, object.position]);
        state.recent = state.recent.saturating_sub(1);
        state.resting &= past > S::ZERO;
        let mut after = S::ZERO;
        if state.owed > S::ZERO {
            state.owed = state.owed.min(self.reduced * (approach + state.rebound));
        } else if past > S::ZERO && approach > S::ZERO && state.recent <= CHATTER && !state.resting {
            if state.recent > 0 || approach < self.slowest {
                state.resting = true;
            } else if let Some(Exchange { impulse: [impulse], lost_j, .. }) =
                exchange([-approach], [S::ONE], [self.object_inverse, self.device_inverse], self.restitution)
            {
                // How much of the step was left after the crossing; nothing if they overlapped before it.
                let gap = before.map_or(-past, |[device, object]| self.contact.past(object - device));
                after = if gap >= S::ZERO { past.ratio(past + gap) } else { S::ZERO };
                (state.owed, state.rebound) = (impulse, self.restitution * approach);
                state.count = state.count.saturating_add(1);
                state.wanted.add(impulse);
                state.lost.add(lost_j);
            }
        }
        if state.resting {
            state.recent = SETTLING + CHATTER;
            return Act::Spring;
        }
        state.owed = state.owed.max(S::ZERO);
        let asked = self.contact.past(self.rate * state.owed);
        // What is no number goes to the object as none: the peer stops.
        let given = limits.reaction(commanded, asked) + S::ZERO * asked;
        if given != S::ZERO {
            state.recent = SETTLING + CHATTER;
            let impulse = self.period * given;
            let change = self.object_inverse * impulse;
            object.velocity = object.velocity + change;
            object.position = object.position + after * self.period * change;
            if state.owed > S::ZERO {
                let impulse = self.contact.past(impulse);
                state.owed = state.owed - impulse;
                state.delivered.add(impulse);
            }
        }
        Act::Pulse(given)
    }

    /// A force toward the object, or none.
    #[inline]
    fn push(&self, force: S) -> S {
        self.contact.past(self.contact.past(force).max(S::ZERO))
    }
}

impl<S: Scalar> Rendering<S> for Impulsive<S> {
    fn clear_of(&self, position: S) -> S {
        self.contact.clear_of(position)
    }

    fn touch(
        &self,
        state: &mut Strikes<S>,
        device: Motion<S>,
        mut object: Motion<S>,
        giving: Giving<'_, S>,
    ) -> (Motion<S>, Touch<S>) {
        let touch = match self.act(state, device, &mut object, giving) {
            Act::Pulse(given) => Touch { pushing: S::ZERO, felt: given },
            Act::Spring => {
                let force = self.push(self.contact.force(device, object));
                Touch { pushing: force, felt: force }
            }
        };
        (object, touch)
    }

    fn press(
        &self,
        state: &mut Strikes<S>,
        device: Motion<S>,
        mut object: Motion<S>,
        giving: Giving<'_, S>,
    ) -> (Motion<S>, Press<S>) {
        let press = match self.act(state, device, &mut object, giving) {
            Act::Pulse(given) => Press { pulse: given, ..Press::default() },
            Act::Spring => self.contact.port(device, object),
        };
        (object, press)
    }
}
