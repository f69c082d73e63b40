//! Copies of mass m at their mean: the frequency and the places of Rakhsha and Constantinescu's comparison, beside the power-domain law.

use cohold_core::settings::Settings;

use super::period;
use crate::two_copies::{Copies, SOFT, settings};

const K: f64 = 500.0;

fn scene(law: &'static str, ticks_per_packet: f64, damping: f64) -> Settings {
    settings(
        law,
        &[
            ("coordination.stiffness_n_per_m", K),
            ("coordination.damping_n_s_per_m", damping),
            ("contact.stiffness_n_per_m", SOFT),
            ("contact.damping_n_s_per_m", 0.0),
            ("timing.ticks_per_packet", ticks_per_packet),
        ],
    )
}

/// Pushed apart and let go, the copies swing against each other at √(K_T/m_O), and by the power-domain law at √(2K_T/m_O): the ratio is √N, whatever K_T is.
#[test]
fn copies_swing_against_each_other_as_one_copy_at_a_wall() {
    let swings = |law| {
        let mut copies = Copies::<f64>::new(&scene(law, 1.0, 0.0), 0);
        let distance_m: Vec<f64> = (0..20_000)
            .map(|tick| {
                let push = if tick < 100 { 1e-3 } else { 0.0 };
                let [one, two] = copies.pushed([push, -push]).map(|seen| seen.object);
                one.position - two.position
            })
            .collect();
        std::f64::consts::TAU / period(&distance_m[200..])
    };
    let (mean, power) = (swings("average-position"), swings("power"));
    let closed = (K / 0.3).sqrt();
    assert!((mean / closed - 1.0).abs() < 1e-3, "{mean} rad/s, {closed} by the paper");
    assert!((power / (closed * 2.0_f64.sqrt()) - 1.0).abs() < 0.03, "{power} rad/s");
}

/// However stiff and however rare the packets: against each other the mean does not move, so that the swing is a midpoint mass at a spring, which neither
/// grows nor decays. The power-domain law is unstable there.
#[test]
fn the_swing_about_the_mean_is_stable_at_every_gain_without_delay() {
    for packet in [1.0, 8.0, 64.0] {
        let swing = |law: &'static str| {
            let mut scene = scene(law, packet, 0.0);
            scene.coordination.stiffness_n_per_m = 2e4;
            let mut copies = Copies::<f64>::new(&scene, 0);
            let distance_m: Vec<f64> = (0..8000)
                .map(|tick| {
                    let push = if tick < 10 { 1e-3 } else { 0.0 };
                    let [one, two] = copies.pushed([push, -push]).map(|seen| seen.object);
                    (one.position - two.position).abs()
                })
                .collect();
            let largest = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
            largest(&distance_m) / largest(&distance_m[..200])
        };
        let mean = swing("average-position");
        assert!(mean < 1.02, "{packet} ticks a packet: grew {mean} times");
        let power = swing("power");
        assert!(power > 10.0, "{packet} ticks a packet: {power} times");
    }
}

/// Two hands that push F against each other: each copy stands F/K_T from the mean, the copies 2F/K_T apart, the mean where it was.
#[test]
fn copies_stand_about_their_mean() {
    let mut copies = Copies::<f64>::new(&scene("average-position", 8.0, 20.0), 2);
    let pushed = (0..20_000).map(|_| copies.pushed([1.0, -1.0])).last().expect("ticks");
    let [one, two] = pushed.map(|seen| seen.object);
    let distance_m = one.position - two.position;
    assert!((distance_m / (2.0 / (K + SOFT)) - 1.0).abs() < 1e-4, "{distance_m} m apart");
    assert!((one.position + two.position).abs() < 1e-9);
}
