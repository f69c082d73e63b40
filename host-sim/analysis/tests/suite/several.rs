//! Objects shared along several axes, coupled by the device's mass or not: the verdict against long runs, and against one axis.

use haptic_analysis::{Direction, Hands, judge};
use haptic_sim::pair::Pair;
use haptic_sim::peers::Builds;
use haptic_sim::plant::Plant;
use haptic_sim::run::{Options, run};
use haptic_sim::scene::Scene;
use haptic_sim::{Laws, of_axes, scenes};

use crate::random::{self, Random};

fn scene(keys: &[&str]) -> Scene {
    let mut scene = Scene::new(Laws::built_in());
    keys.iter().for_each(|key| scene.apply_override(key).unwrap_or_else(|error| panic!("{key}: {error}")));
    scene.check("test").unwrap_or_else(|error| panic!("{error}"));
    scene
}

/// Moves of the objects along `unit` over each packet, of both peers together and against each other.
fn moves(scene: &Scene, seconds: f64, unit: [f64; 3]) -> [Vec<f64>; 2] {
    let run = run::<f64>(scene, Options { duration_s: seconds, record_every: 1 }, &|_| ()).expect("a scene");
    assert!(run.fault.is_none());
    let path = |name: &str| -> Vec<f64> {
        let columns: Vec<_> = run.axes.iter().map(|axis| axis.table.column(name).expect("recorded").to_vec()).collect();
        (0..columns[0].len())
            .map(|tick| columns.iter().zip(unit).map(|(column, part)| part * column[tick]).sum())
            .collect()
    };
    let (one, two) = (path("object_1_m"), path("object_2_m"));
    [1.0, -1.0].map(|sign| {
        let at = |packet: usize| one[8 * packet] + sign * two[8 * packet];
        (1..one.len() / 8).map(|packet| at(packet) - at(packet - 1)).collect()
    })
}

/// Growth over a packet of s(k) = A·ρᵏ·cos(kφ + θ): s² − s(k+1)·s(k−1) = A²·ρ²ᵏ·sin²φ, whatever the phase.
fn growth(moves: &[f64]) -> f64 {
    let squared = |at: usize| moves[at] * moves[at] - moves[at + 1] * moves[at - 1];
    let (first, last) = (moves.len() / 3 * 2, moves.len() - 2);
    (squared(last) / squared(first)).powf(0.5 / (last - first) as f64)
}

#[test]
fn the_radius_of_coupled_axes_is_the_growth_of_a_long_run_along_the_direction_it_names() {
    let mut looked_at = 0;
    // A guide askew to the axes of the mass leaves nothing that the system could fall apart into.
    let guide = [
        "object.integrator=midpoint",
        "object.force_delay_ticks=0",
        "coordination.decode=implicit",
        "fixture.kind=guide",
        "fixture.direction_rad=0.9",
        "fixture.stiffness_n_per_m=300",
        "fixture.drag_n_s_per_m=0.3",
        "coordination.stiffness_n_per_m=900",
    ];
    for (axes, mechanism, more) in [("2", "five-bar", &[][..]), ("3", "arm", &[]), ("2", "five-bar", &guide)] {
        for law in [
            ["coordination.comm=power", "coordination.stiffness_n_per_m=420"],
            ["coordination.comm=wave", "coordination.stiffness_n_per_m=3500"],
        ] {
            let (count, share, model) =
                (format!("axis.count={axes}"), format!("axis.shared={axes}"), format!("kinematics.model={mechanism}"));
            if !more.is_empty() && law[0] != "coordination.comm=power" {
                // A wave line and one solve a tick are passive.
                continue;
            }
            let keys = [
                law[0],
                law[1],
                &count,
                &share,
                &model,
                "kinematics.left_home_rad=2.9",
                "kinematics.right_home_rad=1.3",
                "kinematics.distal_m=0.16",
                "device.joint_inertia=0.002",
                "user.1.pulse_n=1e-12",
                "user.1.pulse_s=0.01",
                "user.1.pulse_every_s=100",
                "user.1.direction_rad=0.5",
                "user.1.elevation_rad=0.6",
                "safety.max_slew_n_per_s=1e6",
                "safety.max_force_n=200",
            ];
            let scene = scene(&[&keys[..], more].concat());
            if let Some(stable) = more.last().map(|_| &["coordination.stiffness_n_per_m=420"]) {
                // Along the guide everything stays where it is put, whichever way that is: a mode at rest, not one that decides.
                let stable = self::scene(&[&keys[..], more, stable].concat());
                let radius = judge(&stable).expect("a good scene").modes[0].verdict.spectral_radius;
                assert!(radius < 0.9999, "{radius}");
            }
            let judged = judge(&scene).expect("a good scene");
            let both = judged.modes.iter().find(|mode| mode.mode == Hands::Both).expect("judged").verdict;
            println!("{mechanism} {law:?} {more:?}: {both:?}");
            let unit = match both.direction {
                Some(Direction::Along(unit)) => unit,
                // Two of its axes are alike.
                Some(Direction::Across(_)) if mechanism == "arm" => [1.0, 0.0, 0.0],
                other => panic!("{other:?}"),
            };
            // An arm's links are square to each other at home: its mass is not the same along all axes, but couples none.
            let oblique = unit.iter().filter(|part| part.abs() > 0.1).count() > 1;
            assert_eq!(oblique, mechanism == "five-bar", "{unit:?}");
            assert!(both.spectral_radius > 1.001, "{mechanism} {law:?} does not grow: {both:?}");
            // Twenty-five times e.
            let [together, against] = moves(&scene, 0.2 / both.spectral_radius.ln(), unit);
            let size = |moves: &[f64]| moves.iter().rev().take(20).fold(0.0_f64, |most, at| most.max(at.abs()));
            let grown = growth(if size(&together) > size(&against) { &together } else { &against });
            assert!((grown - both.spectral_radius).abs() < 1e-6, "{mechanism} {law:?}: {grown} of {both:?}");
            looked_at += 1;
        }
    }
    assert_eq!(looked_at, 5);
}

/// Every mode of the built-in scenes dies away, and only the five-bar's mass points askew to the axes.
#[test]
fn the_scenes_of_a_plane_and_of_space_are_stable_in_every_mode() {
    for (name, oblique) in [("plane", true), ("space", false)] {
        let judged = judge(&scenes::load(Laws::built_in(), name).expect("built in")).expect("a good scene");
        assert!(judged.worst.stable && judged.modes.len() == 3, "{name}: {judged:?}");
        assert!(judged.modes.iter().all(|mode| mode.verdict.spectral_radius < 0.998), "{name}: {judged:?}");
        let both = judged.modes.iter().find(|mode| mode.mode == Hands::Both).expect("judged").verdict;
        let is_oblique =
            matches!(both.direction, Some(Direction::Along(unit)) if unit[0].abs().min(unit[1].abs()) > 0.1);
        assert_eq!(is_oblique, oblique, "{name}: {both:?}");
    }
}

/// How the speed of the copies grows from the second quarter of a run to the last one, from a state that is disturbed by next to nothing
/// everywhere; infinite where it leaves what is small, since limits act beyond.
fn grown(scene: &Scene, seed: u64) -> f64 {
    of_axes!(scene, grown_along(scene, seed))
}

fn grown_along<const SHARED: usize, const N: usize>(scene: &Scene, seed: u64) -> f64
where
    f64: Builds<SHARED, N>,
{
    let mut pair = Pair::<f64, Plant<N>, SHARED, N>::build(scene).expect("a good scene");
    let mut random = Random::new(seed);
    for side in pair.sides_mut() {
        side.peer.visit_state(&mut |number| *number += 1e-9 * (random.unit() - 0.5));
    }
    let mut largest = [0.0_f64; 4];
    for tick in 0..RUN_TICKS {
        pair.step();
        let quarter = &mut largest[tick * 4 / RUN_TICKS];
        for seen in pair.sides().into_iter().flat_map(|side| side.peer.observed()) {
            *quarter = quarter.max(seen.object.velocity.abs());
        }
        if *quarter > LARGE_M_PER_S || pair.fault().is_some() {
            return f64::INFINITY;
        }
    }
    largest[3] / largest[1]
}

const RUN_TICKS: usize = 8000;

/// Some ten million times what the disturbance comes to.
const LARGE_M_PER_S: f64 = 1e-2;

/// The scene with the hand of one user let go of.
fn let_go(linear: &Scene, user: usize) -> Scene {
    let mut scene = linear.clone();
    for key in ["stiffness_n_per_m", "damping_n_s_per_m"] {
        scene.apply_override(&format!("peer.{}.contact.{key}=0", user + 1)).expect("a good key");
    }
    scene
}

/// Two hundred random scenes of two and three axes, every other one coupled by the mass of a mechanism: what every mode's radius says is
/// what a run of that mode does. Where nothing couples the axes, the radii are those of one axis.
#[test]
fn random_scenes_of_several_axes_are_judged_as_they_run() {
    let (mut decided, mut unstable, mut coupled) = ([0; 3], [0; 3], 0);
    for seed in 0..200 {
        let one = random::scene(seed);
        let mut scene = one.clone();
        let axes = 2 + (seed % 2) as u32;
        (scene.peer.axis.count, scene.peer.axis.shared) = (axes, axes);
        if seed % 4 > 1 {
            let model = if axes == 2 { "five-bar" } else { "arm" };
            let inertia = Random::new(1000 + seed).spread(1e-4, 1e-2);
            for key in [format!("kinematics.model={model}"), format!("device.joint_inertia={inertia}")] {
                scene.apply_override(&key).expect("a good key");
            }
            for key in ["left_home_rad=2.9", "right_home_rad=1.3", "distal_m=0.16"] {
                scene.apply_override(&format!("kinematics.{key}")).expect("a good key");
            }
            coupled += 1;
        }
        scene.check("random").unwrap_or_else(|error| panic!("{seed}: {error}"));
        let judged = judge(&scene).expect("a good scene");
        if !scene.is_coupled() {
            let alone = judge(&one).expect("a good scene");
            for (several, one) in judged.modes.iter().zip(&alone.modes) {
                let [several, one] = [several, one].map(|mode| mode.verdict.spectral_radius);
                // A multiple eigenvalue is known less well than a single one.
                assert!((several - one).abs() <= 1e-7 * one, "{seed}: {several}, alone {one}");
            }
            assert_eq!(judged.worst.stable, alone.worst.stable, "{seed}");
        }
        let linear = scene.linear();
        let packets = RUN_TICKS as f64 / f64::from(scene.peer.timing.ticks_per_packet);
        // Packets may be too old to be used.
        let judged = judged.modes.iter().enumerate().filter(|(_, mode)| mode.verdict.not_judged_because.is_none());
        for (at, mode) in judged {
            let runs = match mode.mode {
                Hands::Both => vec![linear.clone()],
                Hands::One => vec![let_go(&linear, 0), let_go(&linear, 1)],
                Hands::None => vec![linear.hands_off()],
            };
            let grown = runs.iter().map(|scene| grown(scene, seed)).fold(0.0, f64::max);
            // Over half a run, from quarter to quarter.
            let wanted = 0.5 * packets * mode.verdict.spectral_radius.ln();
            if mode.verdict.stable {
                let law = scene.law().name;
                assert!(grown < 2.0, "{seed}, {law}, {:?}: grown by {grown}, radius {:?}", mode.mode, mode.verdict);
            } else if wanted > 2.0 {
                assert!(grown.ln() > 0.5 * wanted, "{seed}, {:?}: grown by {grown}, {:?}", mode.mode, mode.verdict);
                unstable[at] += 1;
            } else {
                continue;
            }
            decided[at] += 1;
        }
    }
    println!("decided {decided:?}, unstable {unstable:?}, coupled {coupled}");
    assert!(coupled == 100 && decided.iter().all(|scenes| *scenes > 180), "{decided:?}");
    assert!(unstable.iter().all(|scenes| *scenes > 20), "{unstable:?}");
}
