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
//! **Counters.** A line with a time of its own counts what it has sent and heard. Such a peer is first left at rest on the
//! scene's network until every tick is live, and starts each period with the counters it has then, and the packet that is due.
//!
//! **Order of the local state**: x_h, ẋ_h, motor force of the tick before; then what `State::visit` visits (object,
//! integrator, law, velocity estimators). Units: m, m/s, N, √W.

use std::collections::VecDeque;

use haptic_core::device::AXES;
use haptic_core::law::{Packet, Sends};
use haptic_core::num::{Motion, StateVector};
use haptic_core::safety::{Command, Mode};
use haptic_core::settings::{Refused, Settings};

use super::delay::delays_ticks;
use crate::matrix::{Matrix, column_mut, reset};
use haptic_sim::peers::DynPeer;
use haptic_sim::plant::Plant;
use haptic_sim::scene::Scene;

/// 2⁻³⁰⁰: what stands for one unit of a state.
const UNIT: f64 = f64::from_bits((1023 - 300) << 52);

/// 2²⁵⁰: an answer above it may have met a limit on its way.
pub(crate) const TOO_LARGE: f64 = f64::from_bits((1023 + 250) << 52);

/// How exactly a translation must come back to be a rest mode, m.
const UNMOVED_M: f64 = 1e-12;

/// States of the device: position, velocity, motor force of the tick before.
const DEVICE_STATES: usize = 3;

/// Where the position of a peer's object stands in its local state.
pub(crate) const OBJECT: usize = DEVICE_STATES;

/// The answer of one peer to one packet period.
#[derive(Clone, Debug)]
pub struct Response {
    /// Local state after the period for each local state before, when the packet that arrives is all zeros.
    pub own: Matrix,
    /// Local state after the period for each number of the packet that arrives in it, from rest.
    pub heard: Matrix,
    /// Each number of the packet sent at the start of the period, for each local state before.
    pub sent: Matrix,
    /// The local state of this peer at rest one metre away.
    pub translation: Vec<f64>,
    /// The packet it sends there.
    pub translation_sent: Vec<f64>,
    /// Whether it stays there while it hears that packet: times 0, +1 and −1.
    pub stays: [bool; 3],
}

impl Default for Response {
    fn default() -> Self {
        let [own, heard, sent] = [(); 3].map(|()| Matrix::zeros(0, 0));
        Self { own, heard, sent, translation: Vec::new(), translation_sent: Vec::new(), stays: [false; 3] }
    }
}

impl Response {
    /// Local states.
    pub fn states(&self) -> usize {
        self.own.nrows()
    }

    /// Numbers in a packet.
    pub fn packet(&self) -> usize {
        self.sent.nrows()
    }

    /// Drives peer `index` (0 or 1) of a scene that is linear ([`Scene::linear`]); a packet is heard before tick `at_tick` of the
    /// packet period.
    pub fn measure(&mut self, linear: &Scene, index: usize, at_tick: usize) -> Result<(), Refused<'static>> {
        let mut seat = Seat::new(linear, index, at_tick)?;
        let (states, packet) = (seat.local.len(), seat.packet.len());
        reset(&mut self.own, states, states);
        reset(&mut self.heard, states, packet);
        reset(&mut self.sent, packet, states);
        for at in 0..states {
            seat.rest();
            seat.local[at] = 1.0;
            seat.send(column_mut(&mut self.sent, at));
            seat.period(column_mut(&mut self.own, at));
        }
        for at in 0..packet {
            // What is never sent need not be heard.
            if (0..states).all(|state| self.sent[(at, state)] == 0.0) {
                continue;
            }
            seat.rest();
            seat.packet[at] = 1.0;
            seat.period(column_mut(&mut self.heard, at));
        }
        self.translate(&mut seat);
        Ok(())
    }

    /// Finds what a translation of this peer is, and whether the peer stays there.
    fn translate(&mut self, seat: &mut Seat) {
        self.translation.clear();
        self.translation.resize(seat.local.len(), 0.0);
        self.translation_sent.clear();
        self.translation_sent.resize(seat.packet.len(), 0.0);
        seat.translation(&mut self.translation);
        seat.rest();
        seat.local.copy_from_slice(&self.translation);
        seat.send(&mut self.translation_sent);
        let mut after = vec![0.0; seat.local.len()];
        for (sign, stays) in [0.0, 1.0, -1.0].into_iter().zip(&mut self.stays) {
            seat.local.copy_from_slice(&self.translation);
            for (number, sent) in seat.packet.iter_mut().zip(&self.translation_sent) {
                *number = sign * sent;
            }
            seat.period(&mut after);
            *stays = after.iter().zip(&self.translation).all(|(after, before)| (after - before).abs() <= UNMOVED_M);
        }
    }

    /// The local state after a period from `local`, hearing `packet` at its start; a check of superposition needs no more.
    pub fn drive(linear: &Scene, index: usize, local: &[f64], packet: &[f64]) -> Result<Vec<f64>, Refused<'static>> {
        let mut seat = Seat::new(linear, index, 0)?;
        seat.local.copy_from_slice(local);
        seat.packet.copy_from_slice(packet);
        let mut after = vec![0.0; local.len()];
        seat.period(&mut after);
        Ok(after)
    }
}

/// Most packet periods, beyond four round trips, that a line needs to learn a delay.
const LEARNING: usize = 64;

/// Leaves a peer that counts at rest on the scene's network, hearing itself, until every tick of some round trips was live; the
/// packet that is due next. A peer that counts nothing stays as it is; `None` where the line
/// goes on standing now and then.
fn settle(peer: &mut Box<dyn DynPeer<f64>>, linear: &Scene, plant: &Plant, at_tick: usize) -> Option<Packet<f64>> {
    if !matches!(linear.law().sends, Sends::Counters | Sends::Integrals) {
        return Some(Packet::default());
    }
    let timing = &linear.peer.timing;
    // The mean of both ways, as far as a packet that is heard then allows.
    let (packet, mean) = (timing.ticks_per_packet as usize, delays_ticks(linear).iter().sum::<usize>().div_ceil(2));
    let delay = (mean + packet - 1 - at_tick) / packet;
    let sensors = plant.sensors();
    let (mut at_rest, mut flying) = (peer.clone(), VecDeque::new());
    let mut live = 0;
    // Learning a delay takes round trips by the logarithm of it.
    let patience = (LEARNING + delay) * LEARNING;
    for _ in 0..patience {
        flying.push_back(at_rest.outgoing());
        let due = flying.front().copied().filter(|_| flying.len() > delay);
        if live > 4 * (delay + 1) {
            *peer = at_rest;
            return due;
        }
        let before = at_rest.outgoing().live_ticks;
        if due.is_some() {
            flying.pop_front();
        }
        for tick in 0..packet {
            before_tick(&mut *at_rest, tick, due.filter(|_| tick == at_tick));
            at_rest.tick(&sensors);
        }
        let ticks = at_rest.outgoing().live_ticks.wrapping_sub(before);
        live = if ticks == timing.ticks_per_packet { live + 1 } else { 0 };
    }
    None
}

/// What happens before a tick of a packet period.
fn before_tick(peer: &mut dyn DynPeer<f64>, tick: usize, heard: Option<Packet<f64>>) {
    if let Some(packet) = heard {
        peer.hear(packet);
    }
    if tick == 0 {
        peer.exchange();
    }
}

/// A peer in front of its device, and the state and packet it is to start from, in units.
struct Seat {
    armed: Box<dyn DynPeer<f64>>,
    /// The same one metre away.
    there: Box<dyn DynPeer<f64>>,
    ticks_per_packet: usize,
    /// The tick before which the packet is heard.
    at_tick: usize,
    plant: Plant,
    local: Vec<f64>,
    packet: Vec<f64>,
    /// What arrives next at rest: the counters of a packet.
    due: Packet<f64>,
}

impl Seat {
    fn new(linear: &Scene, index: usize, at_tick: usize) -> Result<Self, Refused<'static>> {
        let settings = &linear.peers()[index];
        let at = |settings: &Settings, axes| {
            let mut peer = linear.laws.peer(settings, axes)?;
            peer.command(Command::Arm);
            Ok(peer)
        };
        let [free, held @ ..] = [Motion::REST; AXES];
        let (mut armed, there) = (at(settings, [free, held[0]])?, at(settings, [Motion::at(1.0), held[0]])?);
        let mut states = DEVICE_STATES;
        armed.visit(&mut |_| states += 1);
        let mut numbers = 0;
        Packet::<f64>::default().visit(&mut |_| numbers += 1);
        let plant = Plant::new(linear, index);
        let due = match settle(&mut armed, linear, &plant, at_tick) {
            Some(due) => due,
            // A credit below the delay: while it is live, the line is one of the delay.
            None => {
                let mut follows = linear.clone();
                // A key of the law, which allows 0.
                let _ = follows.set_number("coordination.credit_ticks", 0.0);
                armed = at(&follows.peers()[index], [free, held[0]])?;
                settle(&mut armed, linear, &plant, at_tick).unwrap_or_default()
            }
        };
        let ticks_per_packet = settings.timing.ticks_per_packet as usize;
        let (local, packet) = (vec![0.0; states], vec![0.0; numbers]);
        Ok(Self { armed, there, ticks_per_packet, at_tick, plant, local, packet, due })
    }

    /// Everything at zero.
    fn rest(&mut self) {
        self.local.fill(0.0);
        self.packet.fill(0.0);
    }

    /// The peer's share of the state, in the unit that is driven.
    fn loaded(&self) -> Box<dyn DynPeer<f64>> {
        let mut state = self.armed.clone();
        let mut numbers = self.local[DEVICE_STATES..].iter();
        state.visit(&mut |number| *number = numbers.next().copied().unwrap_or(0.0) * UNIT);
        state
    }

    /// What the peer would send.
    fn send(&self, sent: &mut [f64]) {
        let mut packet = self.loaded().outgoing();
        let mut sent = sent.iter_mut();
        packet.visit(&mut |number| {
            if let Some(sent) = sent.next() {
                *sent = *number / UNIT;
            }
        });
    }

    /// One exchange and M ticks.
    fn period(&mut self, after: &mut [f64]) {
        let mut peer = self.loaded();
        let (motion, motor) = self.plant.free_axis();
        *motion = Motion { position: self.local[0] * UNIT, velocity: self.local[1] * UNIT };
        *motor = self.local[2] * UNIT;
        let mut packet = self.due;
        let mut numbers = self.packet.iter();
        packet.visit(&mut |number: &mut f64| *number = numbers.next().copied().unwrap_or(0.0) * UNIT);

        for tick in 0..self.ticks_per_packet {
            before_tick(&mut *peer, tick, (tick == self.at_tick).then_some(packet));
            let sensors = self.plant.sensors();
            let actuators = peer.tick(&sensors);
            self.plant.step(0.0, &actuators);
        }

        let (motion, motor) = self.plant.free_axis();
        let mut within = peer.mode() == Mode::Armed;
        let mut after = after.iter_mut();
        let mut store = |number: f64| {
            within &= number.abs() < TOO_LARGE * UNIT;
            if let Some(after) = after.next() {
                *after = if within { number / UNIT } else { f64::INFINITY };
            }
        };
        [motion.position, motion.velocity, *motor].into_iter().for_each(&mut store);
        peer.visit(&mut |number| store(*number));
    }

    /// Writes the local state of this peer at rest at one metre.
    fn translation(&mut self, local: &mut [f64]) {
        local[0] = 1.0;
        let mut numbers = local[DEVICE_STATES..].iter_mut();
        self.there.visit(&mut |number| {
            if let Some(out) = numbers.next() {
                *out = *number;
            }
        });
    }
}
