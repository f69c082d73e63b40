//! Encoders from 16 to 24 bit per metre, read through a counter of 16 bit.

use cohold_core::num::Fixed;
use cohold_core::safety::Fault;
use cohold_sim::pair::Pair;
use cohold_sim::peers::Number;
use cohold_sim::run::{Options, Outcome, run};
use cohold_sim::scene::Scene;

use super::setup::{COMMS, scene};

const BITS_PER_M: [i32; 5] = [16, 18, 20, 22, 24];
const ESTIMATORS: [&str; 3] = ["difference", "filtered", "adaptive"];

/// The largest encoder.max_speed_m_per_s at which the counter cannot wrap unseen: the step that is believed, 1.25 times the
/// fastest and two counts of rounding, is then less than half of 2¹⁶ counts.
fn fastest_m_per_s(counts_per_m: f64) -> f64 {
    f64::min(10.0, (32_767.0 - 2.0) / (1.25 * 1e-3 * counts_per_m))
}

fn sensing(bits: i32, estimator: &str) -> String {
    let counts_per_m = 2.0_f64.powi(bits);
    let fastest = fastest_m_per_s(counts_per_m);
    format!(
        "plant.encoder=true encoder.counts_per_m={counts_per_m} axis.velocity={estimator} \
         encoder.max_speed_m_per_s={fastest} safety.max_speed_m_per_s={fastest}"
    )
}

/// A free device under a push: how far the peer is from the truth at worst (counts, and what rounding may add), how far
/// the device went (m).
fn tracked<S: Number>(scene: &Scene, ulp: f64) -> f64 {
    let mut pair = Pair::<S>::new(scene).expect("a good scene");
    let counts_per_m = scene.peer.encoder.counts_per_m;
    let mut travel_m = 0.0_f64;
    for _ in 0..800 {
        let truth = pair.sides()[0].plant.motions()[0].position;
        pair.step();
        let error_m = (pair.sides()[0].peer.observed()[0].device.position.to_f64() - truth).abs();
        assert!(error_m <= 1.0 / counts_per_m + ulp * truth.abs(), "{error_m} m off at {truth} m in {}", S::NAME);
        travel_m = travel_m.max(truth.abs());
    }
    assert_eq!(pair.fault(), None);
    travel_m
}

/// Why: at 24 bit per metre the counter wraps every 4 mm. At 0.9 of the fastest speed, through as many as 250 wraps, the
/// peer knows where it is to one count; in f32 to its rounding, two parts in 2²⁴ of the way.
#[test]
fn positions_survive_wraps_at_every_resolution() {
    let free = "contact.stiffness_n_per_m=0 contact.damping_n_s_per_m=0 coordination.comm=none";
    for bits in BITS_PER_M {
        for estimator in ESTIMATORS {
            // Device damping is 1 N·s/m: the push is the speed that it ends at.
            let push_n = 0.9 * fastest_m_per_s(2.0_f64.powi(bits));
            let scene = scene(&format!("{} {free} user.1.push_n={push_n}", sensing(bits, estimator)));
            let travel_m = tracked::<f64>(&scene, 1e-15);
            tracked::<f32>(&scene, 2.0_f64.powi(-23));
            tracked::<Fixed>(&scene, 2.0_f64.powi(-32));
            println!("2^{bits}/m, {estimator}: {push_n:.2} m/s, {:.0} wraps", travel_m * 2.0_f64.powi(bits - 16));
        }
    }
}

/// Why: a motion of more than half a turn of the counter in a tick looks like a slower one the other way. At 5 m/s and
/// 24 bit per metre the peer was 8 m wrong and did not know. Settings that let this happen are refused by name; at the
/// largest speed that is allowed, going faster is a fault.
#[test]
fn a_wrap_that_nobody_could_see_is_refused() {
    for bits in [22, 24] {
        let counts_per_m = 2.0_f64.powi(bits);
        let overrides = ["plant.encoder=true", "axis.velocity=difference"].map(str::to_owned);
        let resolution = format!("encoder.counts_per_m={counts_per_m}");
        let refused = Scene::load(cohold_guest_laws::laws(), None, &[overrides.to_vec(), vec![resolution]].concat())
            .unwrap_err()
            .to_string();
        assert!(refused.contains("encoder.max_speed_m_per_s = 10 is not allowed"), "{refused}");
        let fastest = fastest_m_per_s(counts_per_m);
        let too_fast = scene(&format!(
            "{} contact.stiffness_n_per_m=0 contact.damping_n_s_per_m=0 user.1.push_n={}",
            sensing(bits, "difference"),
            3.0 * fastest
        ));
        let mut pair = Pair::<f32>::new(&too_fast).expect("a good scene");
        (0..500).for_each(|_| pair.step());
        let fault = pair.fault();
        assert!(matches!(fault, Some((1, Fault::Overspeed | Fault::EncoderJump))), "{fault:?}");
        println!("2^{bits}/m: at most {fastest:.3} m/s; refused otherwise: {refused}");
    }
}

/// Why: one count is 15 µm at one end and 60 nm at the other, 15 mm/s and 60 µm/s of noise on a difference. Cooperation
/// must not notice: against exact positions the decoded discrepancy is within 0.5 %, the true one within 1 %, and the force
/// no noisier than by 20 % (16 bit, adaptive; 5 % from 20 bit on), in every number type.
#[test]
fn cooperation_is_the_same_at_every_resolution() {
    let users = "user.1.push_n=1 user.2.push_n=1 user.2.sine_n=0.25";
    let options = Options { duration_s: 6.0, record_every: 0 };
    for (law, stiffness) in COMMS {
        let base = format!("coordination.comm={law} coordination.stiffness_n_per_m={stiffness} {users}");
        for estimator in ESTIMATORS {
            // The same estimator, so that its lag is not taken for coarseness; the adaptive one, whose window follows the
            // resolution, is a difference where there is no end to that.
            let alike = if estimator == "adaptive" { "difference" } else { estimator };
            let exact = run::<f64>(&scene(&format!("{base} axis.velocity={alike}")), options, &|_| {});
            let exact = exact.expect("a good scene");
            for bits in BITS_PER_M {
                let scene = scene(&format!("{base} {}", sensing(bits, estimator)));
                let differs = |outcome: Result<Outcome, _>| {
                    let outcome = outcome.expect("a good scene");
                    assert!(outcome.bounded, "{law} 2^{bits} {estimator}");
                    let ratio = |a: f64, b: f64| a / b - 1.0;
                    [
                        ratio(outcome.whole.decoded_discrepancy_mm, exact.whole.decoded_discrepancy_mm),
                        ratio(outcome.whole.true_discrepancy_mm, exact.whole.true_discrepancy_mm),
                        ratio(outcome.whole.coordination_force_n.sd, exact.whole.coordination_force_n.sd),
                    ]
                };
                let all = [
                    differs(run::<f64>(&scene, options, &|_| {})),
                    differs(run::<f32>(&scene, options, &|_| {})),
                    differs(run::<Fixed>(&scene, options, &|_| {})),
                ];
                println!(
                    "{law}, 2^{bits}/m, {estimator}: decoded {:+.1e}, true {:+.1e}, force {:+.1e}",
                    all[0][0], all[0][1], all[0][2]
                );
                for difference in all {
                    for (difference, allowed) in
                        difference.into_iter().zip([0.005, 0.01, if bits < 20 { 0.2 } else { 0.05 }])
                    {
                        assert!(difference.abs() < allowed, "{law} 2^{bits} {estimator}: {difference}");
                    }
                }
            }
        }
    }
}
