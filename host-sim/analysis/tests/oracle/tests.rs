//! The lifted matrix driven from core and the one constructed from the equations, on 10,000 random scenes and others.

#[path = "../suite/kinds.rs"]
mod kinds;
#[path = "../suite/random.rs"]
mod random;

use std::collections::BTreeSet;

use cohold_core::names::Choice;
use rayon::prelude::*;

use super::agreement::{Agreement, agreement};
use crate::{Hands, is_symmetric, judge};
use cohold_sim::scene::Scene;
use kinds::{backward_euler, midpoint, self_timed};
use random::Random;

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

/// The second construction writes the rule as algebra and lets a solver close it.
#[test]
fn both_constructions_say_the_same_of_the_midpoint_rule() {
    for law in ["power", "wave", "passive-wave", "passive-mean", "none"] {
        for (delay, ticks) in [(0, 1), (1, 8), (3, 5)] {
            let mut scene = midpoint(law, delay);
            scene.peer.timing.ticks_per_packet = ticks;
            scene.peer.object.damping_n_s_per_m = 0.7;
            for hands in [Hands::Both, Hands::One, Hands::None] {
                let difference = agreement(&scene.linear(), hands).expect("a good scene").expect("it has equations");
                let difference = difference.matrix.max(difference.spectral_radius);
                assert!(difference < 1e-9, "{law}, {delay} packets of {ticks} ticks, {hands:?}: {difference:.1e}");
            }
        }
    }
}

#[test]
fn both_constructions_say_the_same_of_backward_euler() {
    for law in ["power", "wave", "passive-wave", "passive-mean", "self-timed", "none"] {
        for (delay, ticks) in [(0, 1), (1, 8), (3, 5), (8, 1)] {
            for stiffness in [600.0, 1e7] {
                let mut scene = backward_euler(law, delay);
                scene.peer.timing.ticks_per_packet = if law == "self-timed" { 1 } else { ticks };
                scene.peer.object.damping_n_s_per_m = 0.7;
                scene.peer.coordination.stiffness_n_per_m = stiffness;
                if law == "self-timed" {
                    scene.set_number("coordination.credit_ticks", f64::from(delay + 2)).expect("it is allowed");
                }
                for hands in [Hands::Both, Hands::One, Hands::None] {
                    let difference =
                        agreement(&scene.linear(), hands).expect("a good scene").expect("it has equations");
                    let difference = difference.matrix.max(difference.spectral_radius);
                    assert!(
                        difference < 1e-9,
                        "{law}, {delay} packets of {ticks} ticks, K_T {stiffness}, {hands:?}: {difference:.1e}"
                    );
                }
            }
        }
    }
}

/// A packet each tick: the samples that are outstanding are known, and the line is written down without core. Also where it would be
/// heavier than it may be.
#[test]
fn both_constructions_say_the_same_of_a_line_with_a_time_of_its_own() {
    for ((delay, credit), (carries, most_kg)) in [(0, 1), (0, 4), (1, 2), (8, 9), (8, 12), (20, 40)]
        .into_iter()
        .flat_map(|at| [(at, (0.0, 0.0)), (at, (5.0, 4.0)), (at, (5.0, 0.07))])
    {
        let mut scene = self_timed(1, delay, credit);
        scene.set_number("coordination.carry_damping_n_s_per_m", carries).expect("it is allowed");
        scene.set_number("coordination.most_line_mass_kg", most_kg).expect("it is allowed");
        scene.peer.object.damping_n_s_per_m = 0.3;
        for (stiffness, tautness) in [(400.0, 0.0), (400.0, 0.9), (1e5, 0.0), (1e5, 1.4)] {
            scene.peer.coordination.stiffness_n_per_m = stiffness;
            scene.set_number("coordination.tautness", tautness).expect("it is allowed");
            for hands in [Hands::Both, Hands::One, Hands::None] {
                let difference = agreement(&scene.linear(), hands).expect("a good scene").expect("it has equations");
                let difference = difference.matrix.max(difference.spectral_radius);
                assert!(
                    difference < 1e-9,
                    "delay {delay}, credit {credit}, carries {carries}, {most_kg} kg, K_T {stiffness}, tautness {tautness}, {hands:?}: {difference:.1e}"
                );
            }
        }
    }
    let follows = self_timed(1, 8, 0);
    assert!(agreement(&follows.linear(), Hands::Both).expect("a good scene").is_none(), "k is not known beforehand");
}

/// The longest delay that a scene may have, ticks.
const LONGEST: f64 = 20.0;

/// Random scenes whose two devices hold forces back for whole ticks or fractions more, each as long as it likes.
fn held_back(seed: u64) -> Scene {
    let (mut scene, mut random) = (random::scene(seed), Random::new(!seed));
    let delays = [(); 2].map(|()| {
        let delay = LONGEST * random.unit();
        random.one(&[delay, delay.ceil()])
    });
    let same = random.whole(0, 1) == 0;
    for (key, delay) in ["peer.1.device.force_delay_ticks", "peer.2.device.force_delay_ticks"].into_iter().zip(delays) {
        scene.set_number(key, if same { delays[0] } else { delay }).expect("it is allowed");
    }
    // Most would be unstable otherwise.
    let softer = random.spread(0.01, 1.0);
    scene.peer.contact.stiffness_n_per_m *= softer;
    scene.peer.contact.damping_n_s_per_m *= softer;
    scene
}

#[test]
fn two_constructions_agree_where_devices_hold_forces_back() {
    let (farthest, compared) = (0..400)
        .into_par_iter()
        .map(|seed| {
            let linear = held_back(seed).linear();
            let mut farthest = 0.0_f64;
            for mode in judge(&linear).expect("a good scene").modes {
                let Some(found) = agreement(&linear, mode.mode).expect("a good scene") else { return (0.0, 0) };
                let allowed = if mode.verdict.spectral_radius < 1e3 { 1e-9 } else { 1e-7 };
                assert!(found.matrix < 1e-9 && found.spectral_radius < allowed, "scene {seed}: {found:?} {mode:?}");
                farthest = farthest.max(found.matrix);
            }
            (farthest, 1)
        })
        .reduce(|| (0.0, 0), |a, b| (a.0.max(b.0), a.1 + b.1));
    println!("{compared} scenes: matrices differ by {farthest:.1e} at most");
    assert!(compared > 40, "{compared} of 400 have a second construction");
}
