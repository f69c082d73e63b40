//! A hostile member with the key of a sealed line, against one honest peer of every law; and that nobody honest is taken for one.

use cohold_core::safety::Mode;
use cohold_live::node::{Line, Node};
use cohold_protocol::end::End as _;
use cohold_protocol::key::Key;
use cohold_protocol::link::{Error, Notice};
use cohold_sim::engine::{Actor, Engine, Out, Seat};
use cohold_sim::network::link::Route;
use cohold_sim::network::rule::Direction;
use cohold_sim::plant::Plant;
use cohold_sim::rng::Rng;
use cohold_sim::scene::Scene;
use cohold_sim::scenes;

use super::program::Program;
use super::{asked, scene};

const KEY: [u8; Key::LEN] = [0x5a; Key::LEN];

/// Random bytes of a life, never the same.
fn entropy(life: u32) -> [u8; Key::LEN] {
    let mut bytes = [1; Key::LEN];
    bytes[..4].copy_from_slice(&life.to_le_bytes());
    bytes
}

/// A scene of each law, with the gains to try it with.
fn of_each_law() -> impl Iterator<Item = (&'static str, Scene)> {
    cohold_laws::LAWS.iter().map(|law| {
        let comm = format!("coordination.comm={}", law.name);
        let keys: Vec<&str> = [&comm[..]].into_iter().chain(law.gains.iter().copied()).collect();
        let mut keys = keys;
        if law.gains.contains(&"object.integrator=midpoint") {
            keys.extend(["coordination.decode=implicit", "object.force_delay_ticks=0"]);
        }
        (law.name, scene("paper-5.2-power-16ms", &keys))
    })
}

/// An honest peer, told anything by the other one: the force on its hand, and all that it computes.
#[test]
fn every_law_holds_its_hand_whatever_a_member_says() {
    let programs = asked("HOSTILE_PROGRAMS", 10_000).div_ceil(10);
    for (name, scene) in of_each_law() {
        let mut rng = Rng::new(asked("HOSTILE_SEED", 1));
        let (safety, timing) = (scene.peer.safety, scene.peer.timing);
        let slew_n = safety.max_slew_n_per_s * timing.control_period_s * (1.0 + 1e-5);
        let line =
            |number: u8, life: u32| Line::<1>::open(&scene, number, Key::new(KEY), entropy(life)).expect("a line");
        let node = |life: u32, plant: Plant| {
            Node::<1>::with_device(&scene, 1, Key::new(KEY), entropy(life), Box::new(plant)).expect("a peer")
        };
        let (mut honest, mut hostile) = (node(1, Plant::new(&scene, 0)), line(2, 2));
        let (mut force_n, mut life, mut impossible, mut said_flows) = (0.0_f64, 2_u32, 0, 0);
        let mut program = Program::new(&mut rng, 20.0);
        let (mut done, mut at, mut tick) = (0, 0, 0_u32);
        while done < programs {
            let now = u64::from(tick) * 1_000;
            let (mut to_honest, mut to_hostile) = (vec![], vec![]);
            hostile.link.say_due(now, |bytes| to_honest.push(bytes.to_vec()));
            if tick.is_multiple_of(timing.ticks_per_packet) && hostile.link.is_up() {
                let ticks = timing.ticks_per_packet;
                let flow = program.flow(&mut rng, tick, at, ticks, timing.packet_period_s());
                // What is no number is not sent.
                said_flows += u32::from(hostile.link.say(now, flow, |bytes| to_honest.push(bytes.to_vec())));
                at += u64::from(ticks);
                if at >= program.ticks {
                    (program, at, done) = (Program::new(&mut rng, 20.0), 0, done + 1);
                    if rng.chance(0.05) {
                        life += 1;
                        hostile = line(2, life);
                    }
                }
            }
            for mut bytes in to_honest {
                impossible += u32::from(matches!(honest.receive(now, &mut bytes), Err(Error::Impossible(_))));
            }
            let actuators = honest.tick(now, |bytes| to_hostile.push(bytes.to_vec()));
            for mut bytes in to_hostile {
                let _ = hostile.receive(now, tick, &mut bytes);
            }
            let (wanted_n, seen) = (f64::from(actuators.forces[0]), honest.observed());
            assert!(wanted_n.abs() <= safety.max_force_n * (1.0 + 1e-6), "{name}: {wanted_n} N");
            // Toward zero at once, away from it slowly.
            let from_n: f64 = if wanted_n > 0.0 { force_n.max(0.0) } else { force_n.min(0.0) };
            let grew_n = wanted_n.abs() - from_n.abs();
            assert!(!actuators.enable || grew_n <= slew_n, "{name}: {force_n} to {wanted_n} N");
            assert!(seen.object.is_finite() && honest.motions()[0].is_finite(), "{name}: {seen:?}");
            assert!(actuators.enable || wanted_n == 0.0);
            force_n = wanted_n;
            if matches!(honest.peer.mode(), Mode::Faulted(_)) {
                // Another life, of which the other end is told nothing.
                life += 1;
                honest = node(life, honest.device());
                force_n = 0.0;
            }
            tick += 1;
        }
        println!("{name}: {said_flows} flows, {impossible} of them impossible, {life} lives");
        assert!(u64::from(said_flows) > 4 * programs && impossible > 10, "{name}: {said_flows}, {impossible}");
    }
}

struct Honest(Box<Node>, usize);

impl Actor<usize> for Honest {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, _: usize, datagram: &mut [u8], _: &mut Out<'_, usize, [u8]>) {
        let taken = self.0.receive(now_ns / 1_000, datagram);
        assert!(!matches!(taken, Err(Error::Impossible(_))), "{taken:?}");
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, [u8]>) {
        let _ = self.0.tick(now_ns / 1_000, |bytes| out(self.1, bytes));
    }
}

/// Two honest peers of every built-in scene and every law, on the scene's network and on bad ones, one of which begins anew: what they
/// say can be ([`Honest::hear`]).
#[test]
fn nobody_honest_says_what_cannot_be() {
    const BAD: [&str; 5] = [
        "network.loss=0.2",
        "network.loss_burst_packets=40",
        "network.jitter=uniform",
        "network.jitter_s=0.02",
        "network.duplicate=0.1",
    ];
    const PUSHED: [&str; 3] = ["user.1.push_n=8", "user.2.sine_n=8", "user.2.push_n=1"];
    let built_in = scenes::known().map(|(name, _)| (*name, scene(name, &[])));
    for (name, plain) in built_in.chain(of_each_law()).filter(|(_, scene)| scene.peer.axis.shared == 1) {
        for keys in [&[][..], &BAD, &PUSHED] {
            let mut scene = plain.clone();
            keys.iter().for_each(|key| scene.apply_override(key).expect("a good override"));
            if scene.check("the test").is_err() {
                continue;
            }
            let node = |index: usize, life: u32, plant: Plant| {
                let node =
                    Node::<1>::with_device(&scene, index as u8 + 1, Key::new(KEY), entropy(life), Box::new(plant));
                Honest(Box::new(node.expect("a peer")), 1 - index)
            };
            let seats = (0..2).map(|index| Seat::new(node(index, index as u32 + 1, Plant::new(&scene, index))));
            let direction = [Direction::OneToTwo, Direction::TwoToOne];
            let route = |from: usize, _: usize| Route::of_scene(&scene, direction[from], 0);
            let mut engine = Engine::new(1_000_000, seats.collect(), route);
            for tick in 0..2_000 {
                if tick == 1_200 {
                    let device = engine.seats[1].actor.0.device();
                    engine.seats[1].actor = node(1, 9, device);
                }
                engine.step(&mut |_| ());
            }
            let met =
                |seat: &Seat<Honest>| seat.actor.0.line.notices.iter().any(|(_, notice)| *notice == Notice::Engaged);
            assert!(engine.seats.iter().all(met), "{name}, {keys:?}: they did not meet");
        }
    }
}
