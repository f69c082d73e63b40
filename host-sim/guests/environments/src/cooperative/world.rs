//! A cooperative environment at work: clients, a server that may hand the engine to a client, and the network between them.
//!
//! Order of tick n: the server says what it has to say, clients take in what came, every contact force, clients say theirs,
//! the server takes in what came, whoever has the engine moves the object. So without delay a force acts in its own tick.
//! While a client has the engine, the server passes pushes on to it and its states on to the others.

use cohold_core::{contact::Contact, num::Motion};
use cohold_protocol::wire::{Moved, PeerId, Push};
use cohold_sim::engine::{self, Actor, Clock, Out};
use cohold_sim::network::link::{Inbox, Numbered, Route};
use cohold_sim::network::rule::Direction;

use super::bounder::Bounder;
use super::client::Client;
use super::engine::{DynamicsEngine, Pushed};
use super::packet::{Down, Packet, Up, body, motion, peer};
use super::{Collision, MOST_USERS, Setup, bounder};
use crate::Error;
use crate::roles::cooperative::{Lease, Message, Notice};
use crate::roles::{Role, cooperative as role};

/// How long a client may keep the engine without a word, µs: longer than any round trip here.
const LEASE_US: u32 = 2_000_000;

/// The settings that both ends share.
#[derive(Clone)]
struct Rules {
    users: usize,
    collision: Collision,
    bounder: Option<Bounder<f64>>,
    period_s: f64,
    period_ns: u64,
    ticks_per_packet: u64,
}

impl Rules {
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

    /// The tick that a clock here shows.
    fn tick(&self, now_ns: u64) -> u64 {
        now_ns / self.period_ns
    }

    fn is_due(&self, now_ns: u64) -> bool {
        self.tick(now_ns).is_multiple_of(self.ticks_per_packet)
    }

    /// Sends what a packet period brings.
    fn send(&self, now_ns: u64, to: usize, what: Packet, out: &mut Sends<'_>) {
        out(to, &Numbered::new(self.tick(now_ns) / self.ticks_per_packet, what));
    }
}

type Sends<'a> = Out<'a, usize, Numbered<Packet>>;

/// The clock of everybody: it never shows 0.
const CLOCK: Clock = Clock { start_ns: 1_000, rate: 1.0 };

/// Who sits at the engine: clients, and last the server.
#[expect(clippy::large_enum_variant, reason = "at most seventeen of them")]
enum Participant {
    Client(Seat),
    Server(Server),
}

/// One client and what it plays in the hand-over.
struct Seat {
    rules: Rules,
    index: usize,
    client: Client,
    role: role::Client,
    inbox: Inbox<Packet>,
    /// The object, while the engine is here.
    engine: DynamicsEngine,
    force_n: f64,
    /// The force that the server computed last, where it computes contact.
    received_n: f64,
    bytes: u64,
}

impl Seat {
    fn hears(&mut self, now_us: u64, down: Down) {
        let pushed: [Option<Pushed>; MOST_USERS] =
            down.pushes.map_or([None; MOST_USERS], |all| all.map(|push| Some(self.rules.pushed(&push?, now_us))));
        if let Some(state) = down.state {
            self.client.tell(state.version, motion(state.axes));
            if state.echo_us > 0 {
                // A clock that is not believed is one that has nothing to say.
                let _ = self.client.clock.sample(state.echo_us, state.came_us, state.sent_us, now_us);
            }
        }
        self.received_n = down.force_n.unwrap_or(self.received_n);
        for (user, pushed) in self.engine.users.iter_mut().zip(pushed) {
            // A push that comes again is the one that stands.
            *user = pushed.filter(|new| new.sent_us > user.sent_us).unwrap_or(*user);
        }
        if let Some(message) = down.say {
            self.role.receive(now_us, PeerId(0), &message, &mut |_, _| ());
        }
        match self.role.take_notice() {
            Some(Notice::Came(body)) => self.engine.take_over(motion(body.axes)),
            Some(Notice::Recalled) => self.role.give_back(now_us, body(self.engine.object)),
            None => {}
        }
    }

    fn says(&mut self, now_us: u64) -> Up {
        let [device, ..] = self.client.plant.motions();
        let round_trip_us = self.client.round_trip_s().map_or(u32::MAX, |round_trip_s| (1e6 * round_trip_s) as u32);
        let (force, hand) = ([self.force_n as f32, 0.0], [device.position as f32, 0.0]);
        let states = self
            .role
            .engine(now_us)
            .map(|version| self.engine.users.map(|user| moved(self.engine.object, version, user, now_us)));
        let sensed = (self.rules.collision == Collision::Server).then_some((device, self.client.bound));
        let push = Push { round_trip_us, sent_us: now_us, force, hand };
        let mut say = None;
        self.role.poll(now_us, &mut |_, message| say = Some(message));
        Up { push, sensed, states, say }
    }

    fn act(&mut self, now_ns: u64, out: &mut Sends<'_>) {
        let (now_us, due) = (now_ns / 1_000, self.rules.is_due(now_ns));
        if due && let Some(&Packet::Down(down)) = self.inbox.take(now_ns) {
            self.hears(now_us, down);
        }
        let version = self.role.engine(now_us);
        if let Some(version) = version {
            self.client.tell(version, self.engine.object);
        }
        self.client.follow(version.is_some());
        let [device, ..] = self.client.plant.motions();
        self.force_n = match self.rules.collision {
            _ if self.client.fault.is_some() => 0.0,
            Collision::Client => self.client.contact_n(device, self.client.view()),
            Collision::Server => self.received_n,
        };
        if due {
            let up = self.says(now_us);
            self.bytes += up.bytes(self.rules.users) as u64;
            self.rules.send(now_ns, self.rules.users, Packet::Up(up), out);
        }
        if version.is_some() {
            let drag_n_s_per_m = self.client.bound.drag;
            self.engine.users[self.index] = Pushed { force_n: self.force_n, drag_n_s_per_m, sent_us: 0, came_us: 0 };
            self.engine.step();
        }
        self.client.step(self.rules.period_s * self.rules.tick(now_ns) as f64, self.force_n);
    }
}

/// A state as it is sent to a user.
fn moved(at: Motion<f64>, version: u32, user: Pushed, now_us: u64) -> Moved {
    Moved {
        version,
        axes: [[at.position as f32, at.velocity as f32], [0.0; 2]],
        echo_us: user.sent_us,
        came_us: user.came_us,
        sent_us: now_us,
    }
}

/// What the server knows of a client.
struct User {
    inbox: Inbox<Packet>,
    /// The newest of this client.
    up: Option<Up>,
    /// The newest state that the engine's holder sent this client.
    passed_on: Option<Moved>,
    /// What the server has to answer.
    answer: Option<Message>,
}

struct Server {
    rules: Rules,
    role: role::Server,
    engine: DynamicsEngine,
    contacts: [Contact<f64>; 2],
    users: Vec<User>,
    bytes: u64,
}

impl Server {
    fn speak(&mut self, now_ns: u64, out: &mut Sends<'_>) {
        let now_us = now_ns / 1_000;
        let mut recalled = None;
        self.role.poll(now_us, &mut |to, message| recalled = Some((to, message)));
        if let Some(body) = self.role.take_notice() {
            self.engine.take_over(motion(body.axes));
        }
        let (here, lent_to, version) = (self.role.has_engine(), self.role.lent_to(), self.role.version());
        let pushes: [Option<Push>; MOST_USERS] = core::array::from_fn(|other| Some(self.users.get(other)?.up?.push));
        for (index, user) in self.users.iter_mut().enumerate() {
            let pushed = self.engine.users[index];
            let mut others = pushes;
            others[index] = None;
            let holds = lent_to == Some(peer(index));
            let say = recalled.filter(|(to, _)| *to == peer(index)).map(|(_, message)| message);
            let own = here.then(|| moved(self.engine.object, version, pushed, now_us));
            let down = Down {
                state: own.or_else(|| user.passed_on.take()),
                force_n: (self.rules.collision == Collision::Server).then_some(pushed.force_n),
                pushes: holds.then_some(others),
                say: user.answer.take().or(say),
            };
            self.bytes += down.bytes() as u64;
            self.rules.send(now_ns, index, Packet::Down(down), out);
        }
    }

    fn hears(&mut self, index: usize, now_us: u64, up: Up) {
        self.engine.users[index] = self.rules.pushed(&up.push, now_us);
        self.users[index].up = Some(up);
        if let Some(states) = up.states {
            self.role.take_state(peer(index), states[0].version, body(motion(states[0].axes)));
            for (other, (user, state)) in self.users.iter_mut().zip(states).enumerate() {
                user.passed_on = (other != index).then_some(state);
            }
        }
        if let Some(message) = up.say {
            self.role.moves(body(self.engine.object));
            let answer = &mut self.users[index].answer;
            self.role.receive(now_us, peer(index), &message, &mut |_, message| *answer = Some(message));
            if let Some(body) = self.role.take_notice() {
                self.engine.take_over(motion(body.axes));
            }
        }
    }

    fn act(&mut self, now_ns: u64) {
        if self.rules.is_due(now_ns) {
            for index in 0..self.users.len() {
                if let Some(&Packet::Up(up)) = self.users[index].inbox.take(now_ns) {
                    self.hears(index, now_ns / 1_000, up);
                }
            }
        }
        if self.rules.collision == Collision::Server {
            for (index, user) in self.users.iter().enumerate() {
                if let Some((device, bound)) = user.up.and_then(|up| up.sensed) {
                    let contact = self.contacts[index % 2].with_gains(bound.stiffness, bound.damping);
                    self.engine.users[index].force_n = contact.force(device, self.engine.object);
                }
            }
        }
        if self.role.has_engine() {
            self.engine.step();
        }
    }
}

impl Actor<usize> for Participant {
    type Packet = Numbered<Packet>;

    fn hear(&mut self, now_ns: u64, from: usize, packet: &mut Numbered<Packet>, _: &mut Sends<'_>) {
        match self {
            Self::Client(seat) => seat.inbox.put(now_ns, *packet),
            Self::Server(server) => server.users[from].inbox.put(now_ns, *packet),
        }
    }

    fn speak(&mut self, now_ns: u64, out: &mut Sends<'_>) {
        if let Self::Server(server) = self
            && server.rules.is_due(now_ns)
        {
            server.speak(now_ns, out);
        }
    }

    fn act(&mut self, now_ns: u64, out: &mut Sends<'_>) {
        match self {
            Self::Client(seat) => seat.act(now_ns, out),
            Self::Server(server) => server.act(now_ns),
        }
    }
}

/// A cooperative environment at work.
pub struct World {
    engine: engine::Engine<Participant>,
    /// The object as it was last moved, by whom ever.
    moved: Motion<f64>,
}

impl World {
    /// Everybody at rest, the engine at the server.
    ///
    /// # Errors
    /// A setup that cannot be built.
    pub fn new(setup: &Setup) -> Result<Self, Error> {
        let users = setup.users;
        if !(1..=MOST_USERS).contains(&users) {
            return Err(Error::Users(users));
        }
        if setup.collision == Collision::Server && setup.engine != super::Engine::Server {
            return Err(Error::NoContact);
        }
        let scene = &setup.scene;
        let settings = scene.peers();
        settings[0].check()?;
        let timing = &settings[0].timing;
        let rules = Rules {
            users,
            collision: setup.collision,
            bounder: setup.bounder.then(|| bounder(scene)),
            period_s: timing.control_period_s,
            period_ns: timing.control_period_ns(),
            ticks_per_packet: u64::from(timing.ticks_per_packet),
        };
        let lease = Lease::new(LEASE_US)?;
        let engine = DynamicsEngine::new(&settings[0]);
        let client = |index: usize| Seat {
            rules: rules.clone(),
            index,
            client: Client::new(scene, &settings[index % 2], index, setup.bounder),
            role: role::Client::new(PeerId(0), lease),
            inbox: Inbox::new(scene, scene.peer.timing.ticks_per_packet),
            engine: engine.clone(),
            force_n: 0.0,
            received_n: 0.0,
            bytes: 0,
        };
        let user = |_| User {
            inbox: Inbox::new(scene, scene.peer.timing.ticks_per_packet),
            up: None,
            passed_on: None,
            answer: None,
        };
        let server = Server {
            rules: rules.clone(),
            role: role::Server::new(lease),
            engine: engine.clone(),
            contacts: [0, 1].map(|side: usize| Contact::build(&settings[side])),
            users: (0..users).map(user).collect(),
            bytes: 0,
        };
        let peers = (0..users).map(|index| Participant::Client(client(index))).chain([Participant::Server(server)]);
        let seats = peers.map(|peer| engine::Seat { clock: CLOCK, ..engine::Seat::new(peer) }).collect();
        let route = |from: usize, to: usize| match from == users {
            true => Route::of_scene(scene, Direction::TwoToOne, to as u32),
            false => Route::of_scene(scene, Direction::OneToTwo, from as u32),
        };
        Ok(Self { engine: engine::Engine::new(rules.period_ns, seats, route), moved: engine.object })
    }

    fn seats(&self) -> impl Iterator<Item = &Seat> {
        self.engine.seats.iter().filter_map(|seat| match &seat.actor {
            Participant::Client(seat) => Some(seat),
            Participant::Server(_) => None,
        })
    }

    fn server(&self) -> Option<&Server> {
        self.engine.seats.iter().find_map(|seat| match &seat.actor {
            Participant::Server(server) => Some(server),
            Participant::Client(_) => None,
        })
    }

    /// The clients, one for each user.
    pub fn clients(&self) -> impl Iterator<Item = &Client> {
        self.seats().map(|seat| &seat.client)
    }

    /// Contact force of every client on the object at the last tick, N.
    pub fn forces(&self) -> impl Iterator<Item = f64> {
        self.seats().map(|seat| seat.force_n)
    }

    /// Bytes that all clients have sent, and that the server has, sealed.
    pub fn bytes(&self) -> [u64; 2] {
        [self.seats().map(|seat| seat.bytes).sum(), self.server().map_or(0, |server| server.bytes)]
    }

    /// Who has the engine: 0 the server, 1… a client; nobody while it is on its way.
    pub fn holders(&self) -> Vec<usize> {
        let now = self.now_us();
        let clients = self.seats().filter(|seat| seat.role.engine(now).is_some());
        let server = self.server().filter(|server| server.role.has_engine()).map(|_| 0);
        server.into_iter().chain(clients.map(|seat| seat.index + 1)).collect()
    }

    /// The object where it is moved, or was last.
    pub fn object(&self) -> Motion<f64> {
        self.moved
    }

    /// The first client asks for the engine.
    pub fn ask(&mut self) {
        let now = self.now_us();
        if let Some(engine::Seat { actor: Participant::Client(seat), .. }) = self.engine.seats.first_mut() {
            seat.role.ask(now);
        }
    }

    /// The server asks for it back.
    pub fn recall(&mut self) {
        let now = self.now_us();
        if let Some(engine::Seat { actor: Participant::Server(server), .. }) = self.engine.seats.last_mut() {
            server.role.recall(now);
        }
    }

    /// Time on every clock, µs.
    fn now_us(&self) -> u64 {
        CLOCK.at(self.engine.now_ns()) / 1_000
    }

    /// Steps server, clients and network by one tick.
    pub fn step(&mut self) {
        let now_us = self.now_us();
        self.engine.step(&mut |_| ());
        let here = self.server().filter(|server| server.role.has_engine()).map(|server| server.engine.object);
        let there =
            self.seats().filter(|seat| seat.role.engine(now_us).is_some()).map(|seat| seat.engine.object).last();
        self.moved = there.or(here).unwrap_or(self.moved);
    }
}
