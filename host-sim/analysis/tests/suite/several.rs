//! Objects shared along several axes, coupled by the device's mass or not: the verdict against long runs, and against one axis.

use cohold_analysis::{Direction, Hands, judge};
use cohold_sim::run::{Options, run};
use cohold_sim::scene::Scene;
use cohold_sim::scenes;

fn scene(keys: &[&str]) -> Scene {
    let mut scene = Scene::new(cohold_guest_laws::laws());
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
        let judged = judge(&scenes::load(cohold_guest_laws::laws(), name).expect("built in")).expect("a good scene");
        assert!(judged.worst.stable && judged.modes.len() == 3, "{name}: {judged:?}");
        // The slowest is what tautness moves by: 1 s at the most.
        assert!(judged.modes.iter().all(|mode| mode.verdict.spectral_radius < 0.9991), "{name}: {judged:?}");
        let both = judged.modes.iter().find(|mode| mode.mode == Hands::Both).expect("judged").verdict;
        let is_oblique =
            matches!(both.direction, Some(Direction::Along(unit)) if unit[0].abs().min(unit[1].abs()) > 0.1);
        assert_eq!(is_oblique, oblique, "{name}: {both:?}");
    }
}
