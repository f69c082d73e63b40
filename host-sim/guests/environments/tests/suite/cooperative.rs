//! The cooperative environment: the paper's limits without the bounder, none up to 200 ms with it, the engine that moves, and
//! N wave peers around a node.

use cohold_analysis::rendering::{Body, Renderer, Rendering};
use cohold_environments::cooperative::bounder::Bounder;
use cohold_environments::cooperative::limits::{bounded_radius, stiffest, table};
use cohold_environments::cooperative::run::run;
use cohold_environments::cooperative::waves::Waves;
use cohold_environments::cooperative::world::World;
use cohold_environments::cooperative::{Collision, Engine, Setup};
use cohold_sim::pair::Pair;
use cohold_sim::scene::Scene;
use rayon::prelude::*;

/// The cooperation paper's §5 forces: a push of each, taps of one and a sine of the other.
const FORCES: [&str; 5] =
    ["user.1.push_n=1", "user.2.push_n=1", "user.1.pulse_n=1", "user.1.pulse_every_s=2.5", "user.2.sine_n=0.25"];

fn setup(users: usize, one_way_ms: f64, collision: Collision, keys: &[&str]) -> Setup {
    let mut setup = Setup::base(1e-3 * one_way_ms, &[&FORCES[..], keys].concat()).expect("a good scene");
    (setup.users, setup.collision) = (users, collision);
    setup
}

/// Eq. 7 of the paper: stiff objects bear 5 to 10 ms, soft ones 30 ms; eigenvalues and simulation say the same.
#[test]
fn the_papers_limits_without_the_bounder() {
    let rows = table().expect("limits");
    assert_eq!(rows.len(), 6);
    for row in rows {
        assert!((row.simulated_n_per_m / row.eigenvalues_n_per_m - 1.0).abs() < 0.05, "{row:?}");
        let (kind, range) = match row.round_trip_ms {
            5.0 => ("stiff", 900.0..=1200.0),
            10.0 => ("stiff", 450.0..=650.0),
            _ => ("soft", 100.0..=200.0),
        };
        assert!(row.kind == kind && range.contains(&row.simulated_n_per_m), "{row:?}");
    }
}

/// §2.3 of the paper: 1000 N/m needs less than 5 ms between device and contact.
#[test]
fn a_thousand_newtons_per_metre_need_less_than_5_ms() {
    let [near, far] = [4.0, 5.0].map(|ms| stiffest("", ms, Collision::Server).expect("a limit").simulated_n_per_m);
    assert!(near > 1000.0 && (950.0..1000.0).contains(&far), "{near} N/m at 4 ms, {far} N/m at 5 ms");
}

/// The line: stable for every delay up to 200 ms with the bounder. Simulated, with many users and slow packets too.
#[test]
fn stable_at_every_delay_with_the_bounder() {
    let collisions = [Collision::Client, Collision::Server];
    let points: Vec<_> = collisions
        .into_iter()
        .flat_map(|collision| [2, 16].map(|users| (collision, users)))
        .flat_map(|(collision, users)| [1, 8].map(|packet| (collision, users, packet)))
        .flat_map(|point| [3.0, 30.0, 200.0].map(|one_way_ms| (point, one_way_ms)))
        .collect();
    points.into_par_iter().for_each(|((collision, users, packet), one_way_ms)| {
        let packets = format!("timing.ticks_per_packet={packet}");
        let outcome = run(&setup(users, one_way_ms, collision, &[&packets]), 5.0).expect("a run");
        assert!(outcome.stable, "{users} users, {one_way_ms} ms, {collision:?}, packets of {packet} ms: {outcome:?}");
    });
}

/// Without it the same environments break, from the paper's delays on.
#[test]
fn without_the_bounder_they_break() {
    for collision in [Collision::Client, Collision::Server] {
        for one_way_ms in [10.0, 200.0] {
            let mut setup = setup(2, one_way_ms, collision, &[]);
            setup.bounder = false;
            assert!(!run(&setup, 4.0).expect("a run").stable, "{one_way_ms} ms, {collision:?}");
        }
    }
}

/// By eigenvalues: the environments of the simulation at every delay, and the sweep behind the bounder's claim, sampled.
#[test]
fn eigenvalues_agree_that_the_bounder_holds() {
    for collision in [Collision::Client, Collision::Server] {
        for users in [1, 16] {
            for one_way_ms in [1.0, 5.0, 20.0, 60.0] {
                let setup = setup(users, one_way_ms, collision, &[]);
                let radius = bounded_radius(&setup, 2e-3 * one_way_ms).expect("eigenvalues");
                assert!(radius <= 1.0 + 1e-9, "{users} users, {one_way_ms} ms, {collision:?}: {radius}");
            }
        }
    }
    let mut points = Vec::new();
    for device in [(0.05, 0.2), (0.1, 1.0), (0.1, 5.0), (0.5, 1.0)] {
        for (object_kg, users) in [(0.05, 1.0), (0.05, 16.0), (0.3, 2.0), (0.3, 16.0), (2.0, 1.0), (2.0, 16.0)] {
            for contact in [(200.0, 0.0), (1000.0, 2.0)] {
                points.extend([2.0, 10.0, 50.0].map(|ms| (device, object_kg / users, contact, ms)));
            }
        }
    }
    points.push(((0.1, 5.0), 0.15, (1000.0, 2.0), 200.0));
    points
        .into_par_iter()
        .map_init(Renderer::default, |renderer, ((m, b), object_kg, (k, damping), ms)| {
            let bound = Bounder::<f64>::new(k, damping, b, 1e-3).bound(1e-3 * ms);
            let rendering = Rendering {
                device: Body { mass_kg: m, damping_n_s_per_m: b },
                object: Some(Body { mass_kg: object_kg, damping_n_s_per_m: bound.drag }),
                contact_damping_n_s_per_m: bound.damping,
                period_s: 1e-3,
                computing_ticks: 0.0,
                delays_s: [0.0, 0.0, 0.5e-3 * ms, 0.5e-3 * ms],
            };
            let radius = renderer.radius(&rendering, bound.stiffness).expect("eigenvalues");
            assert!(radius <= 1.0 + 1e-9, "{rendering:?} with {bound:?}: {radius}");
        })
        .for_each(drop);
}

#[test]
fn a_delay_that_grows_on_the_way_is_followed() {
    let keys = ["network.delay_step_s=0.08", "network.delay_step_at_s=4"];
    let outcome = run(&setup(2, 5.0, Collision::Client, &keys), 12.0).expect("a run");
    assert!(outcome.stable, "{outcome:?}");
    assert!((outcome.round_trip_ms.expect("measured") - 170.0).abs() < 2.0, "{outcome:?}");
    let lossy = ["network.loss=0.2", "network.jitter=uniform", "network.jitter_s=0.02"];
    let outcome = run(&setup(3, 20.0, Collision::Client, &lossy), 12.0).expect("a run");
    assert!(outcome.stable, "{outcome:?}");
}

/// To the first client and back: one engine at a time, the object goes on, and no force jumps more than it did before.
#[test]
fn the_engine_moves_without_a_jump() {
    for one_way_ms in [0.0, 5.0, 50.0, 150.0] {
        let mut world = World::new(&setup(3, one_way_ms, Collision::Client, &["user.1.pulse_n=0"])).expect("a world");
        let mut forces = [0.0; 3];
        // The largest change of a force in the second before a transfer, and in the one from it on.
        let mut jumps = [0.0_f64; 4];
        let (mut nobody, mut object) = (0, world.object());
        for tick in 0..10_000 {
            match tick {
                4_000 => world.ask(),
                7_000 => world.recall(),
                _ => {}
            }
            world.step();
            let (holders, before) = (world.holders(), object.position);
            assert!(holders.len() <= 1, "two engines at tick {tick}");
            object = world.object();
            assert!((object.position - before).abs() < 1e-4, "{one_way_ms} ms: the object jumps at tick {tick}");
            nobody += u32::from(holders.is_empty());
            let there = tick > 4_000 + 5 * one_way_ms as u32 + 5 && tick < 7_000;
            assert!(!there || holders == [1], "{holders:?} at tick {tick}");
            for (force, before) in world.forces().zip(&mut forces) {
                let jump = (force - *before).abs();
                *before = force;
                match tick {
                    3_000..4_000 => jumps[0] = jumps[0].max(jump),
                    4_000..5_000 => jumps[1] = jumps[1].max(jump),
                    6_000..7_000 => jumps[2] = jumps[2].max(jump),
                    7_000..8_000 => jumps[3] = jumps[3].max(jump),
                    _ => {}
                }
            }
        }
        assert_eq!(world.holders(), [0]);
        assert!(f64::from(nobody) <= 2.0 * one_way_ms + 4.0, "{nobody} ticks without an engine at {one_way_ms} ms");
        // Of a newton that they push with: below what a hand can tell (7 %) by far.
        assert!(jumps.iter().all(|jump| *jump < 0.03), "{one_way_ms} ms: {jumps:?} N");
    }
}

/// The client that has the engine feels no network: its stiffness is the scene's, the others' follow their round trips.
#[test]
fn at_a_client_the_engine_is_without_delay() {
    let mut setup = setup(2, 40.0, Collision::Client, &[]);
    setup.engine = Engine::Client;
    let mut world = World::new(&setup).expect("a world");
    world.ask();
    for _ in 0..8_000 {
        world.step();
    }
    assert_eq!(world.holders(), [1]);
    let bounds: Vec<_> = world.clients().map(|client| client.bound.stiffness).collect();
    assert!((bounds[0] / 1000.0 - 1.0).abs() < 1e-2, "{bounds:?}");
    // Two ways up and two down, through the server.
    let other = world.clients().last().and_then(|client| client.clock.round_trip_us()).expect("measured");
    assert!((159_000..=166_000).contains(&other), "{other}");
    assert!((bounds[1] - 0.8 * 5.0 / 0.164).abs() < 2.0, "{bounds:?}");
}

fn waves(keys: &[&str]) -> Scene {
    let base = ["coordination.comm=passive-mean", "coordination.decode=implicit", "object.force_delay_ticks=0"];
    let keys: Vec<String> = [&base[..], &FORCES, keys].concat().into_iter().map(str::to_owned).collect();
    Scene::load(cohold_sim::Laws::built_in(), None, &keys).expect("a good scene")
}

/// Two lines of equal impedance that meet in a node are one line: up one packet, down one packet is two packets.
#[test]
fn two_peers_around_a_node_are_the_plain_pair() {
    for law in ["wave", "passive-wave", "passive-mean"] {
        let law = format!("coordination.comm={law}");
        let keys = [law.as_str(), "coordination.stiffness_n_per_m=1000", "object.integrator=semi-implicit"];
        let mut pair = Pair::<f64>::new(&waves(&[&keys[..], &["network.one_way_delay_packets=2"]].concat())).unwrap();
        let mut around =
            Waves::new(&waves(&[&keys[..], &["network.one_way_delay_packets=1"]].concat()), 2).expect("a node");
        for tick in 0..10_000 {
            pair.step();
            around.step();
            for (side, copy) in pair.sides().into_iter().zip(around.copies()) {
                let distance_m = side.peer.observed()[0].object.position - copy.position;
                assert!(distance_m.abs() < 1e-10, "{law} at tick {tick}: {distance_m} m");
            }
        }
    }
}

#[test]
fn many_wave_peers_share_one_object() {
    for users in [2, 3, 7, 16] {
        for packets in [0, 1, 12] {
            let delay = format!("network.one_way_delay_packets={packets}");
            let scene = waves(&[&delay, "coordination.stiffness_n_per_m=4000", "object.integrator=semi-implicit"]);
            let outcome = Waves::new(&scene, users).expect("a node").run(10.0);
            assert!(outcome.stable, "{users} users, {packets} packets: {outcome:?}");
            assert!((outcome.node_out_over_in - 1.0).abs() < 1e-12, "{outcome:?}");
        }
    }
    let bad =
        ["network.loss=0.1", "network.jitter=uniform", "network.jitter_s=0.02", "object.integrator=semi-implicit"];
    assert!(Waves::new(&waves(&bad), 3).err().unwrap().to_string().contains("constant delay"));
    let paid = waves(&[&bad[..], &["coordination.ledger=true", "coordination.drift_correction=true"]].concat());
    let outcome = Waves::new(&paid, 3).expect("a node").run(20.0);
    assert!(outcome.stable && outcome.node_out_over_put_in <= 1.0, "{outcome:?}");
    assert!(outcome.true_discrepancy_mm < 20.0 && outcome.node_out_over_put_in > 0.5, "{outcome:?}");
    let power = waves(&["coordination.comm=power"]);
    assert!(Waves::new(&power, 3).err().unwrap().to_string().contains("coordination.comm"));
}
