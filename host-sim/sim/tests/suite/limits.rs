//! A board's limits in whole runs: what both hands did is never less than what both devices and both copies have of it, at any tick, and
//! no port of a peer gives more than went in.

use cohold_sim::measure::port::ObjectPort;
use cohold_sim::pair::Pair;
use cohold_sim::peers::Builds;
use cohold_sim::plant::Plant;
use cohold_sim::rng::Rng;
use cohold_sim::{Laws, Scene, of_axes, scenes};

use super::capital_j;

/// What a board is delivered with (firmware/src/kept.rs).
const BOARD: [&str; 2] = ["safety.max_force_n=3", "safety.max_slew_n_per_s=60"];

/// What a run came to, at its worst ticks.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    /// Least of the hands' work less the kinetic energy of devices and copies, J.
    least_j: f64,
    /// Most of what the hands had done, J.
    work_j: f64,
    /// Most that came out of the ports of either peer's coordination beyond what went in, J.
    made_j: f64,
    /// Ticks in which a force was cut.
    limited: u32,
    /// Largest |F_T|, N.
    peak_n: f64,
}

/// A run under hands that push by `pushes`, N toward positive x, at each tick.
fn run(scene: &Scene, ticks: u32, mut pushes: impl FnMut(u32) -> [f64; 2]) -> Found {
    let mut pair = Pair::<f64>::new(scene).expect("a good scene");
    let timing = &scene.peer.timing;
    let step_n = 0.999 * scene.peer.safety.max_slew_n_per_s * timing.control_period_s;
    let mut ports = [0, 1].map(|_| ObjectPort::new(timing.control_period_s, scene.peer.coordination.stiffness_n_per_m));
    let (mut found, mut work_j, mut last_n) = (Found::default(), 0.0, [0.0_f64; 2]);
    for tick in 0..ticks {
        let pushes = pushes(tick);
        pair.sides_mut().zip(pushes).for_each(|(side, push)| side.plant.pull([push, 0.0]));
        let before = pair.sides().map(|side| side.plant.motions()[0]);
        pair.step();
        assert!(pair.fault().is_none(), "{:?} after {tick} ms", pair.fault());
        let mut copies_j = 0.0;
        for (at, side) in pair.sides().into_iter().enumerate() {
            let seen = *side.peer.observed()[0];
            // As this tick began.
            copies_j += 0.5 * scene.peer.object.mass_kg * seen.object.velocity.powi(2);
            copies_j += 0.5 * scene.world.device.mass_kg * before[at].velocity.powi(2);
            ports[at].see(&seen, [side.peer.ledger()[0].received_j(), side.peer.ledger()[0].sent_j()]);
            found.made_j = found.made_j.max(-ports[at].balance_j);
            found.peak_n = found.peak_n.max(seen.coordination_force.abs());
            let force_n = seen.contact_force.abs();
            let grew = force_n - last_n[at].abs() > step_n;
            found.limited += u32::from(grew || force_n > 0.999 * scene.peer.safety.max_force_n);
            last_n[at] = seen.contact_force;
        }
        found.least_j = found.least_j.min(work_j - copies_j);
        found.work_j = found.work_j.max(work_j.abs());
        for ((before, side), push) in before.iter().zip(pair.sides()).zip(pushes) {
            work_j += push * (side.plant.motions()[0].position - before.position);
        }
    }
    found
}

fn scene(name: &str, keys: &[&str]) -> Scene {
    let mut scene = scenes::load(Laws::built_in(), name).expect("built in");
    scene.users = Default::default();
    keys.iter().for_each(|key| scene.apply_override(key).unwrap_or_else(|error| panic!("{key}: {error}")));
    scene.check("test").unwrap_or_else(|error| panic!("{error}"));
    scene
}

/// Both hands shake the object: with limits of 3 N and 60 N/s the copies had got 3.6 times what the hands did, F_T was 44 N, and a peer
/// stopped after 0.28 s.
#[test]
fn a_board_that_is_shaken_makes_no_energy() {
    let scene = scene("any-network", &BOARD);
    let shake = |tick: u32| {
        let time = 1e-3 * f64::from(tick);
        [4.0 * (17.0 * time).sin(), -4.0 * (13.0 * time).sin()]
    };
    let found = run(&scene, 4000, shake);
    assert!(found.least_j > -capital_j(&scene) && found.limited > 500 && found.peak_n < 6.0, "{found:?}");
}

/// A hand goes 40 mm to and fro, and the other one holds on by an arm that would push with 40 N: for a minute nothing ends, and neither gets
/// more than 3 N.
#[test]
fn a_hand_presses_for_as_long_as_it_likes() {
    let arms =
        ["user.1.arm_stiffness_n_per_m=1000", "user.1.arm_damping_n_s_per_m=5", "user.2.arm_stiffness_n_per_m=1000"];
    let hand = ["user.2.arm_damping_n_s_per_m=5", "user.1.tremor_m=0.04", "user.1.tremor_hz=0.3"];
    for axes in ["axis.shared=1", "axis.shared=2"] {
        let more = ["safety.max_speed_m_per_s=0.5", "axis.count=2", axes];
        let scene = &scene("any-network", &[&BOARD[..], &arms, &hand, &more].concat());
        of_axes!(scene, presses(scene));
    }
}

fn presses<const SHARED: usize, const N: usize>(scene: &Scene)
where
    f64: Builds<SHARED, N>,
{
    let mut pair = Pair::<f64, Plant<N>, SHARED, N>::build(scene).expect("a good scene");
    let mut limited = 0;
    for tick in 0..60_000 {
        pair.step();
        assert!(pair.fault().is_none(), "{tick} ms: {:?}", pair.fault());
        limited += u32::from(pair.sides().iter().any(|side| side.peer.observed()[0].contact_force.abs() > 2.99));
    }
    assert!(limited > 20_000, "it stood at its limit for {limited} ms");
}

/// 1,000 scenes of laws that make no energy, over networks that they make none on, with limits that cut, under hands that change their
/// mind 20 times a second. The self-timed line has something to begin with at either end.
#[test]
fn a_thousand_runs_at_their_limits_make_no_energy() {
    let mut rng = Rng::new(31);
    let (mut limited, mut worst) = (0, Found::default());
    for index in 0..1000 {
        let law = ["self-timed", "passive-mean", "wave", "none"][index % 4];
        let scale = |rng: &mut Rng, from: f64, to: f64| from * (to / from).powf(rng.unit());
        let mut keys: Vec<String> = [
            ("safety.max_force_n", scale(&mut rng, 0.5, 6.0)),
            ("safety.max_slew_n_per_s", scale(&mut rng, 10.0, 1000.0)),
            ("contact.stiffness_n_per_m", scale(&mut rng, 100.0, 1500.0)),
            ("object.mass_kg", scale(&mut rng, 0.02, 0.5)),
            ("coordination.stiffness_n_per_m", scale(&mut rng, 300.0, 1e5)),
            ("coordination.wave_impedance_n_s_per_m", scale(&mut rng, 5.0, 80.0)),
            ("device.force_delay_ticks", rng.unit()),
            ("network.one_way_delay_packets", rng.below(21) as f64),
        ]
        .map(|(key, value)| format!("{key}={value}"))
        .into();
        keys.push(format!("coordination.comm={law}"));
        keys.push("network.seed=3".to_owned());
        match (index / 4) % 3 {
            1 => keys.extend(["contact.gap_m=0.002".to_owned()]),
            2 => keys.extend(["contact.one_sided=true", "contact.gap_m=0.001"].map(String::from)),
            _ => {}
        }
        if law == "self-timed" {
            keys.extend([format!("network.loss={}", 0.4 * rng.unit()), "network.loss_burst_packets=20".to_owned()]);
        }
        let scene = scene("any-network", &keys.iter().map(String::as_str).collect::<Vec<_>>());
        let strength_n = scale(&mut rng, 0.3, 6.0);
        let mut pushes = [0.0; 2];
        let found = run(&scene, 1000, |_| {
            if rng.unit() < 0.02 {
                pushes = [0, 1].map(|_| strength_n * (2.0 * rng.unit() - 1.0));
            }
            pushes
        });
        let begins_j = if law == "self-timed" { capital_j(&scene) } else { 0.0 };
        let rounding_j = 1e-9 + 1e-3 * found.work_j;
        assert!(found.least_j > -2.0 * begins_j - rounding_j, "{index}: {found:?}, {keys:?}");
        assert!(found.made_j < begins_j + 1e-9, "{index}: {found:?}, {keys:?}");
        limited += found.limited;
        worst.least_j = worst.least_j.min(found.least_j);
        worst.made_j = worst.made_j.max(found.made_j);
    }
    assert!(limited > 50_000, "{limited} ticks were cut");
    println!("least balance {} mJ, peers made {} mJ, {limited} ticks cut", 1e3 * worst.least_j, 1e3 * worst.made_j);
}
