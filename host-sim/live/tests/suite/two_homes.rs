//! Two sealed peers on the recommended scene, each over a carrier, in virtual time: the line's round trip falls from 80 ms to 16 ms and rises again. What hands feel of it is bounded, and nothing ends.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use haptic_core::safety::Mode;
use haptic_meeting::Way;
use haptic_meeting::carrier::{Carrier, Config};
use haptic_meeting::place::Place;
use haptic_protocol::key::Key;
use haptic_protocol::link::Notice;
use haptic_sim::Laws;
use haptic_sim::node::Node;
use haptic_sim::scenes;

/// One way by the meeting place, in two halves, and from end to end, ms.
const RELAYED_MS: u64 = 40;
const DIRECT_MS: u64 = 8;

/// One hand moves the object to and fro, the other goes along; both push against each other, those of the cooperation paper's §5.2.
const LED: &[&str] = &["user.1.sine_n=2", "user.1.sine_rad_per_s=6.283"];
const AGAINST: &[&str] = &["user.1.push_n=1", "user.2.push_n=1", "user.2.sine_n=0.25", "user.2.sine_rad_per_s=3"];

struct World {
    start: Instant,
    ms: u64,
    meet: SocketAddr,
    at: [SocketAddr; 2],
    place: Place,
    nodes: [Node<1, 2>; 2],
    carriers: [Carrier; 2],
    under_way: Vec<(u64, SocketAddr, SocketAddr, Vec<u8>)>,
    cut: bool,
    /// Largest change of F_T in a tick, N, and largest distance of the copies, m, since they were last asked for.
    jump_n: f64,
    apart_m: f64,
    force_n: [f64; 2],
}

impl World {
    fn new(hands: &[&str]) -> Self {
        let mut scene = scenes::load(Laws::built_in(), "any-network").expect("built in");
        for key in hands.iter().chain(&["safety.max_delay_s=0.25"]) {
            scene.apply_override(key).expect("a good override");
        }
        let (start, key) = (Instant::now(), Key::new([9; 32]));
        let [meet, one, two] =
            ["203.0.113.1:4000", "203.0.113.11:4001", "203.0.113.12:4001"].map(|at| at.parse().expect("an address"));
        let carrier = |side: u8, base| {
            let config = Config { key: key.clone(), side, meet, bases: vec![base], mapped: None, relay_only: false };
            Carrier::new(config, &Key::new([side + 1; 32]), start)
        };
        let node = |number: u8| Node::build(&scene, number, key.clone(), [number; 32]).expect("a peer");
        let (nodes, carriers) = ([node(1), node(2)], [carrier(0, one), carrier(1, two)]);
        let place = Place::new(&Key::new([3; 32]), start);
        let under_way = Vec::new();
        let (cut, jump_n, apart_m, force_n) = (false, 0.0, 0.0, [0.0; 2]);
        Self { start, ms: 0, meet, at: [one, two], place, nodes, carriers, under_way, cut, jump_n, apart_m, force_n }
    }

    fn post(&mut self, from: SocketAddr, to: SocketAddr, bytes: &[u8]) {
        let direct = from != self.meet && to != self.meet;
        if !(direct && self.cut) {
            let takes_ms = if direct { DIRECT_MS } else { RELAYED_MS / 2 };
            self.under_way.push((self.ms + takes_ms, from, to, bytes.to_vec()));
        }
    }

    fn step(&mut self) {
        self.ms += 1;
        let (now, now_us) = (self.start + Duration::from_millis(self.ms), 1000 * self.ms);
        let (come, wait) = std::mem::take(&mut self.under_way).into_iter().partition(|(at, ..)| *at <= self.ms);
        self.under_way = wait;
        for (_, from, to, mut bytes) in come as Vec<(u64, SocketAddr, SocketAddr, Vec<u8>)> {
            let mut sent = Vec::new();
            let mut send = |to, bytes: &[u8]| sent.push((to, bytes.to_vec()));
            if to == self.meet {
                self.place.hear(now, from, &bytes, &mut send);
            } else {
                let side = usize::from(to == self.at[1]);
                if self.carriers[side].hear(now, from, &bytes, &mut send) {
                    let _ = self.nodes[side].receive(now_us, &mut bytes);
                }
            }
            sent.into_iter().for_each(|(next, bytes)| self.post(to, next, &bytes));
        }
        for side in 0..2 {
            let (mut sent, carrier) = (Vec::new(), &mut self.carriers[side]);
            let mut send = |to, bytes: &[u8]| sent.push((to, bytes.to_vec()));
            while let Some(mut bytes) = carrier.release(now) {
                let _ = self.nodes[side].receive(now_us, &mut bytes);
            }
            carrier.poll(now, &mut send);
            self.nodes[side].tick(now_us, |bytes| _ = carrier.send(now, bytes, &mut send));
            let from = self.at[side];
            sent.into_iter().for_each(|(to, bytes)| self.post(from, to, &bytes));
            let force_n = f64::from(self.nodes[side].observed().coordination_force);
            let before_n = std::mem::replace(&mut self.force_n[side], force_n);
            self.jump_n = self.jump_n.max((force_n - before_n).abs());
        }
        let [one, two] = self.nodes.each_ref().map(|node| f64::from(node.observed().object.position));
        self.apart_m = self.apart_m.max((one - two).abs());
    }

    /// Goes on for so long; the largest change of force in a tick, N, and distance of the copies, m.
    fn run(&mut self, ms: u64) -> [f64; 2] {
        (self.jump_n, self.apart_m) = (0.0, 0.0);
        (0..ms).for_each(|_| self.step());
        [self.jump_n, self.apart_m]
    }

    fn ways(&self) -> [Way; 2] {
        self.carriers.each_ref().map(Carrier::way)
    }
}

/// At any moment of what hands do. One that stands as a wall, or goes on in a step, changed the force by up to 1.4 N in a tick.
#[test]
fn a_direct_path_that_dies_is_no_step() {
    for hands in [LED, AGAINST] {
        for phase in 0..12 {
            let mut world = World::new(hands);
            world.run(9500 + 87 * phase);
            assert_eq!(world.ways(), [Way::Direct; 2]);
            world.cut = true;
            let [longer_n, longer_m] = world.run(3000);
            let [relayed_n, relayed_m] = world.run(3000);
            assert_eq!(world.ways(), [Way::Relayed; 2]);
            eprintln!(
                "{:?}, {phase}: {longer_n:.4} N, {:.2} mm; then {relayed_n:.4} N, {:.2} mm",
                hands[0],
                1e3 * longer_m,
                1e3 * relayed_m
            );
            assert!(longer_n <= 0.1, "{hands:?}, {phase}: {longer_n} N in a tick");
            // For 47 ms nothing comes, which the copies go apart for.
            assert!(
                longer_m <= 1.6 * relayed_m,
                "{hands:?}, {phase}: {longer_m} m apart, {relayed_m} m on the longer path"
            );
        }
    }
}

#[test]
fn a_change_of_path_is_a_small_step_and_nothing_ends() {
    let mut world = World::new(LED);
    world.run(6000);
    assert!(world.nodes.iter().all(|node| node.peer.mode() == Mode::Armed), "both hold it");
    let [direct_n, direct_m] = world.run(4000);
    assert_eq!(world.ways(), [Way::Direct; 2]);
    world.cut = true;
    let [longer_n, longer_m] = world.run(3000);
    let [relayed_n, relayed_m] = world.run(3000);
    assert_eq!(world.ways(), [Way::Relayed; 2]);
    world.cut = false;
    // ICE looks for it again; then the flow changes over.
    let [shorter_n, shorter_m] = world.run(15_000);
    assert!(world.ways().iter().all(|way| matches!(way, Way::Direct | Way::Both)), "{:?}", world.ways());
    eprintln!(
        "largest change of F_T in a tick: direct {direct_n:.4} N, to relayed {longer_n:.4}, relayed {relayed_n:.4}, to direct {shorter_n:.4}; \
         apart: {:.2}, {:.2}, {:.2}, {:.2} mm",
        1e3 * direct_m,
        1e3 * longer_m,
        1e3 * relayed_m,
        1e3 * shorter_m
    );
    let steady_n = relayed_n.max(direct_n);
    // 0.013 N steadily, 0.018 to the shorter path.
    assert!(steady_n < 0.02 && shorter_n < 0.05, "a path that becomes shorter is no step");
    assert!(longer_n <= 0.1, "a path that ends is no step");
    assert!(direct_m < relayed_m, "the shorter line is nearer");
    assert!(shorter_m <= 1.1 * relayed_m, "copies stay within what the longer path leaves");
    assert!(longer_m <= 1.6 * relayed_m, "copies stay within 1.6 times the longer path leaves");
    for (node, carrier) in world.nodes.iter().zip(&world.carriers) {
        let lost = |notice: &Notice| matches!(notice, Notice::Lost | Notice::Disengaged);
        assert!(node.peer.mode() == Mode::Armed && !node.line.notices.iter().any(|(_, notice)| lost(notice)));
        // Hundreds of copies, and one datagram that crossed the handshake.
        let (refused, copies) = (node.line.link.counts().refused, carrier.report().copies);
        assert!(refused <= 2 && copies > 100, "{refused} refused, {copies} copies");
    }
}
