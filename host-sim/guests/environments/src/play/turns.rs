//! One at a time: three users at one object, who take turns by a lock that a server keeps, or by a token that goes round.
//!
//! A hand that takes hold near the object asks for it. Who may edit carries it along and publishes where it lets go; who loses the right
//! before sees the object go back to where it is for all. Hands that nobody holds are moved by bots: they come, carry it
//! somewhere, and rest.

use cohold_cli::Failure;
use cohold_live::key_file::entropy;
use cohold_live::playable::{Column, Held, PERIOD_S, Play};
use cohold_protocol::wire::PeerId;
use cohold_sim::engine::{Actor, Engine, Out, Seat};
use cohold_sim::{network::link::Route, rng::Rng, scene::Scene};

use super::engine;
use crate::roles::collaborative::ring;
use crate::roles::collaborative::ring::{Record, Ring, Roster};
use crate::roles::collaborative::{Approach, Lease, Value, Wish};
use crate::roles::{Carried as _, Role as _};
use crate::{Crossing, said};
use crate::{roles::collaborative::lock, roles::collaborative::lock::Phase};

/// Number of users at the object.
const USERS: usize = 3;
/// Number of the shared object.
const OBJECT: u16 = 1;
/// A right lives on without being renewed for this long, and a turn while others wait, µs.
const LEASE_US: u32 = 1_000_000;
const TURN_US: u64 = 4_000_000;
/// How near a hand asks, and how far it has gone, m.
const APPROACH: Approach = Approach { near_m: 0.015, far_m: 0.025 };
/// How fast a hand is, m/s.
const SPEED_M_PER_S: f64 = 0.25;
/// How long a bot rests at the most, ticks.
const RESTS: u64 = 5000;
/// Where the hands rest, m, and how far to each side a bot carries the object.
const HOMES: [[f64; 2]; USERS] = [[-0.1, 0.04], [0.1, 0.04], [0.0, -0.05]];
const FAR_M: [f64; 2] = [0.08, 0.03];

pub(super) const COLUMNS: [Column; 19] = [
    ("hand_1_x", "m", "hand 1, along"),
    ("hand_1_y", "m", "hand 1, across"),
    ("hand_2_x", "m", "hand 2"),
    ("hand_2_y", "m", "hand 2"),
    ("hand_3_x", "m", "hand 3"),
    ("hand_3_y", "m", "hand 3"),
    ("object_1_x", "m", "the object as user 1 sees it"),
    ("object_1_y", "m", "the object as user 1 sees it"),
    ("object_2_x", "m", "the object as user 2 sees it"),
    ("object_2_y", "m", "the object as user 2 sees it"),
    ("object_3_x", "m", "the object as user 3 sees it"),
    ("object_3_y", "m", "the object as user 3 sees it"),
    ("state_1", "", "0: user 1 wants nothing; 1: it asks; 2: it has the object"),
    ("state_2", "", "the same of user 2"),
    ("state_3", "", "the same of user 3"),
    ("version_1", "", "newest version of the object that user 1 knows"),
    ("version_2", "", "the same of user 2"),
    ("version_3", "", "the same of user 3"),
    ("owner", "", "who may edit: 1 to 3; 0 nobody"),
];

fn value_of(place: [f64; 2]) -> Value {
    let mut value = Value::default();
    let bytes = place.map(|metres| (metres as f32).to_le_bytes());
    value[..8].copy_from_slice(bytes.as_flattened());
    value
}

fn place_of(value: &Value) -> [f64; 2] {
    [0, 4].map(|at| f64::from(f32::from_le_bytes([value[at], value[at + 1], value[at + 2], value[at + 3]])))
}

fn distance([a, b]: [f64; 2], [x, y]: [f64; 2]) -> f64 {
    libm::hypot(a - x, b - y)
}

/// A user's end of the right to edit.
enum Right {
    Lock(Box<lock::Client>),
    Ring(Box<Ring>),
}

/// Who sits at the engine.
enum Around {
    Server(Box<lock::Server<USERS>>),
    User(Box<User>),
}

/// A user who takes turns.
struct User {
    right: Right,
    home: [f64; 2],
    hand: [f64; 2],
    held: Held,
    /// The object as it is rendered here.
    place: [f64; 2],
    /// Object less hand when it was taken; none while the hand does not have it.
    grip: Option<[f64; 2]>,
    /// It has lost the object, and lets go before it takes it again.
    lost: bool,
    /// What a bot does: rests until this tick, then takes the object to that place.
    errand: (u64, [f64; 2]),
    rng: Rng,
    tick: u64,
}

impl User {
    fn new(right: Right, index: usize, rng: Rng) -> Self {
        let home = HOMES[index];
        let errand = (1000 * (index as u64 + 1), [0.0; 2]);
        Self {
            right,
            home,
            hand: home,
            held: Held::ByNobody,
            place: [0.0; 2],
            grip: None,
            lost: false,
            errand,
            rng,
            tick: 0,
        }
    }

    fn owns(&self, now: u64) -> bool {
        match &self.right {
            Right::Lock(client) => client.owns(now),
            Right::Ring(ring) => ring.owns(now),
        }
    }

    /// What the object is for all, as far as it is known here.
    fn official(&self) -> (u32, [f64; 2]) {
        match &self.right {
            Right::Lock(client) => (client.copy().version, place_of(&client.copy().value)),
            Right::Ring(ring) => (ring.state().version, place_of(&ring.state().value)),
        }
    }

    /// 0: it wants nothing, 1: it asks, 2: it may edit.
    fn state(&self, now: u64, asks: bool) -> u8 {
        if self.owns(now) { 2 } else { u8::from(asks) }
    }

    fn asks(&self) -> bool {
        match &self.right {
            Right::Lock(client) => client.phase() == Phase::Asking,
            Right::Ring(_) => self.grip.is_some(),
        }
    }

    /// Where the hand is wanted, and whether it is closed.
    fn wants(&mut self) -> ([f64; 2], bool) {
        match self.held {
            Held::Free => (self.hand, false),
            Held::At(at) => (at, true),
            Held::ByNobody if self.tick < self.errand.0 => (self.home, false),
            Held::ByNobody if self.grip.is_none() => (self.place, true),
            Held::ByNobody => {
                let (mine, to) = (self.grip.unwrap_or_default(), self.errand.1);
                let to = [to[0] - mine[0], to[1] - mine[1]];
                let there = distance(self.hand, to) < 1e-3;
                if there {
                    let mut within = |far: f64| far * (self.rng.below(2001) as f64 * 1e-3 - 1.0);
                    let next = FAR_M.map(&mut within);
                    self.errand = (self.tick + 1000 + self.rng.below(RESTS), next);
                }
                (to, !there)
            }
        }
    }

    /// One tick of hand and object.
    fn step(&mut self, now: u64, out: &mut Out<'_, usize, Crossing>) {
        self.tick += 1;
        let (wanted, closed) = self.wants();
        let distance_m = distance(wanted, self.hand);
        let share = (SPEED_M_PER_S * PERIOD_S / distance_m.max(1e-9)).min(1.0);
        self.hand = [0, 1].map(|axis| self.hand[axis] + share * (wanted[axis] - self.hand[axis]));
        match &mut self.right {
            Right::Lock(client) => {
                client.poll(now, &mut said(OBJECT, out));
                while let Some(notice) = client.take_notice() {
                    self.lost |= matches!(notice, lock::Notice::Expired | lock::Notice::TooLate(_));
                }
            }
            Right::Ring(ring) => {
                ring.poll(now, &mut said(OBJECT, out));
                while let Some(notice) = ring.take_notice() {
                    self.lost |= matches!(notice, ring::Notice::Overdue | ring::Notice::Lost);
                }
            }
        }
        self.lost &= closed;
        let near = APPROACH.wish(distance(self.hand, self.place) as f32) == Wish::Edit;
        if !closed || self.lost {
            self.lets_go(now, out);
        } else if self.grip.is_none() && near {
            self.grip = Some([0, 1].map(|axis| self.place[axis] - self.hand[axis]));
        }
        let owns = self.owns(now);
        match (&mut self.right, self.grip) {
            (_, Some(grip)) if owns => self.place = [0, 1].map(|axis| self.hand[axis] + grip[axis]),
            (Right::Lock(client), Some(_)) if client.phase() == Phase::Idle => client.ask(now),
            (Right::Ring(ring), Some(_)) => ring.ask(),
            _ => {}
        }
        if !owns {
            self.place = self.official().1;
            // Before it was granted the object may have gone elsewhere.
            if self.grip.is_some() && distance(self.hand, self.place) > f64::from(APPROACH.far_m) {
                self.lets_go(now, out);
            }
        }
    }

    /// Publishes where the object is, if it has it; asks no more.
    fn lets_go(&mut self, now: u64, out: &mut Out<'_, usize, Crossing>) {
        if self.grip.take().is_none() {
            return;
        }
        let value = value_of(self.place);
        match &mut self.right {
            Right::Lock(client) if client.phase() == Phase::Asking => client.withdraw(&mut said(OBJECT, out)),
            // What is refused was lost before, and is told as that.
            Right::Lock(client) => _ = client.release(now, Some(value), &mut said(OBJECT, out)),
            Right::Ring(ring) => {
                if ring.publish(now, value, &mut said(OBJECT, out)).is_err() {
                    ring.give_up(now, &mut said(OBJECT, out));
                }
            }
        }
    }
}

impl Actor<usize> for Around {
    type Packet = Crossing;

    fn hear(&mut self, now_ns: u64, from: usize, Crossing(message): &mut Crossing, out: &mut Out<'_, usize, Crossing>) {
        let (now, from) = (now_ns / 1_000, PeerId(from as u8));
        match self {
            Self::Server(server) => {
                if let Some((_, message)) = lock::Message::read(message) {
                    server.receive(now, from, &message, &mut said(OBJECT, out));
                }
            }
            Self::User(user) => match &mut user.right {
                Right::Lock(client) => {
                    if let Some((_, message)) = lock::Message::read(message) {
                        client.receive(now, from, &message, &mut said(OBJECT, out));
                    }
                }
                Right::Ring(ring) => {
                    if let Some((_, message)) = ring::Message::read(message) {
                        ring.receive(now, from, &message, &mut said(OBJECT, out));
                    }
                }
            },
        }
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, Crossing>) {
        let now = now_ns / 1_000;
        match self {
            Self::Server(server) => server.poll(now, &mut said(OBJECT, out)),
            Self::User(user) => user.step(now, out),
        }
    }
}

/// Users who take turns: by a lock, whose server sits first, or by a token.
pub(super) struct Turns<const LOCK: bool> {
    engine: Engine<Around>,
}

impl<const LOCK: bool> Turns<LOCK> {
    fn users(&self) -> impl Iterator<Item = (u64, &User)> {
        let now = self.engine.now_ns() / 1_000;
        self.engine.seats.iter().filter_map(move |seat| match &seat.actor {
            Around::User(user) => Some((now, user.as_ref())),
            Around::Server(_) => None,
        })
    }

    pub(super) fn open(scene: &Scene) -> Result<Self, Failure> {
        let lease = Lease::new(LEASE_US)?;
        let seeds = entropy()?;
        let mut rng = Rng::new(u64::from_le_bytes([0, 1, 2, 3, 4, 5, 6, 7].map(|at| seeds[at])));
        let everybody = Roster::of(0..USERS as u8);
        let server = LOCK.then(|| Around::Server(Box::new(lock::Server::new(lease, Value::default()))));
        let mut user = |index: usize| {
            let seed = rng.below(u64::MAX);
            let right = if LOCK {
                Right::Lock(Box::new(lock::Client::new(PeerId(0), lease, seed as u32, Value::default())))
            } else {
                let config = ring::Config { seat: index as u8, contacts: everybody, lease, turn_us: TURN_US, seed };
                Right::Ring(Box::new(Ring::new(config, 0, Record::founder(everybody, Value::default()))))
            };
            Around::User(Box::new(User::new(right, index, Rng::new(!seed))))
        };
        let seats = server.into_iter().chain((0..USERS).map(&mut user)).map(Seat::new).collect();
        Ok(Self { engine: engine(scene, seats) })
    }
}

impl<const LOCK: bool> Play for Turns<LOCK> {
    fn hold(&mut self, hand: usize, held: Held) {
        let seat = hand + usize::from(LOCK);
        if let Some(Around::User(user)) = self.engine.seats.get_mut(seat).map(|seat| &mut seat.actor) {
            user.held = held;
        }
    }

    fn step(&mut self) {
        self.engine.step(&mut |_| ());
    }

    fn numbers(&self, number: &mut dyn FnMut(f64)) {
        self.users().flat_map(|(_, user)| user.hand).for_each(&mut *number);
        self.users().flat_map(|(_, user)| user.place).for_each(&mut *number);
        self.users().for_each(|(now, user)| number(user.state(now, user.asks()).into()));
        self.users().for_each(|(_, user)| number(user.official().0.into()));
        number(self.users().position(|(now, user)| user.owns(now)).map_or(0, |owner| owner + 1) as f64);
    }

    fn seats(&self) -> usize {
        USERS + usize::from(LOCK)
    }

    fn route(&mut self, from: usize, to: usize) -> &mut Route {
        self.engine.route(from, to)
    }

    fn seat(&self) -> usize {
        usize::from(LOCK)
    }
}
