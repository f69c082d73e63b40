//! Gains at the boundary.

use cohold_analysis::{Effort, Range, limit, verdict};
use cohold_core::num::Fixed;
use cohold_sim::scene::Scene;

use super::setup::{COMMS, growth, scene};

/// m/s: far above the steps of I32F32, far below every limit.
const KICK_M_PER_S: f64 = 0.3;

fn radius(scene: &Scene, stiffness: f64) -> f64 {
    let mut scene = scene.clone();
    scene.peer.coordination.stiffness_n_per_m = stiffness;
    verdict(&scene).expect("a verdict").spectral_radius
}

/// K_T near a crossing at which the spectral radius is `wanted`.
fn stiffness_with(scene: &Scene, crossing: f64, wanted: f64) -> f64 {
    let (mut low, mut high) = (0.99 * crossing, 1.01 * crossing);
    let rises = radius(scene, low) < radius(scene, high);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (radius(scene, middle) < wanted) == rises { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Why: a map is only as good as its edge. At every crossing of the experiments' configuration, pockets included, a
/// millionth inside and a millionth outside, the pair that runs decays or grows as the eigenvalue says: in f64 to 1e-9 of
/// the growth per packet, in f32 to 5e-7, which is what rounding its coefficients moves the boundary by. I32F32 rounds
/// coefficients and states to steps that do not shrink with them: it agrees to 1e-4, and is distinguished at 1e-3.
#[test]
fn a_millionth_inside_and_outside_the_simulation_agrees() {
    for (law, _) in COMMS {
        let scene = scene(&format!("coordination.comm={law}"));
        let range = Range { key: "coordination.stiffness_n_per_m".to_owned(), from: 10.0, to: 13_000.0 };
        let crossings = limit(&scene, range, Effort::default()).expect("a limit").crossings;
        assert!(!crossings.is_empty());
        for crossing in crossings {
            for off in [-1e-6, 1e-6] {
                let linear = with_radius(&scene, crossing, 1.0 + off);
                let known = verdict(&linear).expect("a verdict").spectral_radius;
                let double = growth::<f64>(&linear, KICK_M_PER_S, 30_000, 30_000);
                let single = growth::<f32>(&linear, KICK_M_PER_S, 30_000, 30_000);
                println!(
                    "{law} K_T = {:.3} N/m: rho - 1 = {:.6e}; f64 {:.6e}, f32 {:.3e}",
                    linear.peer.coordination.stiffness_n_per_m,
                    known - 1.0,
                    double - 1.0,
                    single - 1.0
                );
                assert!((known - 1.0 - off).abs() < 1e-10, "{known}");
                assert!((double - known).abs() < 1e-9, "f64 {double}, eigenvalue {known}");
                assert!((single - known).abs() < 5e-7, "f32 {single}, eigenvalue {known}");
                assert_eq!([double > 1.0, single > 1.0], [off > 0.0; 2]);
            }
            for off in [-1e-3, 1e-3] {
                let linear = with_radius(&scene, crossing, 1.0 + off);
                let known = verdict(&linear).expect("a verdict").spectral_radius;
                let fixed = growth::<Fixed>(&linear, KICK_M_PER_S, 3000, 2000);
                println!("{law} near {crossing:.1} N/m: rho - 1 = {:.4e}; i32f32 {:.4e}", known - 1.0, fixed - 1.0);
                assert!((fixed - known).abs() < 1e-4, "i32f32 {fixed}, eigenvalue {known}");
                assert_eq!(fixed > 1.0, off > 0.0);
            }
        }
    }
}

fn with_radius(scene: &Scene, crossing: f64, radius: f64) -> Scene {
    let mut linear = scene.linear();
    linear.peer.coordination.stiffness_n_per_m = stiffness_with(scene, crossing, radius);
    linear
}
