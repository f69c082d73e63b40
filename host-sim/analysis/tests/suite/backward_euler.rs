//! Backward Euler: scenes that are let go of, and the verdict beside runs at the limit of contact.

use cohold_analysis::{Effort, Range, limit};
use cohold_sim::run::{Options, run};

use crate::kinds::backward_euler;
use crate::midpoint::{drawn, released};
use crate::random::Random;

/// Nobody's hand on the object, drawn as for the midpoint rule and stiffer.
#[test]
fn no_scene_that_is_let_go_of_is_unstable() {
    let mut random = Random::new(13);
    for number in 0..1000 {
        let scene = backward_euler(random.one(&["passive-mean", "self-timed"]), random.whole(0, 20));
        let scene = drawn(scene, &mut random, 1e7);
        let radius = released(&scene);
        assert!(radius <= 1.0 + 1e-6, "scene {number}: {radius} of {:?}", scene.peer);
    }
}

/// The stiffest contact by the analyser, by the device's own delay, and runs 5 % below it and so far above it that they show in 20 s: a hand that
/// presses at its own past position is what no integrator makes passive.
#[test]
fn runs_agree_with_the_limit_of_contact() {
    for delay_ticks in [0.0, 0.1, 0.5, 1.0] {
        let mut scene = backward_euler("passive-mean", 1);
        scene.peer.coordination.stiffness_n_per_m = 1e4;
        scene.world.device.force_delay_ticks = delay_ticks;
        // What limits take of a contact is passive: they would hold what grows.
        (scene.peer.safety.max_force_n, scene.peer.safety.max_slew_n_per_s) = (200.0, 1e6);
        let range = Range { key: "contact.stiffness_n_per_m".to_owned(), from: 100.0, to: 100_000.0 };
        let found = limit(&scene, range, Effort::default()).expect("a good scene").crossings[0];
        println!("delay of {delay_ticks} ticks: {found} N/m");
        scene.apply_override("user.1.pulse_n=1").expect("a good override");
        for (share, stable) in [(0.95, true), (1.5, false)] {
            scene.peer.contact.stiffness_n_per_m = share * found;
            let options = Options { duration_s: 20.0, record_every: 0 };
            let outcome = run::<f64>(&scene, options, &|_| {}).expect("a good scene");
            assert_eq!(
                outcome.is_stable(),
                stable,
                "{share} of {found} N/m, {delay_ticks} ticks: {:?}",
                outcome.reason
            );
        }
    }
}
