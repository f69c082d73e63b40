//! One shared axis: the local copy of the object along it, what pushes that copy, and the law that holds it to the other peer's.
//!
//! Axes know nothing of each other: a law, an integrator and a way of contact are scalar, and each axis has a state of its own of each.
//! Where a fixture couples them, one solve sees the ports of all ([`advance_together`]).

use crate::contact::{AnyRendering, Press, Strikes};
use crate::law::ledger::Ledger;
use crate::law::{Coupled, Law, Observation, Packet};
use crate::num::{Motion, Scalar, StateVector};
use crate::object::fixture::{self, Fixture, Pushes};
use crate::object::plane::Oblique;
use crate::object::vector::VectorPort;
use crate::object::{AnyIntegrator, Port, Staged};

/// Motions and forces of one tick along one shared axis, for telemetry, reports and tests.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observed<S> {
    /// Motion of the device x_h, m and m/s.
    pub device: Motion<S>,
    /// The local copy x_o as the forces of this tick saw it, m and m/s.
    pub object: Motion<S>,
    /// The decoded remote copy x_d as F_T of this tick used it, m and m/s.
    pub desired: Motion<S>,
    /// Contact force F_LC on the object, N.
    pub contact_force: S,
    /// Coordination force F_T on the object, N.
    pub coordination_force: S,
}

impl<S> Observed<S> {
    /// The same with `of` applied to each number.
    #[inline]
    pub fn map<T>(self, of: impl Fn(S) -> T) -> Observed<T> {
        let motion = |seen: Motion<S>| Motion { position: of(seen.position), velocity: of(seen.velocity) };
        Observed {
            device: motion(self.device),
            object: motion(self.object),
            desired: motion(self.desired),
            contact_force: of(self.contact_force),
            coordination_force: of(self.coordination_force),
        }
    }
}

/// The local copy along one axis.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct SharedAxis<S: Scalar, L: Law<S>> {
    pub(super) coordination: L::State,
    pub(super) object: Motion<S>,
    pub(super) observed: Observed<S>,
    pub(super) ledger: Ledger<S>,
    /// The packet that stands.
    pub(super) standing: Packet<S>,
    integrator: AnyIntegrator<S>,
    pub(super) strikes: Strikes<S>,
}

configured!([S: Scalar, L: Law<S>] SharedAxis<S, L> {
    object, integrator; coordination, observed, ledger, standing, strikes
});

/// What is the same for all axes in a tick.
pub(super) struct Tick<'a, S: Scalar, L> {
    pub(super) law: &'a L,
    pub(super) contact: &'a AnyRendering<S>,
    pub(super) fixture: Option<Fixture<S>>,
    /// The coordination acts in this tick.
    pub(super) engaged: bool,
    pub(super) age_ticks: u32,
    /// Control period T_c, s.
    pub(super) period_s: S,
}

impl<S: Scalar, L: Law<S>> SharedAxis<S, L> {
    /// At rest, clear of a device at `position` (m).
    pub(super) fn new(law: &L, contact: &AnyRendering<S>, integrator: AnyIntegrator<S>, position: S) -> Self {
        let object = Motion::at(contact.clear_of(position));
        Self {
            coordination: law.start(object),
            object,
            observed: Observed::default(),
            ledger: Ledger::default(),
            standing: Packet::default(),
            integrator,
            strikes: Strikes::default(),
        }
    }

    /// Puts an axis that has been in use back to how [`SharedAxis::new`] makes it.
    pub(super) fn engage(&mut self, law: &L, contact: &AnyRendering<S>, position: S) {
        self.object = Motion::at(contact.clear_of(position));
        self.strikes = Strikes::default();
        self.integrator.rest();
        self.coordination = law.start(self.object);
        self.ledger = Ledger::default();
        self.standing = Packet::default();
    }

    /// Nothing is rendered, with the device here.
    pub(super) fn rest(&mut self, device: Motion<S>) {
        let object = Motion::at(self.object.position);
        self.observed = Observed { device, object, desired: object, ..Observed::default() };
    }

    /// What would be sent now.
    pub(super) fn outgoing(&self, law: &L, engaged: bool) -> Packet<S> {
        let packet =
            Packet { energy_j: self.ledger.sent_j().to_counter(), ..law.send(&self.coordination, self.object) };
        if !packet.is_finite() {
            return Packet { motion: Motion::at(self.object.position), ..Packet::default() };
        }
        if engaged { packet } else { law.idle(packet, self.object) }
    }

    /// Gives the law the packet that stands, of which this share still counts.
    pub(super) fn fade(&mut self, law: &L, share: S) {
        let packet = if share == S::ONE { self.standing } else { law.fade(share, self.standing, self.object) };
        law.receive(&mut self.coordination, packet);
    }

    /// Contact, coordination and the copy's motion through one tick: in stages, as the papers have it, or in one solve. The force on
    /// the copy whose reaction the device feels, N; none if it left the range of numbers. `PLAIN`: there is no fixture.
    #[inline(always)]
    pub(super) fn advance<const PLAIN: bool>(
        &mut self,
        tick: &Tick<'_, S, L>,
        device: Motion<S>,
        commanded: S,
    ) -> Option<S> {
        let Tick { law, contact, fixture, engaged, age_ticks, period_s } = *tick;
        let (object, next, felt, coupled) = if let AnyIntegrator::Midpoint(midpoint, carries)
        | AnyIntegrator::BackwardEuler(midpoint, carries) = &mut self.integrator
        {
            let (object, press) = contact.press(&mut self.strikes, device, self.object, commanded);
            let seen = Observation { local: object, contact_force: self.observed.contact_force, age_ticks };
            let (mut half_change, mut contact_force) = (S::ZERO, S::ZERO);
            let mut solve = |coordination: Port<S>| {
                if let Some(fixture) = fixture.filter(|_| !PLAIN) {
                    let contact = Pushes { port: press.port, toward: press.toward };
                    contact_force = fixture::solve_both(contact, fixture.pushes(object), |ports| {
                        half_change = midpoint.half_change(object.velocity, ports + coordination);
                        object.velocity + half_change
                    });
                    return object.velocity + half_change;
                }
                half_change = midpoint.half_change(object.velocity, press.port + coordination);
                contact_force = press.port.at(object.velocity + half_change);
                if contact_force * press.toward < S::ZERO {
                    // What can only push does not pull.
                    contact_force = S::ZERO;
                    half_change = midpoint.half_change(object.velocity, coordination);
                }
                object.velocity + half_change
            };
            let coupled = if engaged {
                law.couple(&mut self.coordination, &seen, solve)
            } else {
                solve(Port::default());
                Coupled::none(object)
            };
            (object, midpoint.advance(carries, object, half_change), contact_force + press.pulse, coupled)
        } else {
            let (object, touch) = contact.touch(&mut self.strikes, device, self.object, commanded);
            let seen = Observation { local: object, contact_force: touch.felt, age_ticks };
            let coupled = if engaged && !L::PORTS_ONLY {
                law.couple(&mut self.coordination, &seen, Staged(object.velocity))
            } else {
                Coupled::none(object)
            };
            (object, self.integrator.step(object, touch.pushing + coupled.force), touch.felt, coupled)
        };
        self.end([device, object, next], felt, &coupled, period_s)
    }

    /// Ends a tick in which the device and the copy were there, and after which the copy is next.
    #[inline(always)]
    fn end(&mut self, [device, object, next]: [Motion<S>; 3], felt: S, coupled: &Coupled<S>, period_s: S) -> Option<S> {
        self.ledger.book(coupled, period_s);
        self.observed = Observed {
            device,
            object,
            desired: coupled.desired,
            contact_force: felt,
            coordination_force: coupled.force,
        };
        if !(next.is_finite() && coupled.is_finite()) {
            return None;
        }
        self.object = next;
        Some(felt)
    }
}

/// What the laws of all axes give to one solve, and what comes of it.
struct Together<S, const N: usize> {
    ports: [Port<S>; N],
    /// Mean velocities, m/s.
    means: [S; N],
}

/// [`SharedAxis::advance`] of all axes in one solve, where a fixture couples them.
pub(super) fn advance_together<S: Scalar, L: Law<S>, const N: usize>(
    axes: &mut [SharedAxis<S, L>; N],
    tick: &Tick<'_, S, L>,
    oblique: &Oblique<S, N>,
    devices: [Motion<S>; N],
    commanded: [S; N],
) -> Option<[S; N]> {
    let (mut objects, mut presses) = ([Motion::REST; N], [Press::default(); N]);
    let sensed = devices.into_iter().zip(commanded);
    for (axis, ((device, commanded), (object, press))) in
        axes.iter_mut().zip(sensed.zip(objects.iter_mut().zip(&mut presses)))
    {
        (*object, *press) = tick.contact.press(&mut axis.strikes, device, axis.object, commanded);
    }
    let solve = |laws: [Port<S>; N]| {
        let mut ports = laws;
        for (port, press) in ports.iter_mut().zip(&presses) {
            *port = *port + press.port;
        }
        oblique.mean_velocity(objects, &VectorPort::of_axes(ports))
    };
    let mut together = Together { ports: [Port::default(); N], means: [S::ZERO; N] };
    let mut coupled = objects.map(|object| Coupled { desired: object, ..Coupled::default() });
    if tick.engaged {
        gather(tick, (&mut axes[..], &objects[..], &mut coupled[..]), 0, &mut together, &solve);
    } else {
        together.means = solve(together.ports);
    }
    let (mut felt, mut finite) = ([S::ZERO; N], true);
    let seen = devices.into_iter().zip(objects).zip(presses.into_iter().zip(coupled));
    for (axis, ((felt, mean), ((device, object), (press, coupled)))) in
        axes.iter_mut().zip(felt.iter_mut().zip(together.means).zip(seen))
    {
        let next = match &mut axis.integrator {
            AnyIntegrator::Midpoint(midpoint, carries) | AnyIntegrator::BackwardEuler(midpoint, carries) => {
                midpoint.advance(carries, object, mean - object.velocity)
            }
            // Refused where there is a fixture.
            _ => object,
        };
        let force = press.port.at(mean) + press.pulse;
        match axis.end([device, object, next], force, &coupled, tick.period_s) {
            Some(force) => *felt = force,
            None => finite = false,
        }
    }
    finite.then_some(felt)
}

/// The axes that remain, the motion of their copies (m, m/s), and the forces of their laws.
type Left<'a, S, L> = (&'a mut [SharedAxis<S, L>], &'a [Motion<S>], &'a mut [Coupled<S>]);

/// Asks the laws of the axes that are left for their ports, one within the other, and solves when all are there: each law is given its own
/// axis' velocity, and goes on.
fn gather<S: Scalar, L: Law<S>, const N: usize>(
    tick: &Tick<'_, S, L>,
    (axes, objects, coupled): Left<'_, S, L>,
    at: usize,
    together: &mut Together<S, N>,
    solve: &dyn Fn([Port<S>; N]) -> [S; N],
) {
    let first = (axes.split_first_mut(), objects.split_first(), coupled.split_first_mut());
    let (Some((axis, axes)), Some((object, objects)), Some((coupled, others))) = first else {
        together.means = solve(together.ports);
        return;
    };
    let seen = Observation { local: *object, contact_force: axis.observed.contact_force, age_ticks: tick.age_ticks };
    *coupled = tick.law.couple(&mut axis.coordination, &seen, |port: Port<S>| {
        if let Some(own) = together.ports.get_mut(at) {
            *own = port;
        }
        gather(tick, (axes, objects, others), at + 1, together, solve);
        together.means.get(at).copied().unwrap_or(S::ZERO)
    });
}

/// Object, integrator and coordination law, in this order.
impl<S: Scalar, L: Law<S>> StateVector<S> for SharedAxis<S, L> {
    #[inline]
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        self.object.visit(each);
        self.integrator.visit(each);
        self.coordination.visit(each);
    }
}
