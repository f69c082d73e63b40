//! The simulator's envelope grows where the analysis says unstable, and shrinks where it says stable.
//!
//! 1,000 random scenes with |ρ − 1| > 1e-3 start from a random state of 2⁻²⁰⁰ units, so that no limit is touched however
//! much grows. Watched are velocities and forces: positions keep the translation of a rest mode.

use haptic_analysis::{Analyser, Verdict};
use haptic_core::num::StateVector;
use haptic_sim::pair::Pair;
use haptic_sim::scene::Scene;
use rayon::prelude::*;

use super::random::{self, Random};

const SCENES: usize = 1000;

/// e-foldings between start and end, by the spectral radius.
const FOLDINGS: f64 = 16.0;

/// Velocities and forces of both peers, the largest over some packet periods.
fn envelope(pair: &mut Pair<f64>, ticks: u64) -> f64 {
    let mut largest = 0.0_f64;
    for _ in 0..ticks {
        pair.step();
        for side in pair.sides() {
            let seen = side.peer.observed()[0];
            for size in [seen.device.velocity, seen.object.velocity, seen.contact_force, seen.coordination_force] {
                largest = largest.max(size.abs());
            }
        }
    }
    largest
}

/// Whether the simulated pair settles; `None` where it does neither.
pub(crate) fn settles(linear: &Scene, verdict: &Verdict, seed: u64) -> Option<bool> {
    let mut pair = Pair::<f64>::new(linear).unwrap();
    let mut random = Random::new(!seed);
    let mut random = || (random.unit() - 0.5) * 2.0_f64.powi(-200);
    for side in pair.sides_mut() {
        side.peer.visit(&mut |number: &mut f64| *number = random());
        let (motion, motor) = side.plant.free_axis();
        (motion.position, motion.velocity, *motor) = (random(), random(), random());
    }
    let ticks = u64::from(linear.peer.timing.ticks_per_packet);
    let least = 8.0 * f64::from(linear.world.network.one_way_delay_packets + 1);
    let periods = (FOLDINGS / verdict.spectral_radius.ln().abs()).clamp(least, 1e6) as u64;
    let window = (periods / 8).max(1) * ticks;
    let between = periods / 2 * ticks - window;
    let start = envelope(&mut pair, window);
    envelope(&mut pair, between);
    let middle = envelope(&mut pair, window);
    envelope(&mut pair, between);
    let end = envelope(&mut pair, window);
    if pair.fault().is_some() || end > 7.0 * middle {
        Some(false)
    } else if end * 7.0 < middle || end < 1e-6 * start {
        Some(true)
    } else {
        None
    }
}

#[test]
fn the_simulator_agrees_on_a_thousand_scenes() {
    let scenes: Vec<(u64, Scene, Verdict)> = (1_000_000..1_004_000_u64)
        .into_par_iter()
        .map_init(Analyser::default, |analyser, seed| {
            let linear = random::scene(seed).linear();
            let verdict = analyser.verdict(&linear).unwrap();
            (seed, linear, verdict)
        })
        // Packets that are not used for their age leave nothing to judge.
        .filter(|(_, _, verdict)| verdict.not_judged_because.is_none() && (verdict.spectral_radius - 1.0).abs() > 1e-3)
        .collect();
    assert!(scenes.len() >= SCENES, "only {} scenes", scenes.len());
    scenes[..SCENES].par_iter().for_each(|(seed, linear, verdict)| {
        assert_eq!(settles(linear, verdict, *seed), Some(verdict.stable), "scene {seed}: {verdict:?}\n{linear:?}");
    });
    let stable = scenes[..SCENES].iter().filter(|(_, _, verdict)| verdict.stable).count();
    assert!(stable > 200 && stable < 800, "{stable} of {SCENES} are stable");
}
