//! Gains at the boundary.

use haptic_core::scalar::{Fixed, Scalar};
use host_sim::analysis::{Effort, Range, limit, verdict};
use host_sim::scene::SceneFile;

use super::setup::{COMMS, growth, scene};

const K_T: &str = "coordination.stiffness_n_per_m";

fn radius(scene: &SceneFile, stiffness: f64) -> f64 {
    let mut scene = scene.clone();
    scene.peer.coordination.stiffness_n_per_m = stiffness;
    verdict(&scene).expect("a verdict").spectral_radius
}

/// K_T near a crossing at which the spectral radius is `wanted`.
fn stiffness_with(scene: &SceneFile, crossing: f64, wanted: f64) -> f64 {
    let (mut low, mut high) = (crossing * 0.99, crossing * 1.01);
    let rising = radius(scene, low) < radius(scene, high);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (radius(scene, middle) < wanted) == rising { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[test]
fn a_millionth_inside_and_outside() {
    for comm in COMMS {
        let scene = scene(&[format!("coordination.comm={comm}")]);
        let range = Range { key: K_T.to_owned(), from: 10.0, to: 13_000.0 };
        let crossings = limit(&scene, range, Effort::default()).expect("a limit").crossings;
        for crossing in crossings {
            for off in [-1e-6, 1e-6] {
                let mut at = scene.linear();
                at.peer.coordination.stiffness_n_per_m = stiffness_with(&scene, crossing, 1.0 + off);
                let known = verdict(&at).expect("a verdict").spectral_radius;
                fn measured<S: Scalar>(at: &SceneFile) -> f64 {
                    growth::<S>(at, 1e-3, 30_000, 30_000)
                }
                let all = [measured::<f64>(&at), measured::<f32>(&at), measured::<Fixed>(&at)];
                println!(
                    "{comm} K_T {:.3}: rho-1 eigenvalue {:.6e} f64 {:.6e} f32 {:.3e} fixed {:.3e}",
                    at.peer.coordination.stiffness_n_per_m,
                    known - 1.0,
                    all[0] - 1.0,
                    all[1] - 1.0,
                    all[2] - 1.0
                );
            }
        }
    }
}
