//! One user at a time: the lock and the token ring of the protocol, carried by a line that only delays.
//!
//! Who owns the body moves its copy; the other's copy is the last one that was released.

use haptic_protocol::roles::collaborative::ring::{Config, Record, Ring, Roster};
use haptic_protocol::roles::collaborative::{Lease, Value, lock, ring};
use haptic_protocol::roles::{Outbox, Role};
use haptic_protocol::wire::{Event, PeerId};

use super::account::{Account, End, event_bytes, presence_bytes_per_s};
use super::hand::{Doing, Hand};
use super::{Architecture, ArchitectureError, Row, TASK, scene};
use haptic_analysis::verdict;
use haptic_sim::network::link::InFlight;
use haptic_sim::network::mesh::Letter;

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

/// A role of one peer, whichever scheme.
trait Turn {
    fn ask(&mut self, now: u64);
    fn owns(&self, now: u64) -> bool;
    fn official(&self) -> f64;
    fn let_go(&mut self, now: u64, at: f64);
    fn hear(&mut self, now: u64, from: PeerId, event: &Event);
    /// Lets time pass; what is said, to whom.
    fn say(&mut self, now: u64) -> Vec<(PeerId, Event)>;
}

/// The body's number among the shared objects.
const OBJECT: u16 = 0;

/// The server of the lock has this number.
const SERVER: PeerId = PeerId(0);

struct LockClient {
    role: lock::Client,
    out: Outbox<lock::Message, 32>,
}

impl Turn for LockClient {
    fn ask(&mut self, now: u64) {
        self.role.ask(now);
    }
    fn owns(&self, now: u64) -> bool {
        self.role.owns(now)
    }
    fn official(&self) -> f64 {
        position(&self.role.copy().value)
    }
    fn let_go(&mut self, now: u64, at: f64) {
        // Too late is what the server says as well: the copy stays as it was.
        let _ = self.role.release(now, Some(value(at)), &mut self.out);
    }
    fn hear(&mut self, now: u64, from: PeerId, event: &Event) {
        if let Ok((_, message)) = lock::Message::parse(event) {
            self.role.receive(now, from, &message, &mut self.out);
        }
    }
    fn say(&mut self, now: u64) -> Vec<(PeerId, Event)> {
        self.role.poll(now, &mut self.out);
        self.out.events(|message| message.event(OBJECT)).collect()
    }
}

struct LockServer {
    role: lock::Server<4>,
    out: Outbox<lock::Message, 32>,
}

/// The server takes no turn itself.
impl Turn for LockServer {
    fn ask(&mut self, _: u64) {}
    fn owns(&self, _: u64) -> bool {
        false
    }
    fn official(&self) -> f64 {
        position(&self.role.copy().value)
    }
    fn let_go(&mut self, _: u64, _: f64) {}
    fn hear(&mut self, now: u64, from: PeerId, event: &Event) {
        if let Ok((_, message)) = lock::Message::parse(event) {
            self.role.receive(now, from, &message, &mut self.out);
        }
    }
    fn say(&mut self, now: u64) -> Vec<(PeerId, Event)> {
        self.role.poll(now, &mut self.out);
        self.out.events(|message| message.event(OBJECT)).collect()
    }
}

struct RingMember {
    role: Ring,
    out: Outbox<ring::Message, 64>,
}

impl Turn for RingMember {
    fn ask(&mut self, _: u64) {
        self.role.ask();
    }
    fn owns(&self, now: u64) -> bool {
        self.role.owns(now)
    }
    fn official(&self) -> f64 {
        position(&self.role.state().value)
    }
    fn let_go(&mut self, now: u64, at: f64) {
        let _ = self.role.publish(now, value(at), &mut self.out);
    }
    fn hear(&mut self, now: u64, from: PeerId, event: &Event) {
        if let Ok((_, message)) = ring::Message::parse(event) {
            self.role.receive(now, from, &message, &mut self.out);
        }
    }
    fn say(&mut self, now: u64) -> Vec<(PeerId, Event)> {
        self.role.poll(now, &mut self.out);
        self.out.events(|message| message.event(OBJECT)).collect()
    }
}

/// The peers of a scheme in the order of their numbers, which of them the two users are, and the delay of a message, µs.
type Cast = (Vec<Box<dyn Turn>>, [usize; 2], u64);

/// Who takes part, at this delay from user to user, µs.
fn cast(architecture: Architecture, delay_us: u64) -> Result<Cast, ArchitectureError> {
    let lease = Lease::new(LEASE_US)?;
    if architecture == Architecture::CollaborativeLock {
        let server = LockServer { role: lock::Server::new(lease, value(0.0)), out: Outbox::new() };
        let client = |incarnation| -> Box<dyn Turn> {
            let role = lock::Client::new(SERVER, lease, incarnation, value(0.0));
            Box::new(LockClient { role, out: Outbox::new() })
        };
        return Ok((vec![Box::new(server), client(1), client(2)], [1, 2], delay_us / 2));
    }
    let founders = Roster::of(0..2);
    let member = |seat: u8| -> Box<dyn Turn> {
        let config = Config { seat, contacts: founders, lease, turn_us: TURN_US, seed: u64::from(seat) + 1 };
        let role = Ring::new(config, 0, Record::founder(founders, value(0.0)));
        Box::new(RingMember { role, out: Outbox::new() })
    };
    Ok((vec![member(0), member(1)], [0, 1], delay_us))
}

/// One run.
///
/// # Errors
/// What the scene or the roles refuse.
pub(super) fn row(architecture: Architecture, delay_ms: f64) -> Result<Row, ArchitectureError> {
    let scene = scene(&["coordination.comm=none".to_owned()])?;
    let period_s = scene.peer.timing.control_period_s;
    let (mut peers, users, delay_us) = cast(architecture, (1e3 * delay_ms) as u64)?;
    let goals = [0.5 * TASK.goals_m[0], TASK.goals_m[1]];
    let mut hands = [0, 1].map(|index| Hand::new(&scene, index, goals[index]));
    let mut flying = InFlight::default();
    // A ring begins by finding out that nobody has a token; that is over before the task starts.
    let settled_us = 2 * u64::from(LEASE_US) + 4 * delay_us;
    let ticks = (TASK.duration_s / period_s) as u64;
    let warm_up = (settled_us as f64 * 1e-6 / period_s) as u64;
    let mut account = Account::new(ticks);
    let (mut user_bytes, mut server_bytes) = (0, 0);
    for tick in 0..warm_up + ticks {
        let now = (tick as f64 * period_s * 1e6) as u64;
        let at_work = tick >= warm_up;
        let time_s = tick.saturating_sub(warm_up) as f64 * period_s;
        while let Some((_, Letter { from, to, event })) = flying.take(now) {
            peers[to].hear(now, PeerId(from as u8), &event);
        }
        if at_work {
            for (index, hand) in hands.iter_mut().enumerate() {
                let peer = &mut peers[users[index]];
                // User 2 waits until the body is half-way.
                if hand.doing == Doing::Waits && (index == 0 || peer.official() > 0.5 * goals[0]) {
                    peer.ask(now);
                }
                if hand.step(time_s, peer.owns(now), peer.official()) {
                    peer.let_go(now, hand.body.position);
                }
            }
            let views = hands.each_ref().map(|hand| hand.body.position);
            account.see(views, hands.each_ref().map(|hand| hand.force));
        }
        for (from, peer) in peers.iter_mut().enumerate() {
            for (to, event) in peer.say(now) {
                let bytes = if at_work { event_bytes(&event) } else { 0 };
                if users.contains(&from) {
                    user_bytes += bytes
                } else {
                    server_bytes += bytes
                }
                flying.put(now + delay_us, Letter { from, to: usize::from(to.0), event });
            }
        }
    }
    let aware = presence_bytes_per_s() * TASK.duration_s;
    let served = if architecture == Architecture::CollaborativeLock { server_bytes as f64 + 2.0 * aware } else { 0.0 };
    let end = End {
        done: hands.iter().all(|hand| hand.doing == Doing::Done),
        // Of one hand at the body, whoever's is the larger: nobody else pushes.
        spectral_radius: verdict(&scene)?.spectral_radius,
        contact_n_per_m: [scene.peer.contact.stiffness_n_per_m; 2],
        bytes: [user_bytes as f64 + 2.0 * aware, served],
    };
    Ok(account.row(architecture, delay_ms, end))
}
