//! One user at a time: the lock and the token ring of the protocol, carried by a line that only delays.
//!
//! Who owns the body moves its copy; the other's copy is the last one that was released. Hands are a device and an arm on one
//! spring ([`Linear`]): who waits reaches, open, for the body as it sees it, and grips when it owns the body and has come to
//! rest at it ([`GRIP_M`], [`GRIP_M_PER_S`]), so that how it grips does not depend on when the right comes; who carries reaches its share of the way and releases when it has rested for [`REST_S`].

use haptic_core::list::Model;
use haptic_core::motion::Motion;
use haptic_core::object::{AnyIntegrator, AnyIntegratorState, Integrator};
use haptic_core::render::Contact;
use haptic_protocol::roles::Outbox;
use haptic_protocol::roles::collaborative::ring::{Config, Record, Ring, Roster};
use haptic_protocol::roles::collaborative::{Lease, Value, lock, ring};
use haptic_protocol::wire::{Event, PeerId};

use super::account::{Account, End, event_bytes, presence_bytes_per_s};
use super::{Architecture, ArchitectureError, Row, TASK, scene};
use crate::analysis::verdict;
use crate::network::in_flight::InFlight;
use crate::network::mesh::Letter;
use crate::plant::Linear;
use crate::scene::SceneFile;
use crate::user::minimum_jerk;

/// A hand this close to the body grips it, m: at 1000 N/m with two tenths of a newton.
pub const GRIP_M: f64 = 2e-4;

/// If it is no faster than this, m/s.
pub const GRIP_M_PER_S: f64 = 0.02;

/// How long half of the way takes, and the way to the body, s.
const HALF_REACH_S: f64 = 0.5 * TASK.reach_s;

/// How long who carries rests before it lets go, s.
pub const REST_S: f64 = 0.8;

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

/// What a user has to do with the body.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Doing {
    /// Wants it.
    Waits,
    /// Carries it since this time, s.
    Carries(f64),
    /// Has let go.
    Done,
}

/// Where an arm wants its hand: on the way from one place to another.
#[derive(Clone, Copy)]
struct Reach {
    since_s: f64,
    from_m: f64,
    to_m: f64,
}

impl Reach {
    /// Place (m) and speed (m/s) that are wanted.
    fn at(self, time_s: f64) -> (f64, f64) {
        let (way, speed) = minimum_jerk(self.to_m - self.from_m, HALF_REACH_S, time_s - self.since_s);
        (self.from_m + way, speed)
    }

    /// From where it has come by now to another place.
    fn turn(&mut self, time_s: f64, to_m: f64) {
        *self = Self { since_s: time_s, from_m: self.at(time_s).0, to_m };
    }
}

/// A user with its device and its copy.
struct Hand {
    plant: Linear,
    stiffness: f64,
    damping: f64,
    device: Motion<f64>,
    reach: Reach,
    body: Motion<f64>,
    contact: Contact<f64>,
    integrator: AnyIntegrator<f64>,
    state: AnyIntegratorState<f64>,
    doing: Doing,
    goal: f64,
    /// The official copy as last seen, m: what one has released stands until there is news.
    known: f64,
    /// Force on the body, N; the device feels its reaction a tick late, as far as the scene says.
    force: f64,
}

impl Hand {
    fn new(scene: &SceneFile, index: usize, goal: f64) -> Self {
        let settings = &scene.peers()[index];
        let (device, period_s) = (&scene.world.device, settings.timing.control_period_s);
        let (stiffness, damping) = (TASK.arm_stiffness_n_per_m[index], TASK.arm_damping_n_s_per_m[index]);
        let mass = device.mass_kg + TASK.arm_mass_kg;
        let integrator = AnyIntegrator::build(settings);
        Self {
            plant: Linear::new(mass, device.damping_n_s_per_m + damping, stiffness, device.force_delay_ticks, period_s),
            stiffness,
            damping,
            device: Motion::REST,
            reach: Reach { since_s: 0.0, from_m: 0.0, to_m: 0.0 },
            body: Motion::REST,
            contact: Contact::build(settings),
            state: integrator.initial(),
            integrator,
            doing: Doing::Waits,
            goal,
            known: 0.0,
            force: 0.0,
        }
    }

    /// Whether the hand rests at a place, m.
    fn is_at(&self, place: f64) -> bool {
        (self.device.position - place).abs() < GRIP_M && self.device.velocity.abs() < GRIP_M_PER_S
    }

    /// One tick; true when the user lets go.
    fn step(&mut self, time_s: f64, owns: bool, official: f64) -> bool {
        let mut lets_go = false;
        match self.doing {
            Doing::Waits if owns && self.is_at(official) => {
                self.body = Motion::at(official);
                self.doing = Doing::Carries(time_s);
                self.reach.turn(time_s, self.goal);
            }
            // Whoever has lost the right has to wait again.
            Doing::Carries(_) if !owns => {
                self.body = Motion::at(official);
                self.doing = Doing::Waits;
                self.reach.turn(time_s, official);
            }
            Doing::Carries(since) if time_s - since > HALF_REACH_S + REST_S => {
                self.doing = Doing::Done;
                self.body.velocity = 0.0;
                lets_go = true;
            }
            _ => {}
        }
        if official != self.known {
            self.known = official;
            if !matches!(self.doing, Doing::Carries(_)) {
                self.body = Motion::at(official);
                self.reach.turn(time_s, official);
            }
        }
        let (wanted, speed) = self.reach.at(time_s);
        let (pull, felt) = (self.stiffness * wanted + self.damping * speed, self.force);
        self.force = 0.0;
        if matches!(self.doing, Doing::Carries(_)) {
            self.force = self.contact.force(self.device, self.body);
            self.body = self.integrator.step(&mut self.state, self.body, self.force);
        }
        self.device = self.plant.advance(self.device, pull - felt, pull - self.force);
        lets_go
    }
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
                flying.send(now + delay_us, Letter { from, to: usize::from(to.0), event });
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
