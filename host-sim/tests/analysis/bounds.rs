//! With the implicit decode and no object delay, K_T has no upper bound: where the contact alone is stable, so is the pair.
//!
//! True up to 1e6 N/m for the exact and the semi-implicit object, on every scene tried. Not quite for forward Euler, which
//! adds energy of its own: a traditional wave line then has a narrow, weakly unstable pocket (ρ − 1 < 7e-4).

use haptic_core::couple::LawName;
use haptic_core::couple::wave::Decode;
use haptic_core::object::IntegratorName;
use host_sim::analysis::{Effort, Limit, Range, figure4, limit, verdict};
use host_sim::scene::SceneFile;
use rayon::prelude::*;

fn scene(comm: LawName, integrator: IntegratorName, delay: u32, device_delay: f64, contact: f64) -> SceneFile {
    let mut scene = figure4::scene(comm, delay);
    scene.peer.coordination.decode = Decode::Implicit;
    scene.peer.object.integrator = integrator;
    scene.peer.object.force_delay_ticks = 0.0;
    scene.peer.contact.stiffness_n_per_m = contact;
    scene.world.device.force_delay_ticks = device_delay;
    scene
}

fn along(scene: &SceneFile) -> Limit {
    let range = Range { key: "coordination.stiffness_n_per_m".to_owned(), from: 0.0, to: 1e6 };
    limit(scene, range, Effort { steps: 120, tolerance: 1e-3 }).unwrap()
}

/// The contact alone, without coordination: against a copy that is free (K_T → 0) and against one that cannot move
/// (K_T → ∞, where the line holds it). A device that chatters on a wall does so behind any decode.
fn contact_is_stable(scene: &SceneFile) -> bool {
    let mut free = scene.clone();
    free.peer.coordination.comm = LawName::Free;
    let mut wall = free.clone();
    wall.peer.object.mass_kg = 1000.0;
    verdict(&free).unwrap().stable && verdict(&wall).unwrap().stable
}

/// Every scene of the given integrators with the contact alone stable, and the crossings of K_T there.
fn all(integrators: &[IntegratorName]) -> Vec<(SceneFile, Limit)> {
    let mut scenes = Vec::new();
    for comm in [LawName::Wave, LawName::PassiveWave] {
        for &integrator in integrators {
            for delay in 0..=8 {
                for device_delay in [0.0, 0.5, 1.0] {
                    for contact in [100.0, 600.0, 1000.0, 1700.0, 3000.0] {
                        for mass in [0.3, 0.6] {
                            let mut scene = scene(comm, integrator, delay, device_delay, contact);
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
    let all = all(&[IntegratorName::SemiImplicit, IntegratorName::Exact]);
    assert!(all.len() > 500, "{}", all.len());
    for (scene, limit) in all {
        assert!(limit.stable_at_start && limit.crossings.is_empty(), "{limit:?}\n{scene:?}");
    }
}

#[test]
fn forward_euler_is_the_counter_example() {
    let unstable: Vec<(SceneFile, Limit)> =
        all(&[IntegratorName::ForwardEuler]).into_iter().filter(|(_, limit)| !limit.crossings.is_empty()).collect();
    assert!(!unstable.is_empty());
    for (scene, Limit { stable_at_start, crossings, .. }) in unstable {
        let (comm, delay) = (scene.peer.coordination.comm, scene.world.network.one_way_delay_packets);
        let mut worst = 0.0_f64;
        for pocket in crossings.chunks(2) {
            let mut inside = scene.clone();
            inside.peer.coordination.stiffness_n_per_m = pocket.iter().sum::<f64>() / pocket.len() as f64;
            worst = worst.max(verdict(&inside).unwrap().spectral_radius - 1.0);
        }
        println!(
            "{comm:?}, n_t {delay}, m_O {}, K_LC {}, device delay {}: unstable between K_T = {crossings:.0?}, ρ − 1 up to {worst:.1e}",
            scene.peer.object.mass_kg, scene.peer.contact.stiffness_n_per_m, scene.world.device.force_delay_ticks
        );
        assert!(stable_at_start && crossings.len() % 2 == 0, "a pocket closes again: {crossings:?}");
        assert_eq!(comm, LawName::Wave);
        assert!(worst < 1e-2, "{worst}");
    }
}
