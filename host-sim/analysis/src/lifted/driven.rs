//! What one peer with its device answers to one packet period in which it hears one packet, at its start or later, found by driving the code that flies.
//!
//! [`Response::measure`] puts the peer into a unit state, lets [`DynPeer::hear`],
//! [`DynPeer::exchange`] and M times [`DynPeer::tick`] run in `f64` against the exact plant, and reads the state back: one column of a matrix. No
//! equation of the peer is repeated here; a coordination law, integrator or estimator that is new to core's lists is
//! analysed without a change, as long as it is linear and its `StateVector` visits all of its state.
//!
//! **Small signals.** Unit states are 2⁻³⁰⁰ units: a power of two, so every product with them is exact as before, and far
//! below any limit, so that no guard acts. A period that grows beyond 2²⁵⁰ counts as infinite.
//!
//! **Counters.** A line with a time of its own counts what it has sent and heard, and may change its own parameters: its length, its
//! impedance. Such a peer is first left at rest on the scene's network. There is an answer for each state in which it stays for half a second
//! with every tick live. Each starts with the counters of that state, and with the packet that is due. If the line goes on holding still now
//! and then, there is no answer: [`super::kicked`] judges it.
//!
//! **Order of the local state**: x_h, ẋ_h, motor force of the tick before, and those that the device holds back, of each shared axis; then what `State::visit` visits (of each
//! axis object, integrator, law; velocity estimators). Units: m, m/s, N, √W.

use std::array::from_fn;
use std::collections::VecDeque;

use cohold_core::law::Packet;
use cohold_core::law::event::LONGEST;
use cohold_core::names::FixtureName;
use cohold_core::num::{Motion, StateVector as _};
use cohold_core::peer::Sensors;
use cohold_core::safety::{Command, Mode};
use cohold_core::settings::Refused;
use cohold_sim::of_axes;
use cohold_sim::peers::{Builds, DynPeer};
use cohold_sim::plant::Plant;
use cohold_sim::scene::Scene;

use super::delay::delays_ticks;
use crate::matrix::{Matrix, column_mut, reset};

/// 2⁻³⁰⁰: what stands for one unit of a state.
pub(crate) const UNIT: f64 = f64::from_bits((1023 - 300) << 52);

/// 2²⁵⁰: an answer above it may have met a limit on its way.
pub(crate) const TOO_LARGE: f64 = f64::from_bits((1023 + 250) << 52);

/// How exactly a translation by 1 m must come back to be a rest mode: forces of 1e6 N/m have such roundings. A mode that moves by less counts as
/// stable ([`crate::ROUNDING`]).
const UNMOVED: f64 = 1e-9;

/// States of peer `index`'s device along an axis: position, velocity, motor force of the tick before, and those that it holds back. After them, in
/// the local state of a peer that shares one axis, stands the position of the object.
pub(crate) fn device_states(linear: &Scene, index: usize) -> usize {
    3 + linear.devices()[index].delay().0
}

/// The answer of one peer to one packet period.
#[derive(Clone, Debug, Default)]
pub struct Response {
    /// Local state after the period for each local state before, when the packet that arrives is all zeros.
    pub own: Matrix,
    /// Local state after the period for each number of the packet that arrives in it, from rest.
    pub heard: Matrix,
    /// Each number of the packet sent at the start of the period, for each local state before.
    pub sent: Matrix,
    /// This peer one metre away along as many directions as there are shared axes.
    pub translations: Vec<Translation>,
    /// Length of a line that counts its ticks, as `coordination.credit_ticks` has it.
    pub line_ticks: Option<usize>,
}

/// A peer at rest one metre from where the linear scene has it.
#[derive(Clone, Debug)]
pub struct Translation {
    /// Local state of the peer, in SI units.
    pub local: Vec<f64>,
    /// The packet it sends there.
    pub sent: Vec<f64>,
    /// Whether it stays there while it hears that packet: times 0, +1 and −1.
    pub stays: [bool; 3],
    /// Where the position of the object along the axis of the same number stands in the local state.
    pub object: usize,
}

impl Response {
    /// Number of local states.
    pub fn states(&self) -> usize {
        self.own.nrows()
    }

    /// Numbers in a packet.
    pub fn packet(&self) -> usize {
        self.sent.nrows()
    }

    /// Drives peer `index` (0 or 1) of a scene that is linear ([`Scene::linear`]), in the state in which it stays in the end; a packet is
    /// heard before tick `at_tick` of the packet period. Without such a state the answer has no states.
    ///
    /// # Errors
    /// The first key that is out of range or impossible beside the others.
    pub fn measure(&mut self, linear: &Scene, index: usize, at_tick: usize) -> Result<(), Refused<'static>> {
        match seats(linear, index, at_tick)?.pop() {
            Some(mut seat) => self.of(&mut *seat, linear),
            None => *self = Self::default(),
        }
        Ok(())
    }

    /// [`Response::measure`] in each state in which the peer stays for a while, that of the end last; none, if it has no such state.
    pub(crate) fn measure_each(
        answers: &mut Vec<Self>,
        linear: &Scene,
        index: usize,
        at_tick: usize,
    ) -> Result<(), Refused<'static>> {
        let mut seats = seats(linear, index, at_tick)?;
        answers.resize_with(seats.len(), Self::default);
        answers.iter_mut().zip(&mut seats).for_each(|(answer, seat)| answer.of(&mut **seat, linear));
        Ok(())
    }

    fn of(&mut self, seat: &mut dyn Seated, linear: &Scene) {
        let [states, packet] = seat.sizes();
        reset(&mut self.own, states, states);
        reset(&mut self.heard, states, packet);
        reset(&mut self.sent, packet, states);
        for at in 0..states {
            seat.rest();
            seat.start().0[at] = 1.0;
            seat.send(column_mut(&mut self.sent, at));
            seat.period(column_mut(&mut self.own, at));
        }
        for at in 0..packet {
            // What is never sent need not be heard.
            if (0..states).all(|state| self.sent[(at, state)] == 0.0) {
                continue;
            }
            seat.rest();
            seat.start().1[at] = 1.0;
            seat.period(column_mut(&mut self.heard, at));
        }
        self.translations = translate(seat, &along(linear));
        self.line_ticks = seat.line_ticks();
    }

    /// The local state after a period from `local`, hearing `packet` at its start; a check of superposition needs no more. Nothing, if the
    /// peer has no state in which it stays.
    ///
    /// # Errors
    /// The first key that is out of range or impossible beside the others.
    pub fn drive(linear: &Scene, index: usize, local: &[f64], packet: &[f64]) -> Result<Vec<f64>, Refused<'static>> {
        Ok(seats(linear, index, 0)?.pop().map_or_else(Vec::new, |mut seat| driven(&mut *seat, local, packet)))
    }
}

/// [`Response::drive`] of a peer that has settled.
pub(crate) fn driven(seat: &mut dyn Seated, local: &[f64], packet: &[f64]) -> Vec<f64> {
    let (at, heard) = seat.start();
    at.copy_from_slice(local);
    heard.copy_from_slice(packet);
    let mut after = vec![0.0; local.len()];
    seat.period(&mut after);
    after
}

/// Unit vectors along which translations are looked at: the axes, or where a guide couples them its normal and what is across it.
fn along(linear: &Scene) -> Vec<Vec<f64>> {
    let axes = linear.peer.axis.shared as usize;
    let peers = linear.peers();
    let guide = peers.iter().map(|peer| &peer.fixture).find(|fixture| fixture.kind != FixtureName::None);
    let (direction, elevation) = guide.map_or((0.0, 0.0), |guide| (guide.direction_rad, guide.elevation_rad));
    let ((sine, cosine), (up, level)) = (libm::sincos(direction), libm::sincos(elevation));
    let all = [[cosine * level, sine * level, up], [-sine, cosine, 0.0], [-cosine * up, -sine * up, level]];
    all[..axes].iter().map(|unit| unit[..axes].to_vec()).collect()
}

/// Finds what translations of a peer along these directions are, and whether the peer stays there.
fn translate(seat: &mut dyn Seated, along: &[Vec<f64>]) -> Vec<Translation> {
    let [states, packet] = seat.sizes();
    let mut axes = vec![vec![0.0; states]; along.len()];
    let objects: Vec<_> = axes.iter_mut().enumerate().map(|(axis, local)| seat.translation(axis, local)).collect();
    let mut translations = Vec::with_capacity(along.len());
    for (unit, object) in along.iter().zip(objects) {
        let part = |at: usize| unit.iter().zip(&axes).map(|(part, local)| part * local[at]).sum();
        let local: Vec<f64> = (0..states).map(part).collect();
        let (mut sent, mut after) = (vec![0.0; packet], vec![0.0; states]);
        seat.rest();
        seat.start().0.copy_from_slice(&local);
        seat.send(&mut sent);
        let stays = [0.0, 1.0, -1.0].map(|sign| {
            let (at, heard) = seat.start();
            at.copy_from_slice(&local);
            for (number, sent) in heard.iter_mut().zip(&sent) {
                *number = sign * sent;
            }
            seat.period(&mut after);
            after.iter().zip(&local).all(|(after, before)| (after - before).abs() <= UNMOVED)
        });
        translations.push(Translation { local, sent, stays, object });
    }
    translations
}

/// A [`Seat`], of any number of axes.
pub(crate) trait Seated {
    /// Numbers of the local state, and of the packets.
    fn sizes(&self) -> [usize; 2];
    /// Sets every state to zero.
    fn rest(&mut self);
    /// The local state and the packets that it is to start from, in units.
    fn start(&mut self) -> (&mut [f64], &mut [f64]);
    /// What the peer would send.
    fn send(&self, sent: &mut [f64]);
    /// One exchange and M ticks.
    fn period(&mut self, after: &mut [f64]);
    /// Writes the local state of this peer at rest at one metre along an axis; where the position of the object is in it.
    fn translation(&mut self, axis: usize, local: &mut [f64]) -> usize;
    /// Length of the line, ticks.
    fn line_ticks(&self) -> Option<usize>;
}

/// Of a peer of the linear scene, as many axes as it shares, in each state in which it stays.
pub(crate) fn seats(linear: &Scene, index: usize, at_tick: usize) -> Result<Vec<Box<dyn Seated>>, Refused<'static>> {
    of_axes!(linear, seats_of(linear, index, at_tick))
}

fn seats_of<const SHARED: usize, const N: usize>(
    linear: &Scene,
    index: usize,
    at_tick: usize,
) -> Result<Vec<Box<dyn Seated>>, Refused<'static>>
where
    f64: Builds<SHARED, N>,
{
    let settings = &linear.peers()[index];
    let at = |axes| {
        let mut peer = linear.laws.peer::<f64, SHARED, N>(settings, axes)?;
        peer.command(Command::Arm);
        Ok::<_, Refused<'static>>(peer)
    };
    let start = at([Motion::REST; N])?;
    let mut there: [_; SHARED] = from_fn(|_| start.clone());
    for (axis, there) in there.iter_mut().enumerate() {
        let mut device = [Motion::REST; N];
        device[axis] = Motion::at(1.0);
        *there = at(device)?;
    }
    let plant = Plant::build(linear, index);
    let seat = |settled| Seat::new(linear, index, at_tick, settled, there.clone(), plant.clone());
    let boxed = |seat| Box::new(seat) as Box<dyn Seated>;
    Ok(settle(start, linear, &plant.sensors(), at_tick).into_iter().map(seat).map(boxed).collect())
}

/// Most packet periods, beyond four round trips, that a line needs to learn a delay.
const LEARNING: usize = 64;

/// How long a state must last to be judged, and to be the last one, s: a line is made shorter once a second.
const STAYS_S: f64 = 0.5;
const LAST_S: f64 = 2.2;

/// Looks at a line's answer in the time for which a state must last.
const LOOKS: usize = 16;

/// A peer at rest on the scene's network in a state in which it stays, and the packet that is due.
struct Settled<const SHARED: usize, const N: usize> {
    peer: Box<dyn DynPeer<f64, SHARED, N>>,
    due: [Packet<f64>; SHARED],
    line_ticks: Option<usize>,
}

/// Leaves a peer that counts at rest on the scene's network, hearing itself, for as long as its answer changes; each state in which it stays
/// with every tick live. A peer that counts nothing only begins a period later, when it knows how old its packet is.
fn settle<const SHARED: usize, const N: usize>(
    mut at_rest: Box<dyn DynPeer<f64, SHARED, N>>,
    linear: &Scene,
    sensors: &Sensors<f64, N>,
    at_tick: usize,
) -> Vec<Settled<SHARED, N>> {
    let timing = &linear.peer.timing;
    let packet = timing.ticks_per_packet as usize;
    let go_on = |peer: &mut dyn DynPeer<f64, SHARED, N>, due: Option<[Packet<f64>; SHARED]>| {
        for tick in 0..packet {
            before_tick(peer, tick, due.filter(|_| tick == at_tick));
            peer.tick(sensors);
        }
        // At rest all axes count alike.
        peer.outgoing()[0].live_ticks
    };
    if !counts(linear) {
        let due = [Packet::default(); SHARED];
        go_on(&mut *at_rest, Some(due));
        return vec![Settled { peer: at_rest, due, line_ticks: None }];
    }
    // What all states together answer: two states of a line that answer alike are one.
    let answer = |peer: &dyn DynPeer<f64, SHARED, N>, due| {
        let (mut driven, mut sum) = (peer.boxed(), 0.0);
        driven.visit_state(&mut |number| *number = UNIT);
        go_on(&mut *driven, Some(due));
        driven.visit_state(&mut |number| sum = 0.75 * sum + *number);
        sum / UNIT
    };
    // How many samples come out if nothing more is heard, beyond those that the other end had emitted when it sent the newest packet.
    let length = |peer: &dyn DynPeer<f64, SHARED, N>, due: [Packet<f64>; SHARED]| {
        let (mut dry, mut before) = (peer.boxed(), peer.outgoing()[0].live_ticks);
        let mut live = go_on(&mut *dry, Some(due));
        while live != before {
            (before, live) = (live, go_on(&mut *dry, None));
        }
        live.wrapping_sub(due[0].live_ticks) as usize
    };
    // The mean of both ways, as far as a packet that is heard then allows.
    let mean = delays_ticks(linear).iter().sum::<usize>().div_ceil(2);
    let delay = (mean + packet - 1 - at_tick) / packet;
    let of_s = |seconds: f64| (seconds / timing.packet_period_s()).ceil() as usize;
    let look = (of_s(STAYS_S) / LOOKS).max(1);
    let (mut reached, mut flying) = (Vec::new(), VecDeque::new());
    let (mut live, mut same, mut known, mut before) = (0, 0, f64::NAN, at_rest.outgoing()[0].live_ticks);
    // Learning a delay takes round trips by the logarithm of it, and each state that lasts may be followed by another.
    let mut patience = (LEARNING + delay) * LEARNING + of_s(LAST_S);
    while patience > 0 && same < of_s(LAST_S) {
        patience -= 1;
        flying.push_back(at_rest.outgoing());
        let due = if flying.len() > delay { flying.pop_front() } else { None };
        if let Some(due) = due.filter(|_| live > 4 * (delay + 1) && patience.is_multiple_of(look)) {
            let now = answer(&*at_rest, due);
            same = if now == known { same + look } else { 0 };
            known = now;
            if same >= of_s(STAYS_S) && same < of_s(STAYS_S) + look {
                let line_ticks = linear.law().own_time.then(|| length(&*at_rest, due));
                reached.push(Settled { peer: at_rest.clone(), due, line_ticks });
                patience += of_s(LAST_S);
            }
        }
        let now = go_on(&mut *at_rest, due);
        live = if now.wrapping_sub(before) == timing.ticks_per_packet { live + 1 } else { 0 };
        same = if live > 0 { same } else { 0 };
        before = now;
    }
    // A line that goes on changing, or holds still again, does not stay as it was.
    if same < of_s(LAST_S) { Vec::new() } else { reached }
}

/// Whether the law sends what is worth a packet only: less than that goes out once in [`LONGEST`].
pub(crate) fn keeps_silent(linear: &Scene) -> bool {
    linear.peer.own(&LONGEST) > 0.0
}

/// Whether the law counts ticks, and has states of its own.
pub(crate) fn counts(linear: &Scene) -> bool {
    linear.laws.bounds(&linear.peer).counts()
}

/// What happens before a tick of a packet period.
fn before_tick<const SHARED: usize, const N: usize>(
    peer: &mut dyn DynPeer<f64, SHARED, N>,
    tick: usize,
    heard: Option<[Packet<f64>; SHARED]>,
) {
    if let Some(packets) = heard {
        peer.hear(&packets);
    }
    if tick == 0 {
        peer.exchange();
    }
}

/// A peer in front of its device, and the state and packet it is to start from, in units.
struct Seat<const SHARED: usize, const N: usize> {
    armed: Box<dyn DynPeer<f64, SHARED, N>>,
    /// The same one metre away along each shared axis.
    there: [Box<dyn DynPeer<f64, SHARED, N>>; SHARED],
    ticks_per_packet: usize,
    /// The tick before which the packet is heard.
    at_tick: usize,
    plant: Plant<N>,
    /// Numbers of the device along an axis.
    device_states: usize,
    local: Vec<f64>,
    packet: Vec<f64>,
    /// What arrives next at rest: the counters of a packet, and what a peer says at rest.
    due: [Packet<f64>; SHARED],
    line_ticks: Option<usize>,
}

/// Calls `each` for every number of the packets.
fn visit_all(packets: &mut [Packet<f64>], mut each: impl FnMut(&mut f64)) {
    for packet in packets {
        packet.visit(&mut each);
    }
}

impl<const SHARED: usize, const N: usize> Seat<SHARED, N> {
    fn new(
        linear: &Scene,
        index: usize,
        at_tick: usize,
        settled: Settled<SHARED, N>,
        there: [Box<dyn DynPeer<f64, SHARED, N>>; SHARED],
        plant: Plant<N>,
    ) -> Self {
        let Settled { peer: mut armed, due, line_ticks } = settled;
        let device_states = device_states(linear, index);
        let (mut states, mut numbers) = (device_states * SHARED, 0);
        armed.visit_state(&mut |_| states += 1);
        visit_all(&mut [Packet::default(); SHARED], |_| numbers += 1);
        let ticks_per_packet = linear.peer.timing.ticks_per_packet as usize;
        let (local, packet) = (vec![0.0; states], vec![0.0; numbers]);
        Self { armed, there, ticks_per_packet, at_tick, plant, device_states, local, packet, due, line_ticks }
    }

    /// The peer's share of the state, in the unit that is driven.
    fn loaded(&self) -> Box<dyn DynPeer<f64, SHARED, N>> {
        let mut state = self.armed.clone();
        let mut numbers = self.local[self.device_states * SHARED..].iter();
        state.visit_state(&mut |number| *number = numbers.next().copied().unwrap_or(0.0) * UNIT);
        state
    }
}

impl<const SHARED: usize, const N: usize> Seated for Seat<SHARED, N>
where
    f64: Builds<SHARED, N>,
{
    fn sizes(&self) -> [usize; 2] {
        [self.local.len(), self.packet.len()]
    }

    fn rest(&mut self) {
        self.local.fill(0.0);
        self.packet.fill(0.0);
    }

    fn start(&mut self) -> (&mut [f64], &mut [f64]) {
        (&mut self.local, &mut self.packet)
    }

    fn send(&self, sent: &mut [f64]) {
        // What a peer says at rest is no signal: what its line should weigh, say.
        let (mut packets, mut at_rest) = (self.loaded().outgoing(), self.armed.outgoing());
        let mut resting = Vec::new();
        visit_all(&mut at_rest, |number| resting.push(*number));
        let mut sent = sent.iter_mut().zip(resting);
        visit_all(&mut packets, |number| {
            if let Some((sent, resting)) = sent.next() {
                *sent = (*number - resting) / UNIT;
            }
        });
    }

    fn period(&mut self, after: &mut [f64]) {
        let mut peer = self.loaded();
        let mut device = self.local.iter().map(|number| number * UNIT);
        self.plant.visit_axes(SHARED, |number| *number = device.next().unwrap_or(0.0));
        let mut packets = self.due;
        let mut numbers = self.packet.iter();
        visit_all(&mut packets, |number| *number += numbers.next().copied().unwrap_or(0.0) * UNIT);

        for tick in 0..self.ticks_per_packet {
            before_tick(&mut *peer, tick, (tick == self.at_tick).then_some(packets));
            let sensors = self.plant.sensors();
            let actuators = peer.tick(&sensors);
            self.plant.step(0.0, &actuators);
        }

        let mut within = peer.mode() == Mode::Armed;
        let mut after = after.iter_mut();
        let mut store = |number: f64| {
            within &= number.abs() < TOO_LARGE * UNIT;
            if let Some(after) = after.next() {
                *after = if within { number / UNIT } else { f64::INFINITY };
            }
        };
        self.plant.visit_axes(SHARED, |number| store(*number));
        peer.visit_state(&mut |number| store(*number));
    }

    fn translation(&mut self, axis: usize, local: &mut [f64]) -> usize {
        local[self.device_states * axis] = 1.0;
        let first = self.device_states * SHARED;
        let mut numbers = local[first..].iter_mut();
        self.there[axis].visit_state(&mut |number| {
            if let Some(out) = numbers.next() {
                *out = *number;
            }
        });
        // Of every axis the position of the object comes first, and those of the others are 0.
        first + local[first..].iter().position(|number| *number == 1.0).unwrap_or(0)
    }

    fn line_ticks(&self) -> Option<usize> {
        self.line_ticks
    }
}
