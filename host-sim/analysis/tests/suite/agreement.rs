//! The lifted matrix driven from core and the one constructed from the equations, on 10,000 random scenes.

use std::collections::BTreeSet;

use haptic_analysis::apply;
use haptic_analysis::{Agreement, agreement, judge};
use haptic_analysis::{Response, verdict};
use haptic_analysis::{is_symmetric, pair_matrix};
use haptic_core::device::velocity::VelocityName;
use haptic_core::names::Choice;
use haptic_sim::scene::Scene;
use rayon::prelude::*;

use super::random;

const SCENES: u64 = 10_000;

/// With both hands on, one, none. Matrices to 1e-9 of their largest entry in balanced units (1e-12 is seen), spectral radii to 1e-9 of themselves: all but
/// those of explosive scenes, where two equal peers on unequal delays have a nearly defective pair of eigenvalues, and the
/// radius of a matrix that is known to 1e-16 is known to 1e-8.
#[test]
fn two_constructions_agree_on_ten_thousand_scenes() {
    let worst = (0..SCENES)
        .into_par_iter()
        .map(|seed| {
            let linear = random::scene(seed).linear();
            let mut worst = Agreement { matrix: 0.0, spectral_radius: 0.0 };
            for mode in judge(&linear).unwrap().modes {
                let Some(found) = agreement(&linear, mode.mode).unwrap() else { return (0.0, 0.0, BTreeSet::new()) };
                let allowed = if mode.verdict.spectral_radius < 1e3 { 1e-9 } else { 1e-7 };
                assert!(
                    found.matrix < 1e-9 && found.spectral_radius < allowed,
                    "scene {seed}: {found:?} {mode:?}\n{linear:?}"
                );
                worst = worst.or_farther(found);
            }
            let peer = &linear.peer;
            let models = [peer.coordination.comm, peer.object.integrator.name(), peer.axis.velocity.name()];
            (worst.matrix, worst.spectral_radius, BTreeSet::from(models))
        })
        .reduce(|| (0.0, 0.0, BTreeSet::new()), |a, b| (a.0.max(b.0), a.1.max(b.1), &a.2 | &b.2));
    // Core's lists may grow and the second construction need not; what it knows today it must not forget.
    const KNOWN: [&str; 11] = [
        "power",
        "wave",
        "passive-wave",
        "passive-mean",
        "none",
        "forward-euler",
        "semi-implicit",
        "exact",
        "measured",
        "difference",
        "filtered",
    ];
    for model in KNOWN {
        assert!(worst.2.contains(model), "the second construction never met {model}");
    }
    println!("{SCENES} scenes: matrices differ by {:.1e} at most, spectral radii by {:.1e}", worst.0, worst.1);
}

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

/// Devices, scales and contacts of either end of their own: the construction takes each end's equations, core is driven as it is.
#[test]
fn two_constructions_agree_where_the_ends_are_unlike() {
    let (farthest, differ) = (0..400)
        .into_par_iter()
        .map(|seed| {
            let mut scene = random::scene(seed);
            let draw = |at: u64| (seed * 7 + at) % 11;
            for (key, number) in [
                ("peer.2.device.mass_kg", 0.05 * 1.5_f64.powi(draw(0) as i32)),
                ("peer.1.scale.position", 0.2 + 0.3 * draw(1) as f64),
                ("peer.2.scale.force", 0.2 + 0.3 * draw(2) as f64),
                ("peer.1.contact.stiffness_n_per_m", 50.0 * draw(3) as f64),
            ] {
                scene.set_number(key, number).unwrap();
            }
            let linear = scene.linear();
            let mut farthest = 0.0_f64;
            for mode in judge(&linear).unwrap().modes {
                let Some(found) = agreement(&linear, mode.mode).unwrap() else { return (0.0, false) };
                farthest = farthest.max(found.matrix);
            }
            (farthest, !is_symmetric(&linear))
        })
        .reduce(|| (0.0, false), |a, b| (a.0.max(b.0), a.1 | b.1));
    assert!(farthest < 1e-9 && differ, "{farthest:e}");
}
