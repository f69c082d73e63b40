//! With the implicit decode and no object delay, K_T has no upper bound: where the contact alone is stable, so is the pair.
//!
//! True up to 1e6 N/m on every scene tried around the paper's (b = 10, B_T = 2, M = 8, copies of 0.3 and 0.6 kg) for the exact
//! and the semi-implicit object. It is no law of nature; the counter-examples below are printed with their reasons:
//!
//! * **Forward Euler** adds energy of its own (k·T²/m of an oscillation's each tick): weakly unstable pockets.
//! * **Light copies**: the line and the spring damp the copy with b and B_T, explicitly. What explicit damping can take off
//!   in a tick is bounded: max(b, B_T)·T_c must stay below about m_O, below half of it for forward Euler.
//! * **A held wave is not a passive one**: u_in is repeated M times, and the one-pole filter does not take off enough for a
//!   heavy copy on a line with little else to damp it: pockets at tens of rad/s, weak ones. At M = 1 there are none.
//! * **M = 1 without a filter**: nothing damps the fastest oscillation that K_T and the copy can make, and the object is
//!   integrated explicitly: an upper bound where K_T·T_c²/m_O is a few tenths.

use cohold_analysis::{Effort, Limit, Range, figure4, limit, verdict};
use cohold_core::law::wave::Decode;
use cohold_core::object::IntegratorName;
use cohold_sim::scene::Scene;
use rayon::prelude::*;

fn scene(law: &'static str, integrator: IntegratorName, delay: u32, device_delay: f64, contact: f64) -> Scene {
    let mut scene = figure4::scene(law, delay);
    scene.peer.coordination.decode = Decode::Implicit;
    scene.peer.object.integrator = integrator;
    scene.peer.object.force_delay_ticks = 0.0;
    scene.peer.contact.stiffness_n_per_m = contact;
    scene.world.device.force_delay_ticks = device_delay;
    scene
}

fn along(scene: &Scene) -> Limit {
    let range = Range { key: "coordination.stiffness_n_per_m".to_owned(), from: 0.0, to: 1e6 };
    limit(scene, range, Effort { steps: 80, tolerance: 1e-3, ..Effort::default() }).unwrap()
}

/// The contact alone, without coordination: against a copy that is free (K_T → 0) and against one that cannot move
/// (K_T → ∞, where the line holds it). A device that chatters on a wall does so behind any decode.
fn contact_is_stable(scene: &Scene) -> bool {
    let mut free = scene.clone();
    free.peer.coordination.comm = "none";
    let mut wall = free.clone();
    wall.peer.object.mass_kg = 1000.0;
    verdict(&free).unwrap().stable && verdict(&wall).unwrap().stable
}

/// Every scene of the given integrators with the contact alone stable, and the crossings of K_T there.
fn all(integrators: &[IntegratorName], delays: &[u32]) -> Vec<(Scene, Limit)> {
    let mut scenes = Vec::new();
    for law in ["wave", "passive-wave"] {
        for &integrator in integrators {
            for &delay in delays {
                for device_delay in [0.0, 0.5, 1.0] {
                    for contact in [100.0, 600.0, 1000.0, 1700.0, 3000.0] {
                        for mass in [0.3, 0.6] {
                            let mut scene = scene(law, integrator, delay, device_delay, contact);
                            scene.peer.object.mass_kg = mass;
                            scenes.push(scene);
                        }
                    }
                }
            }
        }
    }
    scenes
        .into_par_iter()
        .filter(contact_is_stable)
        .map(|scene| {
            let limit = along(&scene);
            (scene, limit)
        })
        .collect()
}

#[test]
fn implicit_has_no_upper_bound() {
    let all = all(&[IntegratorName::SemiImplicit, IntegratorName::Exact], &[0, 1, 2, 3, 4, 5, 6, 7, 8]);
    assert!(all.len() > 500, "{}", all.len());
    for (scene, limit) in all {
        assert!(limit.stable_at_start && limit.crossings.is_empty(), "{limit:?}\n{scene:?}");
    }
}

fn describe(scene: &Scene) -> String {
    let (peer, device) = (&scene.peer, &scene.world.device);
    format!(
        "{:?} {:?}, n_t {}, M {}, m_O {}, b {}, K_LC {}, device delay {}",
        peer.coordination.comm,
        peer.object.integrator,
        scene.world.network.one_way_delay_packets,
        peer.timing.ticks_per_packet,
        peer.object.mass_kg,
        peer.coordination.wave_impedance_n_s_per_m,
        peer.contact.stiffness_n_per_m,
        device.force_delay_ticks
    )
}

/// One scene for each of the other reasons at the top, and what mends it.
#[test]
fn the_other_counter_examples() {
    // The matched line's copies with an exact object: b·T_c/m_O = 2.
    let mut light = scene("passive-wave", IntegratorName::Exact, 1, 1.0, 1000.0);
    light.peer.object.mass_kg = 0.02;
    light.peer.coordination.wave_impedance_n_s_per_m = 40.0;
    let mut heavier = light.clone();
    heavier.peer.object.mass_kg = 0.08;

    // A heavy copy, little damping, a packet in eight: ω = √(K_T/m_O) is 60 to 90 rad/s in the pocket.
    let mut held = scene("passive-wave", IntegratorName::SemiImplicit, 1, 0.28, 1100.0);
    held.peer.object.mass_kg = 0.49;
    held.peer.coordination.wave_impedance_n_s_per_m = 8.7;
    held.peer.coordination.damping_n_s_per_m = 0.82;
    held.peer.contact.damping_n_s_per_m = 0.58;
    (held.world.device.mass_kg, held.world.device.damping_n_s_per_m) = (0.48, 0.36);
    let mut every_tick = held.clone();
    every_tick.peer.timing.ticks_per_packet = 1;

    // No filter and nothing held.
    let mut bare = scene("wave", IntegratorName::SemiImplicit, 1, 1.0, 600.0);
    bare.peer.timing.ticks_per_packet = 1;
    let mut filtered = bare.clone();
    filtered.peer.coordination.comm = "passive-wave";

    for (broken, mended, odd) in [(light, heavier, true), (held, every_tick, false), (bare, filtered, true)] {
        let found = along(&broken);
        println!("{}: crossings at K_T = {:.0?}", describe(&broken), found.crossings);
        assert!(contact_is_stable(&broken) && found.stable_at_start && !found.crossings.is_empty());
        assert_eq!(found.crossings.len() % 2 == 1, odd, "{:?}", found.crossings);
        let good = along(&mended);
        assert!(good.stable_at_start && good.crossings.is_empty(), "{}: {good:?}", describe(&mended));
    }
}

#[test]
fn forward_euler_is_the_counter_example() {
    let all = all(&[IntegratorName::ForwardEuler], &[0, 1, 8]);
    let unstable: Vec<(Scene, Limit)> = all.into_iter().filter(|(_, limit)| !limit.crossings.is_empty()).collect();
    assert!(!unstable.is_empty());
    for (scene, Limit { stable_at_start, crossings, .. }) in unstable {
        let mut worst = 0.0_f64;
        for pocket in crossings.chunks(2) {
            let mut inside = scene.clone();
            inside.peer.coordination.stiffness_n_per_m = pocket.iter().sum::<f64>() / pocket.len() as f64;
            worst = worst.max(verdict(&inside).unwrap().spectral_radius - 1.0);
        }
        println!("{}: unstable between K_T = {crossings:.0?}, ρ − 1 up to {worst:.1e}", describe(&scene));
        assert!(stable_at_start && crossings.len() % 2 == 0, "a pocket closes again: {crossings:?}");
        assert!(worst < 1e-2, "{worst}");
    }
}
