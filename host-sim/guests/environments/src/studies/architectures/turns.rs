//! One user at a time: the lock and the token ring of the protocol, carried by a line that only delays.
//!
//! Who owns the body moves its copy; the other's copy is the last one that was released.

use cohold_analysis::verdict;
use cohold_protocol::wire::{Message, PeerId};
use cohold_sim::engine::{Actor, Engine, Out, Seat};
use cohold_sim::network::link::Route;

use super::account::{Account, End, event_bytes, presence_bytes_per_s};
use super::hand::{Hand, TaskState};
use super::{Architecture, Error, Row, TASK, scene};
use crate::roles::collaborative::ring::{Config, Record, Ring, Roster};
use crate::roles::collaborative::{Lease, Value, lock, ring};
use crate::roles::{Carried as _, Role as _};
use crate::{Crossing, said};

/// How long a right lasts that nobody renews, µs.
const LEASE_US: u32 = 1_500_000;

/// One turn of a user, longest, µs.
const TURN_US: u64 = 4_000_000;

/// The body in a message: its position, m.
fn value(position: f64) -> Value {
    let mut value = Value::default();
    value[..8].copy_from_slice(&position.to_le_bytes());
    value
}

fn position(value: &Value) -> f64 {
    value.first_chunk().map_or(0.0, |bytes| f64::from_le_bytes(*bytes))
}

/// The body's number among the shared objects.
const OBJECT: u16 = 0;

/// The server of the lock has this number.
const SERVER: PeerId = PeerId(0);

/// A role of one peer, whichever scheme.
enum Role {
    Server(Box<lock::Server<4>>),
    Client(Box<lock::Client>),
    Member(Box<Ring>),
}

impl Role {
    fn ask(&mut self, now_us: u64) {
        match self {
            Self::Server(_) => {}
            Self::Client(role) => role.ask(now_us),
            Self::Member(role) => role.ask(),
        }
    }

    fn owns(&self, now_us: u64) -> bool {
        match self {
            Self::Server(_) => false,
            Self::Client(role) => role.owns(now_us),
            Self::Member(role) => role.owns(now_us),
        }
    }

    fn official(&self) -> f64 {
        position(match self {
            Self::Server(role) => &role.copy().value,
            Self::Client(role) => &role.copy().value,
            Self::Member(role) => &role.state().value,
        })
    }

    fn let_go(&mut self, now_us: u64, at: f64, out: &mut Out<'_, usize, Crossing>) {
        // Too late is what the others say as well: the copy stays as it was.
        let _ = match self {
            Self::Server(_) => Ok(()),
            Self::Client(role) => role.release(now_us, Some(value(at)), &mut said(OBJECT, out)),
            Self::Member(role) => role.publish(now_us, value(at), &mut said(OBJECT, out)),
        };
    }

    fn poll(&mut self, now_us: u64, out: &mut Out<'_, usize, Crossing>) {
        match self {
            Self::Server(role) => role.poll(now_us, &mut said(OBJECT, out)),
            Self::Client(role) => role.poll(now_us, &mut said(OBJECT, out)),
            Self::Member(role) => role.poll(now_us, &mut said(OBJECT, out)),
        }
    }
}

/// A peer, with a user whose hand is at the body unless it is the server.
struct SchemePeer {
    part: Role,
    hand: Option<Hand>,
    /// The user begins when the body is this far, m.
    begins_m: f64,
    period_s: f64,
    /// Ticks of the task so far; none before it begins.
    ticks: Option<u64>,
    /// Sent since then.
    bytes: usize,
}

impl Actor<usize> for SchemePeer {
    type Packet = Crossing;

    fn hear(&mut self, now_ns: u64, from: usize, Crossing(message): &mut Crossing, out: &mut Out<'_, usize, Crossing>) {
        let (now_us, from) = (now_ns / 1_000, PeerId(from as u8));
        let out = &mut counted(self.ticks.is_some(), &mut self.bytes, out);
        match (&mut self.part, lock::Message::read(message), ring::Message::read(message)) {
            (Role::Server(role), Some((_, message)), _) => role.receive(now_us, from, &message, &mut said(OBJECT, out)),
            (Role::Client(role), Some((_, message)), _) => role.receive(now_us, from, &message, &mut said(OBJECT, out)),
            (Role::Member(role), _, Some((_, message))) => role.receive(now_us, from, &message, &mut said(OBJECT, out)),
            _ => {}
        }
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, Crossing>) {
        let now_us = now_ns / 1_000;
        let Self { part, hand, .. } = self;
        let out = &mut counted(self.ticks.is_some(), &mut self.bytes, out);
        if let (Some(hand), Some(ticks)) = (hand, &mut self.ticks) {
            if hand.doing == TaskState::Waits && part.official() > self.begins_m {
                part.ask(now_us);
            }
            if hand.step(*ticks as f64 * self.period_s, part.owns(now_us), part.official()) {
                part.let_go(now_us, hand.body.position, out);
            }
            *ticks += 1;
        }
        part.poll(now_us, out);
    }
}

/// Counts what is sent at work.
fn counted<'a>(
    at_work: bool,
    bytes: &'a mut usize,
    out: &'a mut Out<'_, usize, Crossing>,
) -> impl FnMut(usize, &Crossing) {
    move |to, message| {
        if let (true, Crossing(Message::Event(event))) = (at_work, message) {
            *bytes += event_bytes(event);
        }
        out(to, message);
    }
}

/// The roles of a scheme in the order of their numbers, which of them is the first user's, and the delay of a message, µs.
fn parts(architecture: Architecture, delay_us: u64) -> Result<(Vec<Role>, usize, u64), Error> {
    let lease = Lease::new(LEASE_US).map_err(crate::Error::from)?;
    if architecture == Architecture::CollaborativeLock {
        let client = |incarnation| Role::Client(Box::new(lock::Client::new(SERVER, lease, incarnation, value(0.0))));
        let server = Role::Server(Box::new(lock::Server::new(lease, value(0.0))));
        return Ok((vec![server, client(1), client(2)], 1, delay_us / 2));
    }
    let founders = Roster::of(0..2);
    let member = |seat: u8| {
        let config = Config { seat, contacts: founders, lease, turn_us: TURN_US, seed: u64::from(seat) + 1 };
        Role::Member(Box::new(Ring::new(config, 0, Record::founder(founders, value(0.0)))))
    };
    Ok((vec![member(0), member(1)], 0, delay_us))
}

pub(super) fn row(architecture: Architecture, delay_ms: f64) -> Result<Row, Error> {
    let scene = scene(&["coordination.comm=none".to_owned()])?;
    let period_s = scene.peer.timing.control_period_s;
    let (parts, first, delay_us) = parts(architecture, (1e3 * delay_ms) as u64)?;
    let goals = [0.5 * TASK.goals_m[0], TASK.goals_m[1]];
    let seats = parts.into_iter().enumerate().map(|(at, part)| {
        let user = at.checked_sub(first);
        let hand = user.map(|user| Hand::new(&scene, user, goals[user]));
        // User 2 waits until the body is half-way.
        let begins_m = if user == Some(1) { 0.5 * goals[0] } else { f64::NEG_INFINITY };
        Seat::new(SchemePeer { part, hand, begins_m, period_s, ticks: None, bytes: 0 })
    });
    let route = |_, _| Route::new(1_000 * delay_us);
    let mut engine = Engine::new(scene.peer.timing.control_period_ns(), seats.collect(), route);
    // A ring begins by finding out that nobody has a token; that is over before the task starts.
    let settled_us = 2 * u64::from(LEASE_US) + 4 * delay_us;
    let ticks = (TASK.duration_s / period_s) as u64;
    let warm_up = (settled_us as f64 * 1e-6 / period_s) as u64;
    let mut account = Account::new(ticks);
    for tick in 0..warm_up + ticks {
        if tick == warm_up {
            engine.seats.iter_mut().for_each(|seat| seat.actor.ticks = Some(0));
        }
        engine.step(&mut |_| ());
        if tick >= warm_up {
            let mut hands = engine.seats.iter().filter_map(|seat| seat.actor.hand.as_ref());
            let [one, two] = [(); 2].map(|()| hands.next().map_or([0.0; 2], |hand| [hand.body.position, hand.force]));
            account.see([one[0], two[0]], [one[1], two[1]]);
        }
    }
    let bytes = |users: bool| -> usize {
        engine.seats.iter().filter(|seat| seat.actor.hand.is_some() == users).map(|seat| seat.actor.bytes).sum()
    };
    let (user_bytes, server_bytes) = (bytes(true), bytes(false));
    let hands = || engine.seats.iter().filter_map(|seat| seat.actor.hand.as_ref());
    let aware = presence_bytes_per_s() * TASK.duration_s;
    let served = if architecture == Architecture::CollaborativeLock { server_bytes as f64 + 2.0 * aware } else { 0.0 };
    let end = End {
        done: hands().all(|hand| hand.doing == TaskState::Done),
        // Of one hand at the body, whoever's is the larger: nobody else pushes.
        spectral_radius: verdict(&scene)?.spectral_radius,
        contact_n_per_m: [scene.peer.contact.stiffness_n_per_m; 2],
        bytes: [user_bytes as f64 + 2.0 * aware, served],
    };
    Ok(account.row(architecture, delay_ms, end))
}
