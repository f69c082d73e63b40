//! Two sealed peers on the recommended scene, each over a carrier, in virtual time, 1 ms a step; either may be a board, which only the PC beside it carries.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use cohold_core::safety::Mode;
use cohold_homes::Way;
use cohold_homes::bridge::Bridge;
use cohold_homes::carrier::{Carrier, Config};
use cohold_homes::place::Place;
use cohold_live::node::Node;
use cohold_protocol::key::Key;
use cohold_protocol::link::Notice;
use cohold_sim::Laws;
use cohold_sim::scene::Scene;
use cohold_sim::scenes;

/// One way by the meeting place, in two halves, and from end to end, ms.
const RELAYED_MS: u64 = 40;
const DIRECT_MS: u64 = 8;
/// Between a board and the PC beside it, ms.
const BESIDE_MS: u64 = 1;

/// One hand moves the object to and fro, the other one goes along; both push against each other, those of the cooperation paper's §5.2.
pub(crate) const LED: &[&str] = &["user.1.sine_n=2", "user.1.sine_rad_per_s=6.283"];
pub(crate) const AGAINST: &[&str] =
    &["user.1.push_n=1", "user.2.push_n=1", "user.2.sine_n=0.25", "user.2.sine_rad_per_s=3"];

/// A board's own network: its address, and that of the PC beside it.
pub(crate) fn beside(side: usize) -> [SocketAddr; 2] {
    [1, 10].map(|host| SocketAddr::from(([192, 168, 70 + side as u8, host], 7701)))
}

fn key() -> Key {
    Key::new([9; 32])
}

pub(crate) struct World {
    start: Instant,
    ms: u64,
    scene: Scene,
    meet: SocketAddr,
    at: [SocketAddr; 2],
    place: Place,
    pub(crate) nodes: [Node<1, 2>; 2],
    /// None while its program is not there.
    pub(crate) carriers: [Option<Carrier>; 2],
    /// Where an end is a board: what the PC beside it lets through.
    pub(crate) bridges: [Option<Bridge>; 2],
    under_way: Vec<(u64, SocketAddr, SocketAddr, Vec<u8>)>,
    pub(crate) cut: bool,
    /// Largest change in a tick of F_T and of what a hand feels, N, and largest distance of the copies, m, since they were last asked for.
    jumps_n: [f64; 2],
    apart_m: f64,
    /// F_T and what the hand feels at either end, N.
    forces_n: [[f64; 2]; 2],
}

impl World {
    pub(crate) fn new(boards: [bool; 2]) -> Self {
        Self::with(LED, boards)
    }

    /// With what the hands do.
    pub(crate) fn with(hands: &[&str], boards: [bool; 2]) -> Self {
        let mut scene = scenes::load(Laws::built_in(), "any-network").expect("built in");
        scene.users = Default::default();
        for key in hands.iter().chain(&["safety.max_delay_s=0.25"]) {
            scene.apply_override(key).expect("a good override");
        }
        let start = Instant::now();
        let [meet, one, two] =
            ["203.0.113.1:4000", "203.0.113.11:4001", "203.0.113.12:4001"].map(|at| at.parse().expect("an address"));
        let node = |number: u8| Node::build(&scene, number, key(), [number; 32]).expect("a peer");
        let (nodes, under_way) = ([node(1), node(2)], Vec::new());
        let (cut, jumps_n, apart_m, forces_n) = (false, [0.0; 2], 0.0, [[0.0; 2]; 2]);
        let (place, bridges) = (Place::new(&Key::new([3; 32]), start), [None, None]);
        let (at, carriers) = ([one, two], [None, None]);
        let mut world = Self {
            start,
            ms: 0,
            scene,
            meet,
            at,
            place,
            nodes,
            carriers,
            bridges,
            under_way,
            cut,
            jumps_n,
            apart_m,
            forces_n,
        };
        for (side, board) in boards.into_iter().enumerate() {
            world.begin(side, board, side as u8 + 1);
        }
        world
    }

    /// The program that has the carrier of this end begins, or begins anew: another run, of which `run` is told apart.
    pub(crate) fn begin(&mut self, side: usize, board: bool, run: u8) {
        let (now, bases) = (self.now(), vec![self.at[side]]);
        let config = Config { key: key(), side: side as u8, meet: self.meet, bases, mapped: None, relay_only: false };
        self.carriers[side] = Some(Carrier::new(config, &Key::new([run; 32]), now));
        self.bridges[side] = board.then(|| Bridge::new(beside(side)[0], now));
    }

    /// It is killed: what comes to its sockets goes nowhere.
    pub(crate) fn kill(&mut self, side: usize) {
        self.carriers[side] = None;
    }

    /// The peer, or the board, of this end starts anew.
    pub(crate) fn restart(&mut self, side: usize) {
        let number = side as u8 + 1;
        self.nodes[side] = Node::build(&self.scene, number, key(), [number + 100; 32]).expect("a peer");
        self.forces_n[side] = [0.0; 2];
    }

    fn now(&self) -> Instant {
        self.start + Duration::from_millis(self.ms)
    }

    pub(crate) fn post(&mut self, from: SocketAddr, to: SocketAddr, bytes: &[u8]) {
        let near = |at: SocketAddr| (0..2).any(|side| beside(side).contains(&at));
        let direct = from != self.meet && to != self.meet;
        let takes_ms = match () {
            () if near(from) || near(to) => BESIDE_MS,
            () if direct && self.cut => return,
            () if direct => DIRECT_MS,
            () => RELAYED_MS / 2,
        };
        self.under_way.push((self.ms + takes_ms, from, to, bytes.to_vec()));
    }

    /// What an end's carrier has for the link goes there, or to the board.
    fn hand_over(&mut self, side: usize, bytes: &mut [u8]) {
        let (now, [board, pc]) = (self.now(), beside(side));
        match self.bridges[side].as_mut().map(|bridge| bridge.hear_far(now, bytes)) {
            None => _ = self.nodes[side].receive(1000 * self.ms, bytes),
            Some(true) => self.post(pc, board, bytes),
            Some(false) => {}
        }
    }

    /// Gives a carrier its turn, and what it then says to the network.
    fn carry(&mut self, side: usize, turn: impl FnOnce(&mut Carrier, Instant, &mut cohold_homes::Send<'_>)) {
        let (now, mut sent) = (self.now(), Vec::new());
        if let Some(carrier) = &mut self.carriers[side] {
            turn(carrier, now, &mut |to, bytes: &[u8]| sent.push((to, bytes.to_vec())));
        }
        let from = self.at[side];
        sent.into_iter().for_each(|(to, bytes)| self.post(from, to, &bytes));
    }

    fn arrive(&mut self, from: SocketAddr, to: SocketAddr, mut bytes: Vec<u8>) {
        let now = self.now();
        if to == self.meet {
            let mut sent = Vec::new();
            self.place.hear(now, from, &bytes, &mut |to, bytes: &[u8]| sent.push((to, bytes.to_vec())));
            sent.into_iter().for_each(|(next, bytes)| self.post(to, next, &bytes));
            return;
        }
        for side in 0..2 {
            let [board, pc] = beside(side);
            if to == self.at[side] {
                let mut is_flow = false;
                self.carry(side, |carrier, now, send| is_flow = carrier.hear(now, from, &bytes, send));
                if is_flow {
                    self.hand_over(side, &mut bytes);
                }
            } else if to == board {
                let _ = self.nodes[side].receive(1000 * self.ms, &mut bytes);
            } else if to == pc && self.carriers[side].is_some() {
                let passes = self.bridges[side].as_mut().is_some_and(|bridge| bridge.hear_board(now, from, &bytes));
                if passes {
                    self.carry(side, |carrier, now, send| _ = carrier.send(now, &bytes, send));
                }
            }
        }
    }

    fn step(&mut self) {
        self.ms += 1;
        let (come, wait) = std::mem::take(&mut self.under_way).into_iter().partition(|(at, ..)| *at <= self.ms);
        self.under_way = wait;
        for (_, from, to, bytes) in come as Vec<(u64, SocketAddr, SocketAddr, Vec<u8>)> {
            self.arrive(from, to, bytes);
        }
        let now = self.now();
        for side in 0..2 {
            let _ = self.bridges[side].as_mut().and_then(|bridge| bridge.look(now));
            while let Some(mut bytes) = self.carriers[side].as_mut().and_then(|carrier| carrier.release(now)) {
                self.hand_over(side, &mut bytes);
            }
            let mut said: Vec<Vec<u8>> = Vec::new();
            self.nodes[side].tick(1000 * self.ms, |bytes| said.push(bytes.to_vec()));
            let ([board, pc], is_board) = (beside(side), self.bridges[side].is_some());
            self.carry(side, |carrier, now, send| {
                carrier.poll(now, send);
                let own = said.iter().filter(|_| !is_board);
                own.for_each(|bytes| _ = carrier.send(now, bytes, send));
            });
            said.iter().filter(|_| is_board).for_each(|bytes| self.post(board, pc, bytes));
            let seen = self.nodes[side].observed();
            let forces_n = [seen.coordination_force, seen.contact_force].map(f64::from);
            let before_n = std::mem::replace(&mut self.forces_n[side], forces_n);
            for (jump_n, (now_n, before_n)) in self.jumps_n.iter_mut().zip(forces_n.into_iter().zip(before_n)) {
                *jump_n = jump_n.max((now_n - before_n).abs());
            }
        }
        let [one, two] = self.nodes.each_ref().map(|node| f64::from(node.observed().object.position));
        self.apart_m = self.apart_m.max((one - two).abs());
    }

    /// Goes on for so long; the largest change in a tick of F_T and of what a hand feels, N, and distance of the copies, m.
    pub(crate) fn run(&mut self, ms: u64) -> [f64; 3] {
        (self.jumps_n, self.apart_m) = ([0.0; 2], 0.0);
        (0..ms).for_each(|_| self.step());
        let [force_n, hand_n] = self.jumps_n;
        [force_n, hand_n, self.apart_m]
    }

    pub(crate) fn ways(&self) -> [Way; 2] {
        self.carriers.each_ref().map(|carrier| carrier.as_ref().map_or(Way::Nowhere, Carrier::way))
    }

    pub(crate) fn are_together(&self) -> bool {
        self.nodes.iter().all(|node| node.peer.mode() == Mode::Armed && node.peer.is_engaged())
    }

    /// Whether either end has let go of the other one at any time.
    pub(crate) fn have_parted(&self) -> bool {
        let lost = |notice: &Notice| matches!(notice, Notice::Lost | Notice::Disengaged);
        self.nodes.iter().any(|node| node.line.notices.iter().any(|(_, notice)| lost(notice)))
    }
}
