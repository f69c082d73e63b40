//! Server, clients and the network between them, one tick after the other.
//!
//! Order of tick n: the server says what it has to say, clients take in what came, every contact force, clients say theirs,
//! the server takes in what came, whoever has the engine moves the object. So without delay a force acts in its own tick.
//! While a client has the engine, the server passes pushes on to it and its states on to the others.

use haptic_core::contact::Contact;
use haptic_core::contact::bounder::{Bound, Bounder};
use haptic_core::num::Motion;
use haptic_core::settings::Refused;
use haptic_protocol::roles::Role;
use haptic_protocol::roles::cooperative as role;
use haptic_protocol::roles::cooperative::{Lease, Message, Notice, OutOfRange};
use haptic_protocol::wire::{Moved, PeerId, Push};

use super::client::Client;
use super::engine::{DynamicsEngine, Pushed};
use super::packet::{Down, Up, body, object, peer};
use super::{Collision, MOST_USERS, Setup};
use haptic_sim::network::Way;
use haptic_sim::network::rule::Direction;

/// How long a client may keep the engine without a word, µs: longer than any round trip here.
pub const LEASE_US: u32 = 2_000_000;

/// One client with its lines and what it plays in the hand-over.
struct Seat {
    client: Client,
    role: role::Client,
    up: Way<Up>,
    down: Way<Down>,
    /// The object, while the engine is here.
    engine: DynamicsEngine,
    force_n: f64,
    /// The force that the server computed last, where it computes contact.
    received_n: f64,
    /// The newest of this client at the server.
    push: Option<Push>,
    sensed: Option<(Motion<f64>, Bound<f64>)>,
    /// What the holder last told this client.
    passed_on: Option<Moved>,
    /// What the server has to answer.
    answer: Option<Message>,
}

/// A cooperative environment at work.
pub struct World {
    seats: Vec<Seat>,
    server: role::Server,
    engine: DynamicsEngine,
    /// The object as it was last moved, by whom ever.
    moved: Motion<f64>,
    contacts: [Contact<f64>; 2],
    bounder: Option<Bounder<f64>>,
    collision: Collision,
    period_s: f64,
    ticks_per_packet: u64,
    tick: u64,
    bytes: [u64; 2],
}

/// Why a world cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// Too few or too many users.
    #[error("users = {0} is not allowed: it must be a whole number from 1 to {MOST_USERS}")]
    Users(usize),
    /// What the peers refuse.
    #[error(transparent)]
    Refused(#[from] Refused<'static>),
    /// What the hand-over refuses.
    #[error(transparent)]
    Lease(#[from] OutOfRange),
    /// The engine cannot move to a client that computes no contact.
    #[error(
        "the engine must be at the server where contact is computed there: a client that computes no contact cannot move the object"
    )]
    NoContact,
    /// The node is lossless only for waves that come when they are due.
    #[error(
        "network: through the node every wave must arrive, after a constant delay: leave jitter, loss and all else at 0, or \
         set coordination.ledger = true, which pays for waves that are held"
    )]
    NotConstant,
    /// There are no waves to scatter.
    #[error(transparent)]
    NoWaves(#[from] super::junction::NoWaves),
}

impl World {
    /// Everybody at rest, the engine at the server.
    ///
    /// # Errors
    /// Users out of range; what the peers' settings refuse.
    pub fn new(setup: &Setup) -> Result<Self, WorldError> {
        if !(1..=MOST_USERS).contains(&setup.users) {
            return Err(WorldError::Users(setup.users));
        }
        if setup.collision == Collision::Server && setup.engine != super::Engine::Server {
            return Err(WorldError::NoContact);
        }
        let scene = &setup.scene;
        let settings = scene.peers();
        settings[0].check()?;
        let (contact, period_s) = (&settings[0].contact, settings[0].timing.control_period_s);
        let lease = Lease::new(LEASE_US)?;
        let engine = DynamicsEngine::new(&settings[0]);
        let seats = (0..setup.users).map(|index| Seat {
            client: Client::new(scene, &settings[index % 2], index, setup.bounder),
            role: role::Client::new(PeerId(0), lease),
            up: Way::new(scene, Direction::OneToTwo, index as u32),
            down: Way::new(scene, Direction::TwoToOne, index as u32),
            engine: engine.clone(),
            force_n: 0.0,
            received_n: 0.0,
            push: None,
            sensed: None,
            passed_on: None,
            answer: None,
        });
        let damping = scene.world.device.damping_n_s_per_m;
        let bounder = Bounder::new(contact.stiffness_n_per_m, contact.damping_n_s_per_m, damping, period_s);
        Ok(Self {
            seats: seats.collect(),
            server: role::Server::new(lease),
            contacts: [0, 1].map(|side: usize| Contact::build(&settings[side])),
            moved: engine.object,
            engine,
            bounder: setup.bounder.then_some(bounder),
            collision: setup.collision,
            period_s,
            ticks_per_packet: u64::from(settings[0].timing.ticks_per_packet),
            tick: 0,
            bytes: [0; 2],
        })
    }

    /// Ticks done.
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// The clients.
    pub fn clients(&self) -> impl Iterator<Item = &Client> {
        self.seats.iter().map(|seat| &seat.client)
    }

    /// Contact force of every client on the object at the last tick, N.
    pub fn forces(&self) -> impl Iterator<Item = f64> {
        self.seats.iter().map(|seat| seat.force_n)
    }

    /// Bytes that all clients have sent, and that the server has, sealed.
    pub fn bytes(&self) -> [u64; 2] {
        self.bytes
    }

    /// Who has the engine: 0 the server, 1… a client; nobody while it is on its way.
    pub fn holders(&self) -> Vec<usize> {
        let now = self.now_us();
        let clients = self.seats.iter().enumerate().filter(|(_, seat)| seat.role.engine(now).is_some());
        let server = self.server.has_engine().then_some(0);
        server.into_iter().chain(clients.map(|(index, _)| index + 1)).collect()
    }

    /// The object where it is moved, or was last.
    pub fn object(&self) -> Motion<f64> {
        self.moved
    }

    /// The first client asks for the engine.
    pub fn ask(&mut self) {
        let now = self.now_us();
        self.seats[0].role.ask(now);
    }

    /// The server asks for it back.
    pub fn recall(&mut self) {
        self.server.recall(self.now_us());
    }

    /// Time on every clock, µs; never 0.
    fn now_us(&self) -> u64 {
        (1e6 * self.period_s * self.tick as f64) as u64 + 1
    }

    /// What a push does to an object, its drag included.
    fn pushed(&self, push: &Push, came_us: u64) -> Pushed {
        let drag = |bounder: &Bounder<f64>| bounder.bound(1e-6 * f64::from(push.round_trip_us)).drag;
        Pushed {
            force_n: f64::from(push.force[0]),
            drag_n_s_per_m: self.bounder.as_ref().map_or(0.0, drag),
            sent_us: push.sent_us,
            came_us,
        }
    }

    /// One tick.
    pub fn step(&mut self) {
        let now = self.now_us();
        let due = self.tick.is_multiple_of(self.ticks_per_packet);
        let time = (self.tick / self.ticks_per_packet) as f64;
        if due {
            self.server_says(now, time);
            for index in 0..self.seats.len() {
                self.client_hears(index, now, time);
            }
        }
        let time_s = self.period_s * self.tick as f64;
        for seat in &mut self.seats {
            let version = seat.role.engine(now);
            if let Some(version) = version {
                seat.client.tell(version, seat.engine.object);
            }
            seat.client.follow(version.is_some());
            let [device, ..] = seat.client.plant.motions();
            seat.force_n = match self.collision {
                _ if seat.client.fault.is_some() => 0.0,
                Collision::Client => seat.client.contact_n(device, seat.client.view()),
                Collision::Server => seat.received_n,
            };
        }
        if due {
            for index in 0..self.seats.len() {
                self.client_says(index, now, time);
            }
            for index in 0..self.seats.len() {
                self.server_hears(index, now, time);
            }
        }
        self.move_object(now);
        for seat in &mut self.seats {
            seat.client.step(time_s, seat.force_n);
        }
        self.tick += 1;
    }

    fn server_says(&mut self, now: u64, time: f64) {
        let mut recalled = None;
        self.server.poll(now, &mut |to, message| recalled = Some((to, message)));
        if let Some(body) = self.server.take_notice() {
            self.engine.take_over(object(body));
        }
        let (here, lent_to, version) = (self.server.has_engine(), self.server.lent_to(), self.server.version());
        let pushes: [Option<Push>; MOST_USERS] =
            core::array::from_fn(|other| self.seats.get(other).and_then(|seat| seat.push));
        for (index, seat) in self.seats.iter_mut().enumerate() {
            let at = self.engine.object;
            let user = self.engine.users[index];
            let own = Moved {
                version,
                axes: [[at.position as f32, at.velocity as f32], [0.0; 2]],
                echo_us: user.sent_us,
                came_us: user.came_us,
                sent_us: now,
            };
            let mut others = pushes;
            others[index] = None;
            let holds = lent_to == Some(peer(index));
            let say = recalled.filter(|(to, _)| *to == peer(index)).map(|(_, message)| message);
            let down = Down {
                state: if here { Some(own) } else { seat.passed_on.take() },
                force_n: (self.collision == Collision::Server).then_some(user.force_n),
                pushes: holds.then_some(others),
                say: seat.answer.take().or(say),
            };
            self.bytes[1] += down.bytes() as u64;
            seat.down.send(time, down);
        }
    }

    fn client_hears(&mut self, index: usize, now: u64, time: f64) {
        let Some(down) = self.seats[index].down.take(time) else { return };
        let pushed: [Option<Pushed>; MOST_USERS] =
            down.pushes.map_or([None; MOST_USERS], |all| all.map(|push| Some(self.pushed(&push?, now))));
        let seat = &mut self.seats[index];
        if let Some(state) = down.state {
            let [[position, velocity], _] = state.axes;
            seat.client.tell(state.version, Motion { position: position.into(), velocity: velocity.into() });
            if state.echo_us > 0 {
                // A clock that is not believed is one that has nothing to say.
                let _ = seat.client.clock.sample(state.echo_us, state.came_us, state.sent_us, now);
            }
        }
        seat.received_n = down.force_n.unwrap_or(seat.received_n);
        for (user, pushed) in seat.engine.users.iter_mut().zip(pushed) {
            // A push that comes again is the one that stands.
            *user = pushed.filter(|new| new.sent_us > user.sent_us).unwrap_or(*user);
        }
        if let Some(message) = down.say {
            seat.role.receive(now, PeerId(0), &message, &mut |_, _| ());
        }
        match seat.role.take_notice() {
            Some(Notice::Came(body)) => seat.engine.take_over(object(body)),
            Some(Notice::Recalled) => seat.role.give_back(now, body(seat.engine.object)),
            None => {}
        }
    }

    fn client_says(&mut self, index: usize, now: u64, time: f64) {
        let users = self.seats.len();
        let seat = &mut self.seats[index];
        let [device, ..] = seat.client.plant.motions();
        let round_trip_us = seat.client.round_trip_s().map_or(u32::MAX, |round_trip_s| (1e6 * round_trip_s) as u32);
        let push = Push {
            round_trip_us,
            sent_us: now,
            force: [seat.force_n as f32, 0.0],
            hand: [device.position as f32, 0.0],
        };
        let at = seat.engine.object;
        let states = seat.role.engine(now).map(|version| {
            seat.engine.users.map(|user| Moved {
                version,
                axes: [[at.position as f32, at.velocity as f32], [0.0; 2]],
                echo_us: user.sent_us,
                came_us: user.came_us,
                sent_us: now,
            })
        });
        let mut say = None;
        seat.role.poll(now, &mut |_, message| say = Some(message));
        let sensed = (self.collision == Collision::Server).then_some((device, seat.client.bound));
        let up = Up { push, sensed, states, say };
        self.bytes[0] += up.bytes(users) as u64;
        seat.up.send(time, up);
    }

    fn server_hears(&mut self, index: usize, now: u64, time: f64) {
        let Some(up) = self.seats[index].up.take(time) else { return };
        self.engine.users[index] = self.pushed(&up.push, now);
        self.seats[index].push = Some(up.push);
        self.seats[index].sensed = up.sensed;
        if let Some(states) = up.states {
            let [[position, velocity], _] = states[0].axes;
            let told = Motion { position: position.into(), velocity: velocity.into() };
            self.server.told(peer(index), states[0].version, body(told));
            for (other, (seat, state)) in self.seats.iter_mut().zip(states).enumerate() {
                seat.passed_on = (other != index).then_some(state);
            }
        }
        if let Some(message) = up.say {
            self.server.moves(body(self.engine.object));
            let answer = &mut self.seats[index].answer;
            self.server.receive(now, peer(index), &message, &mut |_, message| *answer = Some(message));
            if let Some(body) = self.server.take_notice() {
                self.engine.take_over(object(body));
            }
        }
    }

    /// Whoever has the engine adds the forces up and moves the object by a tick.
    fn move_object(&mut self, now: u64) {
        if self.collision == Collision::Server {
            for (index, seat) in self.seats.iter().enumerate() {
                if let Some((device, bound)) = seat.sensed {
                    let contact = self.contacts[index % 2].with_gains(bound.stiffness, bound.damping);
                    self.engine.users[index].force_n = contact.force(device, self.engine.object);
                }
            }
        }
        if self.server.has_engine() {
            self.engine.step();
            self.moved = self.engine.object;
        }
        for (index, seat) in self.seats.iter_mut().enumerate() {
            if seat.role.engine(now).is_some() {
                seat.engine.users[index] =
                    Pushed { force_n: seat.force_n, drag_n_s_per_m: seat.client.bound.drag, sent_us: 0, came_us: 0 };
                seat.engine.step();
                self.moved = seat.engine.object;
            }
        }
    }
}
