//! Cogging that the motor cancels: where a device sticks without, what is left of it, and a closed form for both.

use std::f64::consts::TAU;

use cohold_sim::pair::Pair;
use cohold_sim::scene::Scene;

use crate::friction::{WOUND, pulled};

/// Amplitude, N; period, m; damping of the device, N·s/m.
const COGGING_N: f64 = 0.5;
const PERIOD_M: f64 = 0.005;
const DAMPING: f64 = 5.0;

/// A device at a detent, of which the motor cancels so much (N), which its user pulls away from the object.
fn scene(cancelled_n: f64, pull_n: f64, more: &[&str]) -> Scene {
    let own = [
        format!("device.damping_n_s_per_m={DAMPING}"),
        "encoder.index=true".to_owned(),
        format!("plant.cogging_n_or_n_m={COGGING_N}"),
        format!("plant.cogging_at_m_or_rad={}", 0.5 * PERIOD_M),
        format!("motor.cogging_n_or_n_m={cancelled_n}"),
        format!("motor.cogging_period_m_or_rad={PERIOD_M}"),
        format!("motor.cogging_at_m_or_rad={}", 0.5 * PERIOD_M),
    ];
    pulled(pull_n, more, &own)
}

/// Where device 1 is in each of the ticks of three seconds, m.
fn places(scene: &Scene) -> Vec<f64> {
    let mut pair = Pair::<f32>::new(scene).expect("a good scene");
    let ticks = (3.0 / scene.peer.timing.control_period_s).round() as u32;
    let mut place = || {
        pair.step();
        pair.sides()[0].plant.motions()[0].position
    };
    (0..ticks).map(|_| place()).collect()
}

/// At a detent of so much cogging a pull comes to rest where the two are equal, m.
fn rests(pull_n: f64, cogging_n: f64) -> f64 {
    -(pull_n / cogging_n).asin() * PERIOD_M / TAU
}

/// Mean speed over the last second, m/s.
fn speed(places: &[f64]) -> f64 {
    let second = places.len() / 3;
    places[places.len() - 1] - places[places.len() - 1 - second]
}

/// Without: it sticks. With all of it cancelled a pull goes into damping, as if there were none. With nine tenths, what is left is a tenth.
#[test]
fn a_small_pull_moves_a_device_whose_cogging_is_cancelled() {
    for more in [&WOUND[..], &["device.force_delay_ticks=1"], &["timing.control_period_s=0.00025"]] {
        for pull_n in [0.04, 0.2] {
            let stuck = places(&scene(0.0, pull_n, more));
            let (end, exact) = (stuck[stuck.len() - 1], rests(pull_n, COGGING_N));
            assert!((end - exact).abs() < 2e-5, "{more:?}: {end} m, should be {exact}");

            let free = speed(&places(&scene(COGGING_N, pull_n, more)));
            let exact = -pull_n / DAMPING;
            println!("{pull_n} N, {more:?}: {free:.4} m/s, of {exact:.4} without cogging");
            assert!((free - exact).abs() < 0.04 * exact.abs(), "{more:?}: {free} m/s, should be {exact}");
        }
        // Of one that is wrong by a tenth a tenth is left, whichever way.
        for (cancelled, way) in [(0.9, 1.0), (1.1, -1.0)] {
            let left = places(&scene(cancelled * COGGING_N, 0.04, more));
            let (end, exact) = (left[left.len() - 1], rests(0.04, 0.1 * COGGING_N));
            // Too much cancelled makes a detent half a period on.
            let exact = if way > 0.0 { exact } else { exact - 0.5 * PERIOD_M };
            println!("{cancelled}, {more:?}: {:.3} mm, of {:.3}", 1e3 * end, 1e3 * exact);
            // Steps of the encoder and of the duty are up to 4 mN, on a spring of 38 N/m.
            assert!((end - exact).abs() < 1.2e-4, "{cancelled}, {more:?}: {end} m, should be {exact}");
            let moved = speed(&places(&scene(cancelled * COGGING_N, 0.06, more)));
            assert!(moved < -1e-3, "{cancelled}, {more:?}: {moved} m/s");
        }
    }
}

/// A place that is wrong by half a period doubles the cogging, which is why it counts from an index.
#[test]
fn a_wrong_place_doubles_cogging() {
    let wrong = format!("motor.cogging_at_m_or_rad={PERIOD_M}");
    for more in [&WOUND[..], &["device.force_delay_ticks=1"]] {
        let mut scene = scene(COGGING_N, 0.75, more);
        scene.apply_override(&wrong).expect("a good key");
        let places = places(&scene);
        let (end, exact) = (places[places.len() - 1], rests(0.75, 2.0 * COGGING_N));
        assert!((end - exact).abs() < 2e-5, "{more:?}: {end} m, should be {exact}");
    }
}

/// Where cogging pushes away, what cancels it is a spring of k = 2π·A/p that is d late, a tick and a half. A device with more damping than k·d comes
/// to rest there, on a weak spring; one with less hums, within a period.
#[test]
fn damping_has_to_make_up_for_the_delay() {
    let needs = TAU * COGGING_N / PERIOD_M * 1.5e-3;
    let hum = |damping: f64| {
        let mut scene = scene(COGGING_N, 0.005, &["device.force_delay_ticks=1", "user.1.arm_stiffness_n_per_m=50"]);
        let damping = format!("device.damping_n_s_per_m={damping}");
        for key in [
            &damping,
            "plant.cogging_at_m_or_rad=0",
            "motor.cogging_at_m_or_rad=0",
            "contact.stiffness_n_per_m=0",
            "contact.damping_n_s_per_m=0",
        ] {
            scene.apply_override(key).expect("a good key");
        }
        let places = places(&scene);
        let (low, high) =
            places[2000..].iter().fold((f64::MAX, f64::MIN), |(low, high), at| (at.min(low), at.max(high)));
        println!("{damping}, of {needs:.2}: from {:.3} to {:.3} mm", 1e3 * low, 1e3 * high);
        high - low
    };
    // Steps of the encoder move it by a few of them; from a tenth more damping on to a tenth less it is ten times as much.
    assert!(hum(1.1 * needs) < 1e-4);
    for part in [0.8, 0.3] {
        assert!((1e-3..PERIOD_M).contains(&hum(part * needs)), "{part}");
    }
}

/// The plant's own cogging keeps energy: a device without damping oscillates at a detent at √(k/m), as far in the end as at first.
#[test]
fn cogging_is_conservative() {
    let free = ["device.damping_n_s_per_m=0", "plant.encoder=false", "plant.motor=false", "axis.velocity=measured"];
    let mut scene = scene(0.0, 0.05, &[]);
    for key in free {
        scene.apply_override(key).expect("a good key");
    }
    let places = places(&scene);
    let lowest = |places: &[f64]| places.iter().copied().fold(f64::MAX, f64::min);
    let (first, last) = (lowest(&places[..500]), lowest(&places[2500..]));
    assert!((first - last).abs() < 1e-3 * first.abs(), "{first} and then {last} m");
}

#[test]
fn what_cannot_be_cancelled_is_refused() {
    let refused = |key: &str, said: &str| {
        let mut scene = scene(0.1, 0.0, &[]);
        scene.apply_override(key).expect("a good key");
        let why = scene.check("here").expect_err(key).to_string();
        assert!(why.contains(said), "{why}");
    };
    refused(
        "encoder.index=false",
        "motor.cogging_n_or_n_m = 0.1 is not allowed: it must be 0 but with encoder.index = true",
    );
    refused("motor.cogging_n_or_n_m=9", "a number from 0 to 8 N or N·m");
    refused("axis.count=2", "axis.count = 2 is not allowed: it must be 1 with plant.cogging");
}
