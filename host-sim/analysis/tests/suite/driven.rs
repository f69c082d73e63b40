//! The lifted matrix driven from core: of all kinds of random scenes, linear, and without bounds.

use cohold_analysis::{Response, apply, is_symmetric, pair_matrix, verdict};
use cohold_core::device::velocity::VelocityName;
use cohold_sim::scene::Scene;
use rayon::prelude::*;

use super::random;

/// Half of the random scenes are symmetric, half are not, and most are neither trivial nor all stable.
#[test]
fn the_random_scenes_are_of_all_kinds() {
    let kinds: Vec<(bool, bool)> = (0..400)
        .into_par_iter()
        .map(|seed| {
            let linear = random::scene(seed).linear();
            (is_symmetric(&linear), verdict(&linear).unwrap().stable)
        })
        .collect();
    for kind in [(true, true), (true, false), (false, true), (false, false)] {
        let count = kinds.iter().filter(|found| **found == kind).count();
        assert!(count > 40, "{kind:?}: {count} of 400");
    }
}

/// What is driven on unit states is what any state does: superposition holds for every law, to rounding.
#[test]
fn the_peer_is_linear_where_it_is_analysed() {
    for seed in 0..200 {
        let mut linear = random::scene(seed).linear();
        if seed % 4 == 0 {
            // Below one encoder count the adaptive window is always the longest one.
            linear.peer.axis.velocity = VelocityName::Adaptive;
        }
        let whole = pair_matrix(&linear).unwrap().matrix;
        let mut response = Response::default();
        response.measure(&linear, 0, 0).unwrap();
        let mut random = random::Random::new(seed);
        let local: Vec<f64> = (0..response.states()).map(|_| random.unit() - 0.5).collect();
        let packet: Vec<f64> = (0..response.packet()).map(|_| random.unit() - 0.5).collect();
        let driven = Response::drive(&linear, 0, &local, &packet).unwrap();
        let (own, heard) = (apply(&response.own, &local), apply(&response.heard, &packet));
        let scale = whole.amax().max(1.0);
        for ((driven, own), heard) in driven.iter().zip(&own).zip(&heard) {
            let sum = own + heard;
            assert!((driven - sum).abs() <= 1e-12 * scale || driven == &sum, "scene {seed}: {driven} {sum}");
        }
    }
}

/// A scene that grows beyond all bounds within a packet period is unstable, not an error.
#[test]
fn overflow_is_instability() {
    let mut scene = Scene::default();
    scene.peer.timing.ticks_per_packet = 1000;
    scene.peer.contact.stiffness_n_per_m = 1e6;
    scene.peer.object.mass_kg = 1e-4;
    let found = verdict(&scene).unwrap();
    assert!(found.spectral_radius.is_infinite() && !found.stable, "{found:?}");
}
