//! A static world: two visitors feel what a server of it has announced to them, over the scene's network.
//!
//! Each has a device of the cooperation paper's mass and damping, pulled by its pointer along both axes and pushed by what it touches.
//! In a static world nobody feels anybody else: where the other one is, is announced to a visitor. Nobody plays a hand that nobody holds.

use std::sync::OnceLock;

use cohold_core::num::Motion;
use cohold_live::playable::{Column, Held, PERIOD_S, Play};
use cohold_live::{hand::Hand, key_file::entropy};
use cohold_protocol::key::Key;
use cohold_sim::engine::{Actor, Engine, Out, Seat};
use cohold_sim::{network::link::Route, scene::Scene};
use serde_json::{Value, json};

use cohold_cli::Failure;

use super::engine;
use crate::Error;
use crate::records::Shape;
use crate::world::host::Host;
use crate::world::stroke::HAND;
use crate::world::visitor::{Correspondent, Setup, Visitor};
use crate::world::{TICKS_PER_PACKET, World, corners, parse};

/// What there is to be felt, and the number of its server.
const ROOM: &str = include_str!("../../../../sim/scenes/worlds/room.toml");
const SERVER: u8 = 1;
/// Number of visitors in the world.
const COUNT: usize = 2;

pub(super) const COLUMNS: [Column; 20] = [
    ("device_1_x", "m", "device 1, along"),
    ("device_1_y", "m", "device 1, across"),
    ("device_2_x", "m", "device 2"),
    ("device_2_y", "m", "device 2"),
    ("wanted_1_x", "m", "hand of person 1, no number while it holds nothing"),
    ("wanted_1_y", "m", "hand of person 1"),
    ("wanted_2_x", "m", "hand of person 2"),
    ("wanted_2_y", "m", "hand of person 2"),
    ("force_1_x", "N", "force of the world on device 1"),
    ("force_1_y", "N", "force of the world on device 1"),
    ("force_2_x", "N", "force of the world on device 2"),
    ("force_2_y", "N", "force of the world on device 2"),
    ("seen_1_x", "m", "where visitor 1 was told that visitor 2 is"),
    ("seen_1_y", "m", "where visitor 1 was told that visitor 2 is"),
    ("seen_2_x", "m", "where visitor 2 was told that visitor 1 is"),
    ("seen_2_y", "m", "where visitor 2 was told that visitor 1 is"),
    ("felt_1", "", "objects that visitor 1 has been told of"),
    ("felt_2", "", "objects that visitor 2 has been told of"),
    ("touched_1", "", "objects that visitor 1 touches"),
    ("touched_2", "", "objects that visitor 2 touches"),
];

fn world() -> Result<&'static World, &'static Error> {
    static READ: OnceLock<Result<Box<World>, Error>> = OnceLock::new();
    READ.get_or_init(|| parse(ROOM, "scenes/worlds/room.toml")).as_deref()
}

/// Outlines of what there is, for a page to draw, m: corners of what is solid, centre and radius of what is round, ends of a strip.
pub(super) fn outlines() -> Value {
    let Ok(world) = world() else { return Value::Null };
    let outline = |shape: &Shape| match shape {
        Shape::Body(body) => json!({ "round": [body.x_m, body.y_m, body.radius_m] }),
        Shape::Strip(strip) => json!({ "strip": [[strip.from_x_m, strip.from_y_m], [strip.to_x_m, strip.to_y_m]] }),
        shape => json!({ "corners": corners(shape) }),
    };
    world.objects().iter().map(|object| outline(&object.shape)).collect()
}

struct Device {
    visitor: Visitor,
    motion: [Motion<f64>; 2],
    hand: Hand<2>,
    held: Held,
    force: [f64; 2],
    tick: u64,
}

enum Around {
    Server(Box<Host<usize>>),
    Visitor(Box<Device>),
}

impl Actor<usize> for Around {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, from: usize, datagram: &mut [u8], out: &mut Out<'_, usize, [u8]>) {
        let now_us = now_ns / 1_000;
        match self {
            Self::Server(host) => _ = host.receive(now_us, from, datagram, |to, bytes| out(to, bytes)),
            Self::Visitor(device) => {
                device.visitor.receive(now_us, Correspondent::Server(SERVER), datagram, |_, bytes| out(0, bytes));
            }
        }
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, [u8]>) {
        let (now_us, tick) = (now_ns / 1_000, now_ns / (1e9 * PERIOD_S) as u64);
        match self {
            Self::Server(host) => {
                host.tick_turn(now_us, (tick % u64::from(Host::<usize>::TURNS)) as u32, |to, bytes| out(to, bytes));
            }
            Self::Visitor(device) => {
                device.step();
                if tick.is_multiple_of(u64::from(TICKS_PER_PACKET)) {
                    device.visitor.exchange(now_us, |_, bytes| out(0, bytes));
                }
            }
        }
    }
}

impl Device {
    /// A tick: the force of what is known, then the device under that and the hand's.
    fn step(&mut self) {
        let (mass, damping) = HAND;
        self.force = self.visitor.step(self.motion);
        let wanted = if let Held::At(at) = self.held { Some(at) } else { None };
        self.hand.point(self.tick, wanted, self.motion.map(|axis| axis.position));
        let pulls = self.hand.pull(self.tick, self.motion, PERIOD_S);
        for (axis, (pull, motion)) in pulls.into_iter().zip(&mut self.motion).enumerate() {
            let force = pull + self.force[axis] - damping * motion.velocity;
            motion.velocity += PERIOD_S * force / mass;
            motion.position += PERIOD_S * motion.velocity;
        }
        self.tick += 1;
    }
}

/// A server and its visitors.
pub(super) struct Visit {
    engine: Engine<Around>,
}

impl Visit {
    fn devices(&self) -> impl Iterator<Item = &Device> {
        self.engine.seats.iter().filter_map(|seat| match &seat.actor {
            Around::Visitor(device) => Some(device.as_ref()),
            Around::Server(_) => None,
        })
    }

    pub(super) fn open(scene: &Scene) -> Result<Self, Failure> {
        let key = Key::new(entropy()?);
        let host =
            Host::new(key.clone(), SERVER, COUNT as u32, world()?.clone(), None, || entropy().unwrap_or_default())?;
        let device = |line: u32| {
            let setup = Setup { key: key.line(line), line, home: SERVER, reachable: vec![SERVER], radius_m: None };
            let visitor = Visitor::new(setup, || entropy().unwrap_or_default());
            // Beside each other, in the free middle of the room.
            let motion = [Motion::at(0.03 * (f64::from(line) - 1.5)), Motion::at(-0.03)];
            let (hand, held, force) = (Hand::default(), Held::ByNobody, [0.0; 2]);
            Around::Visitor(Box::new(Device { visitor, motion, hand, held, force, tick: 0 }))
        };
        let server = std::iter::once(Around::Server(Box::new(host)));
        let seats = server.chain((1..=COUNT as u32).map(device)).map(Seat::new).collect();
        Ok(Self { engine: engine(scene, seats) })
    }
}

impl Play for Visit {
    fn hold(&mut self, hand: usize, held: Held) {
        if let Some(Around::Visitor(device)) = self.engine.seats.get_mut(hand + 1).map(|seat| &mut seat.actor) {
            device.held = held;
        }
    }

    fn step(&mut self) {
        self.engine.step(&mut |_| ());
    }

    fn numbers(&self, number: &mut dyn FnMut(f64)) {
        self.devices().flat_map(|device| device.motion.map(|axis| axis.position)).for_each(&mut *number);
        let wanted = |device: &Device| device.hand.holds().unwrap_or([f64::NAN; 2]);
        self.devices().flat_map(wanted).for_each(&mut *number);
        self.devices().flat_map(|device| device.force).for_each(&mut *number);
        let seen = |device: &Device| {
            let other = device.visitor.others().next();
            other.map_or([f64::NAN; 2], |other| other.position.map(f64::from))
        };
        self.devices().flat_map(seen).for_each(&mut *number);
        self.devices().for_each(|device| number(device.visitor.renderer.count() as f64));
        self.devices().for_each(|device| number(device.visitor.renderer.touched() as f64));
    }

    fn seats(&self) -> usize {
        COUNT + 1
    }

    fn route(&mut self, from: usize, to: usize) -> &mut Route {
        self.engine.route(from, to)
    }
}
