//! One shared axis: the local copy of the object along it, what pushes that copy, and the law that holds it to the other peer's.
//!
//! Axes know nothing of each other: a law, an integrator and a way of contact are scalar, and each axis has a state of its own of each.
//! Where a fixture couples them, one solve sees the ports of all ([`advance_together`]).
//!
//! A contact whose force the device's limits do not let through is solved with the force that they do let through, and slips
//! ([`crate::contact::grip`]): what the device feels is what the copy gets.

use crate::contact::{AnyRendering, Contact, Grip, Press, Strikes, Touch};
use crate::law::degradation::Remnant;
use crate::law::ledger::Ledger;
use crate::law::{Coupled, Law, Observation, Packet, Spring};
use crate::num::{Motion, Scalar};
use crate::object::fixture::{self, Fixture, Pushes};
use crate::object::midpoint::Midpoint;
use crate::object::plane::Oblique;
use crate::object::vector::VectorPort;
use crate::object::{AnyIntegrator, Port, Staged};
use crate::safety::{Guard, Limits};

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
        let motion = |seen: Motion<S>| Motion::new(of(seen.position), of(seen.velocity));
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
    pub(super) grip: Grip<S>,
    pub(super) remnant: Remnant<S>,
}

configured!([S: Scalar, L: Law<S>] SharedAxis<S, L> {
    object, integrator; coordination, observed, ledger, standing, strikes, grip, remnant
});

/// What is the same for all axes in a tick.
pub(super) struct Tick<'a, S: Scalar, L> {
    pub(super) law: &'a L,
    pub(super) contact: &'a AnyRendering<S>,
    /// Of what is left of a force ([`Remnant`]).
    pub(super) spring: &'a Spring<S>,
    pub(super) guard: &'a Guard<S>,
    pub(super) fixture: Option<Fixture<S>>,
    /// The law's force acts on the device, which is the copy ([`Law::acts_on_device`]).
    pub(super) at_device: bool,
    /// The coordination acts in this tick.
    pub(super) engaged: bool,
    pub(super) age_ticks: u32,
    /// Control period T_c, s.
    pub(super) period_s: S,
}

/// What a device can feel along an axis in a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Felt<S> {
    /// Force that it was commanded last, N.
    pub(super) commanded: S,
    /// Share of the contact's force that it feels, where that may be less than 1: the clutch's.
    pub(super) share: Option<S>,
}

impl<S: Scalar> Felt<S> {
    /// What the device would feel of a contact force on the copy, N.
    #[inline(always)]
    fn of(self, contact_force: S) -> S {
        self.share.map_or(contact_force, |share| share * contact_force)
    }

    /// The contact force on the copy whose reaction the device can give, N; none if it can give that of this one.
    #[inline(always)]
    fn cut(self, limits: &Limits<S>, asked: S) -> Option<S> {
        let felt = self.of(asked);
        let given = limits.reaction(self.commanded, felt);
        if given == felt {
            return None;
        }
        // What is no number goes to the copy as none: the peer stops.
        Some(self.share.map_or(given, |share| given.ratio(share)) + S::ZERO * asked)
    }
}

/// The copy's half change of velocity (m/s) under a push and other ports, and that push, N: one solve, or two where what can only push
/// would pull.
#[inline(always)]
fn pushed<S: Scalar>(midpoint: &Midpoint<S>, velocity: S, push: Pushes<S>, others: Port<S>) -> (S, S) {
    let half_change = midpoint.half_change(velocity, push.port + others);
    let force = push.port.at(velocity + half_change);
    if force * push.toward < S::ZERO {
        return (midpoint.half_change(velocity, others), S::ZERO);
    }
    (half_change, force)
}

/// What one solve of a tick is given beside the coordination's port.
struct Solving<'a, S: Scalar> {
    midpoint: &'a Midpoint<S>,
    /// The copy's as the tick begins, m/s.
    velocity: S,
    press: Press<S>,
    fixture: Option<Pushes<S>>,
    felt: Felt<S>,
    limits: &'a Limits<S>,
    period_s: S,
}

impl<S: Scalar> Solving<'_, S> {
    /// The copy's half change of velocity (m/s) and the contact's force (N) where the limits cut this one; none where they do not.
    ///
    /// Of all forces that the spring could have, the one that is given is the nearest: the more it pushes, the more the copy yields.
    #[cold]
    #[inline(never)]
    fn give_way(self, grip: &mut Grip<S>, coordination: Port<S>, asked: S) -> Option<(S, S)> {
        let given = self.felt.cut(self.limits, asked)?;
        let fixture = self.fixture.unwrap_or_default();
        let others = coordination + Port::of_force(given);
        let (half_change, _) = pushed(self.midpoint, self.velocity, fixture, others);
        let Port { impedance, .. } = self.press.port;
        let missing = self.press.port.at(self.velocity + half_change) - given;
        grip.slide(missing, given, impedance, self.period_s);
        Some((half_change, given))
    }
}

/// [`Solving::give_way`] where forces are found in stages.
#[cold]
#[inline(never)]
fn give_way_in_stages<S: Scalar>(
    grip: &mut Grip<S>,
    spring: &Contact<S>,
    felt: (Felt<S>, &Limits<S>),
    touch: Touch<S>,
    period_s: S,
) -> Touch<S> {
    let (felt, limits) = felt;
    let Some(given) = felt.cut(limits, touch.felt) else { return touch };
    grip.slide(touch.felt - given, given, spring.staged_impedance(period_s), period_s);
    Touch { pushing: given, felt: given }
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
            grip: Grip::default(),
            remnant: Remnant::default(),
        }
    }

    /// Puts an axis that has been in use back to how [`SharedAxis::new`] makes it.
    pub(super) fn engage(&mut self, law: &L, contact: &AnyRendering<S>, position: S) {
        self.object = Motion::at(contact.clear_of(position));
        self.strikes = Strikes::default();
        self.grip = Grip::default();
        self.remnant = Remnant::default();
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
    #[inline]
    pub(super) fn outgoing(&self, law: &L, engaged: bool) -> Packet<S> {
        // Asked first: what a cold call takes and gives in memory would be there in every packet.
        if engaged { self.said(law) } else { self.idle(law) }
    }

    /// What a peer says that is engaged.
    #[inline(always)]
    fn said(&self, law: &L) -> Packet<S> {
        let mut packet = law.send(&self.coordination, self.object);
        // A law that needs it more finely than the ledger's number type has counted it itself.
        if packet.energy_j == S::Counter::ZERO {
            packet.energy_j = self.ledger.sent_j().to_counter();
        }
        if packet.is_finite() {
            packet
        } else {
            Packet { motion: Motion::at(self.object.position), ..Packet::default() }
        }
    }

    /// The packet of a peer that is not engaged.
    #[cold]
    #[inline(never)]
    fn idle(&self, law: &L) -> Packet<S> {
        law.idle(self.said(law), self.object)
    }

    /// Gives the law the packet that stands, of which this share still counts.
    pub(super) fn fade(&mut self, law: &L, share: S) {
        let stands = share == S::ONE || !law.fades();
        let packet = if stands { self.standing } else { self.standing.faded(share, self.object) };
        law.receive(&mut self.coordination, packet);
    }

    /// The device as the contact's spring sees it, less what that has slipped, of which a part goes back.
    fn gripped(&mut self, tick: &Tick<'_, S, L>, device: Motion<S>) -> Motion<S> {
        if self.grip.is_firm() {
            return device;
        }
        tick.contact.spring().recover(&mut self.grip, device.position - self.object.position, tick.period_s);
        Motion { position: device.position - self.grip.slip_m(), ..device }
    }

    /// Contact, coordination and the copy's motion through one tick: in stages, as the papers have it, or in one solve. The force on
    /// the copy whose reaction the device feels, N; none if it left the range of numbers. `PLAIN`: there is no fixture, no clutch, and
    /// nothing has slipped before.
    #[inline(always)]
    pub(super) fn advance<const PLAIN: bool>(
        &mut self,
        tick: &Tick<'_, S, L>,
        device: Motion<S>,
        felt: Felt<S>,
    ) -> Option<S> {
        let Tick {
            law,
            contact,
            spring,
            guard: Guard { limits, .. },
            fixture,
            at_device,
            engaged,
            age_ticks,
            period_s,
        } = *tick;
        let gripped = if PLAIN { device } else { self.gripped(tick, device) };
        let left = if PLAIN { None } else { Some(self.remnant.port(self.object, spring)) };
        let (object, next, force, coupled) = if let AnyIntegrator::Midpoint(midpoint, carries)
        | AnyIntegrator::BackwardEuler(midpoint, carries) = &mut self.integrator
        {
            let (object, press) = contact.press(&mut self.strikes, gripped, self.object, (limits, felt.commanded));
            let seen = Observation { local: object, contact_force: self.observed.contact_force, age_ticks };
            let midpoint = &*midpoint;
            let mut solved = (S::ZERO, S::ZERO);
            let (grip, met) = (&mut self.grip, &mut solved);
            // Takes what it needs by value: what a law's own function is given by reference would be in memory for all laws.
            let mut solve = move |coordination: Port<S>| {
                let (mut half_change, mut contact_force);
                let contact = Pushes { port: press.port, toward: press.toward };
                let fixture = if PLAIN { None } else { fixture.map(|fixture| fixture.pushes(object)) };
                if let Some(fixture) = fixture {
                    half_change = S::ZERO;
                    contact_force = fixture::solve_both(contact, fixture, |ports| {
                        half_change = midpoint.half_change(object.velocity, ports + coordination);
                        object.velocity + half_change
                    });
                } else {
                    (half_change, contact_force) = pushed(midpoint, object.velocity, contact, coordination);
                }
                if !limits.is_free(felt.of(contact_force)) {
                    let velocity = object.velocity;
                    let solving = Solving { midpoint, velocity, press, fixture, felt, limits, period_s };
                    if let Some(cut) = solving.give_way(grip, coordination, contact_force) {
                        (half_change, contact_force) = cut;
                    }
                }
                *met = (half_change, contact_force);
                object.velocity + half_change
            };
            let coupled = if engaged {
                law.couple(&mut self.coordination, &seen, solve)
            } else {
                let velocity = solve(left.unwrap_or_default());
                Coupled { force: left.map_or(S::ZERO, |left| left.at(velocity)), ..Coupled::none(object) }
            };
            let (half_change, contact_force) = solved;
            (object, midpoint.advance(carries, object, half_change), contact_force + press.pulse, coupled)
        } else {
            let (object, mut touch) = if at_device {
                (gripped, Touch { pushing: S::ZERO, felt: -felt.commanded })
            } else {
                contact.touch(&mut self.strikes, gripped, self.object, (limits, felt.commanded))
            };
            if !at_device && !limits.is_free(felt.of(touch.felt)) {
                touch = give_way_in_stages(&mut self.grip, contact.spring(), (felt, limits), touch, period_s);
            }
            let seen = Observation { local: object, contact_force: touch.felt, age_ticks };
            let coupled = if engaged && !L::PORTS_ONLY {
                law.couple(&mut self.coordination, &seen, Staged(object.velocity))
            } else {
                Coupled { force: left.map_or(S::ZERO, |left| left.at(object.velocity)), ..Coupled::none(object) }
            };
            if at_device {
                (object, object, -coupled.force, coupled)
            } else {
                (object, self.integrator.step(object, touch.pushing + coupled.force), touch.felt, coupled)
            }
        };
        if !PLAIN {
            self.remnant.fall();
        }
        self.end(tick, [device, object, next], force, &coupled)
    }

    /// Ends a tick in which the device and the copy were there, and after which the copy is next.
    #[inline(always)]
    fn end(
        &mut self,
        tick: &Tick<'_, S, L>,
        [device, object, next]: [Motion<S>; 3],
        felt: S,
        coupled: &Coupled<S>,
    ) -> Option<S> {
        self.ledger.book(coupled, tick.period_s);
        self.observed = Observed {
            device,
            object,
            desired: coupled.desired,
            contact_force: felt,
            coordination_force: coupled.force,
        };
        // No number is not slow. And one test for four: nothing times a number is nothing, times anything else no number.
        let slow = next.velocity.abs() <= tick.guard.fastest_copy;
        if !(slow && S::ZERO * next.position + S::ZERO * coupled.sum() == S::ZERO) {
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

/// Solves until every axis pushes as its limits have it, at the most: all that three axes can need.
const TRIES: usize = 27;

impl<S: Scalar> Press<S> {
    /// The force (N) that the contact has on a copy of this mean velocity (m/s), and what the limits give of it.
    fn limited(&self, felt: &Felt<S>, limits: &Limits<S>, mean: S) -> (S, S) {
        let asked = self.port.at(mean);
        (asked, felt.cut(limits, asked).unwrap_or(asked))
    }
}

/// [`SharedAxis::advance`] of all axes in one solve, where a fixture couples them.
pub(super) fn advance_together<S: Scalar, L: Law<S>, const N: usize>(
    axes: &mut [SharedAxis<S, L>; N],
    tick: &Tick<'_, S, L>,
    oblique: &Oblique<S, N>,
    devices: [Motion<S>; N],
    felt: [Felt<S>; N],
) -> Option<[S; N]> {
    let (mut objects, mut presses) = ([Motion::REST; N], [Press::default(); N]);
    let sensed = devices.into_iter().zip(&felt);
    for (axis, ((device, felt), (object, press))) in
        axes.iter_mut().zip(sensed.zip(objects.iter_mut().zip(&mut presses)))
    {
        let gripped = axis.gripped(tick, device);
        (*object, *press) =
            tick.contact.press(&mut axis.strikes, gripped, axis.object, (&tick.guard.limits, felt.commanded));
    }
    let solve = |laws: [Port<S>; N]| {
        let mut pushing = presses.map(|press| press.port);
        let mut means = [S::ZERO; N];
        for _ in 0..TRIES {
            let mut ports = laws;
            for (port, pushing) in ports.iter_mut().zip(&pushing) {
                *port = *port + *pushing;
            }
            means = oblique.mean_velocity(objects, &VectorPort::of_axes(ports));
            // The first that does not push as it can is set right, and all are solved for again: with least indices first that ends (Murty
            // 1974), for each force falls with its velocity.
            let asked = presses.iter().zip(&felt).zip(means);
            let wrong = pushing.iter_mut().zip(asked).find_map(|(pushing, ((press, felt), mean))| {
                let (force, given) = press.limited(felt, &tick.guard.limits, mean);
                let right = if given == force { press.port } else { Port::of_force(given) };
                (*pushing != right).then_some((pushing, right))
            });
            let Some((pushing, right)) = wrong else { break };
            *pushing = right;
        }
        means
    };
    let mut together = Together { ports: [Port::default(); N], means: [S::ZERO; N] };
    let mut coupled = objects.map(|object| Coupled { desired: object, ..Coupled::default() });
    if tick.engaged {
        gather(tick, (&mut axes[..], &objects[..], &mut coupled[..]), 0, &mut together, &solve);
    } else {
        for ((port, axis), object) in together.ports.iter_mut().zip(&*axes).zip(objects) {
            *port = axis.remnant.port(object, tick.spring);
        }
        together.means = solve(together.ports);
        for ((coupled, port), mean) in coupled.iter_mut().zip(together.ports).zip(together.means) {
            coupled.force = port.at(mean);
        }
    }
    let (mut forces, mut finite) = ([S::ZERO; N], true);
    let seen = devices.into_iter().zip(objects).zip(presses.into_iter().zip(coupled));
    for ((axis, felt), ((put, mean), ((device, object), (press, coupled)))) in
        axes.iter_mut().zip(&felt).zip(forces.iter_mut().zip(together.means).zip(seen))
    {
        let next = match &mut axis.integrator {
            AnyIntegrator::Midpoint(midpoint, carries) | AnyIntegrator::BackwardEuler(midpoint, carries) => {
                midpoint.advance(carries, object, mean - object.velocity)
            }
            // Refused where there is a fixture.
            _ => object,
        };
        let (asked, given) = press.limited(felt, &tick.guard.limits, mean);
        if given != asked {
            axis.grip.slide(asked - given, given, press.port.impedance, tick.period_s);
        }
        axis.remnant.fall();
        match axis.end(tick, [device, object, next], given + press.pulse, &coupled) {
            Some(force) => *put = force,
            None => finite = false,
        }
    }
    finite.then_some(forces)
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

// Object, integrator and coordination law, in this order.
visited!([S: Scalar, L: Law<S>] SharedAxis<S, L> { object, integrator, coordination });
