//! None missed: the search beside a plain scan of sixteen times as many points, on seventy sweeps of random scenes around the paper's.
//!
//! The scan asks for the verdict at every point and nothing else: no mesh, no prediction, no bracketing. The search must call each of its
//! points what it is. Left out are points nearer to a crossing than the tolerance, and scenes on the circle itself, to rounding.

use cohold_analysis::{Effort, Hands, Range, figure4, judge, limit, verdict};
use cohold_core::names::Choice;
use cohold_core::object::IntegratorName;
use cohold_sim::scene::Scene;
use rayon::prelude::*;

use super::random::Random;

/// Steps of the search: half of those of Figure 4, a tenth of what is usual.
const STEPS: usize = 40;

/// How many times as fine the plain scan is.
const FINER: usize = 16;

/// What is swept.
const KEYS: [(&str, f64, f64); 9] = [
    ("coordination.stiffness_n_per_m", 0.0, 12_000.0),
    ("coordination.stiffness_n_per_m", 10.0, 2e5),
    ("contact.stiffness_n_per_m", 0.0, 10_000.0),
    ("coordination.damping_n_s_per_m", 0.0, 200.0),
    ("contact.damping_n_s_per_m", 0.0, 100.0),
    ("coordination.wave_impedance_n_s_per_m", 1.0, 300.0),
    ("object.mass_kg", 0.01, 5.0),
    ("device.mass_kg", 0.01, 5.0),
    ("network.extra_delay_s", 0.0, 0.1),
];

/// A scene like those of Figure 4, stable somewhere.
fn scene(random: &mut Random) -> Scene {
    let mut scene = figure4::scene(random.one(&figure4::COMMS), random.whole(0, 5));
    let peer = &mut scene.peer;
    peer.timing.ticks_per_packet = random.one(&[1, 4, 8, 8, 16]);
    peer.contact.stiffness_n_per_m = random.spread(100.0, 2500.0);
    peer.coordination.stiffness_n_per_m = random.spread(50.0, 5000.0);
    peer.coordination.wave_impedance_n_s_per_m = random.spread(3.0, 50.0);
    peer.object.mass_kg = random.spread(0.1, 1.0);
    peer.object.force_delay_ticks = random.one(&[0.0, 0.5, 1.0, 1.0]);
    peer.object.integrator =
        random.one(&[IntegratorName::ForwardEuler, IntegratorName::SemiImplicit, IntegratorName::Exact]);
    scene.world.device.mass_kg = random.spread(0.03, 0.5);
    scene.world.device.damping_n_s_per_m = random.spread(0.3, 3.0);
    scene.world.device.force_delay_ticks = random.one(&[0.0, 0.5, 1.0]);
    scene
}

/// Points that the search and the plain scan call differently, and crossings found.
fn sweep(seed: u64) -> (Vec<String>, usize, usize) {
    let (key, from, to) = KEYS[seed as usize % KEYS.len()];
    let mut random = Random::new(seed);
    let hands = random.one(&[Some(Hands::Both), Some(Hands::Both), Some(Hands::One), Some(Hands::None), None]);
    let tolerance = 1e-3;
    let mut scene = scene(&mut random);
    let range = Range { key: key.to_owned(), from, to };
    let found = limit(&scene, range, Effort { steps: STEPS, tolerance, hands }).unwrap();
    let count = FINER * STEPS / 2;
    let share = |at: usize| at as f64 / count as f64;
    let near = from.max(1e-6 * to);
    let linear = (0..=count).map(|at| from + (to - from) * share(at));
    let ratios = (0..count).map(|at| near * (to / near).powf(share(at)));
    let wrong = linear.chain(ratios).filter_map(|value| {
        scene.set_number(key, value).unwrap();
        let verdict = match hands {
            Some(Hands::Both) => verdict(&scene).unwrap(),
            None => judge(&scene).unwrap().worst,
            Some(hands) => judge(&scene).unwrap().modes.iter().find(|mode| mode.mode == hands).unwrap().verdict,
        };
        let at_crossing = found.crossings.iter().any(|crossing| (crossing / value - 1.0).abs() < 2.0 * tolerance);
        let on_circle = (verdict.spectral_radius - 1.0).abs() < 1e-8;
        let wrong = found.is_stable(value) != verdict.stable && !at_crossing && !on_circle;
        let hands = hands.map_or("every mode", Hands::name);
        wrong.then(|| {
            format!("scene {seed}, {hands}, {key} = {value}: {} {:?}", verdict.spectral_radius, found.crossings)
        })
    });
    (wrong.collect(), found.crossings.len(), found.evaluations)
}

#[test]
fn none_is_missed_that_a_scan_sixteen_times_as_fine_finds() {
    let all: Vec<_> = (0..70_u64).into_par_iter().map(sweep).collect();
    let wrong: Vec<&String> = all.iter().flat_map(|(wrong, ..)| wrong).collect();
    let (crossings, radii) = all.iter().fold((0, 0), |sum, (_, crossings, radii)| (sum.0 + crossings, sum.1 + radii));
    println!("{crossings} crossings with {radii} radii");
    assert!(wrong.is_empty(), "{} points called wrongly: {wrong:#?}", wrong.len());
    assert!(crossings >= 50, "{crossings} crossings prove nothing");
}
