//! Velocity estimators against exact integers, closed forms and each other.

use core::f64::consts::TAU;

use cohold_core::device::velocity::AnyVelocity;
use cohold_core::device::velocity::adaptive::SLACK;
use cohold_core::num::{Fixed, Motion, Scalar, StateVector};
use cohold_core::settings::{Settings, Value};
use proptest::prelude::*;

use super::{number, settings};

const PERIOD_S: f64 = 0.001;
const COUNT_M: f64 = 1.0 / 200_000.0;

fn named(name: &'static str) -> Settings {
    settings(&[("axis.velocity", Value::Text(name))])
}

/// The estimates for a row of positions, started at rest at the first.
fn estimates<S: Scalar>(settings: &Settings, positions: &[f64]) -> Vec<f64> {
    let mut model = AnyVelocity::<S>::build(settings).expect("good settings");
    model.start(Motion::at(S::from_f64(positions[0])));
    positions.iter().map(|x| model.step(Motion::at(S::from_f64(*x))).to_f64()).collect()
}

#[test]
fn measured_passes_the_reading_on() {
    let mut model = AnyVelocity::<f64>::build(&named("measured")).expect("good settings");
    assert_eq!(model.step(Motion { position: 3.0, velocity: -0.25 }), -0.25);
}

fn uniform_motion_is_exact<S: Scalar>(tolerance: f64) {
    for name in ["measured", "difference", "filtered", "adaptive"] {
        for speed in [0.0, 0.013, -0.8, 5.0] {
            let mut model = AnyVelocity::<S>::build(&named(name)).expect("good settings");
            for tick in 0..40 {
                let position = 0.1 + speed * PERIOD_S * f64::from(tick);
                let reading = Motion { position: S::from_f64(position), velocity: S::from_f64(speed) };
                if tick == 0 {
                    model.start(reading);
                }
                let error = model.step(reading).to_f64() - speed;
                assert!(error.abs() < tolerance, "{name} {speed} {tick}: {error}");
            }
        }
    }
}

#[test]
fn uniform_motion_is_exact_from_the_first_reading_on() {
    uniform_motion_is_exact::<f64>(1e-12);
    uniform_motion_is_exact::<f32>(1e-4);
    uniform_motion_is_exact::<Fixed>(1e-6);
}

#[test]
fn filtered_answers_a_ramp_with_one_exponential() {
    let positions: Vec<f64> = (0..60).map(|tick| 0.2 * PERIOD_S * f64::from(tick)).collect();
    for (tick, velocity) in estimates::<f64>(&named("filtered"), &positions).iter().enumerate() {
        let expected = 0.2 * (1.0 - (-TAU * 100.0 * PERIOD_S * tick as f64).exp());
        assert!((velocity - expected).abs() < 1e-12, "{tick}: {velocity} {expected}");
    }
}

#[test]
fn filtered_lags_constant_acceleration_by_the_stated_time() {
    let positions: Vec<f64> = (0..200).map(|tick| 0.5 * 2.0 * (PERIOD_S * f64::from(tick)).powi(2)).collect();
    let last = *estimates::<f64>(&named("filtered"), &positions).last().unwrap();
    let lag_s = 0.199 - last / 2.0;
    assert!((lag_s - (PERIOD_S / 2.0 + PERIOD_S / (TAU * 100.0 * PERIOD_S).exp_m1())).abs() < 1e-9, "{lag_s}");
}

#[test]
fn adaptive_stands_still_while_a_position_dithers_between_two_counts() {
    let positions: Vec<f64> = (0..64).map(|tick| COUNT_M * f64::from(7 + tick % 2)).collect();
    let even: Vec<f64> = estimates::<f64>(&named("adaptive"), &positions).split_off(32);
    assert!(even.iter().all(|velocity| velocity.abs() <= COUNT_M / (15.0 * PERIOD_S)), "{even:?}");
    let difference = estimates::<f64>(&named("difference"), &positions);
    assert!(difference[40].abs() > 0.99 * COUNT_M / PERIOD_S);
}

#[test]
fn adaptive_follows_a_reversal_at_once() {
    let mut positions: Vec<f64> = (0..40).map(|tick| COUNT_M * f64::from(20 * tick)).collect();
    positions.extend((0..3).map(|tick| COUNT_M * f64::from(20 * (38 - tick))));
    let velocities = estimates::<f64>(&named("adaptive"), &positions);
    assert!((velocities[39] - 20.0 * COUNT_M / PERIOD_S).abs() < 1e-9);
    assert!((velocities[40] + 20.0 * COUNT_M / PERIOD_S).abs() < 1e-9);
}

/// Root mean square velocity error on a quantised sinusoid of 10 mm.
fn sinusoid_error(name: &'static str, counts_per_m: f64, frequency_hz: f64) -> f64 {
    let at = |tick: usize| TAU * frequency_hz * PERIOD_S * tick as f64;
    let positions: Vec<f64> =
        (0..4100).map(|tick| (0.01 * at(tick).sin() * counts_per_m).round() / counts_per_m).collect();
    let settings = settings(&[("axis.velocity", Value::Text(name)), ("encoder.counts_per_m", number(counts_per_m))]);
    let velocities = estimates::<f64>(&settings, &positions);
    let speed = |tick: usize| 0.01 * TAU * frequency_hz * at(tick).cos();
    let squares = velocities.iter().enumerate().skip(100).map(|(tick, velocity)| (velocity - speed(tick)).powi(2));
    (squares.sum::<f64>() / 4000.0).sqrt()
}

#[test]
fn a_finer_encoder_means_a_smaller_error() {
    for name in ["difference", "filtered", "adaptive"] {
        let errors = [3e3, 1e4, 3e4, 1e5, 3e5].map(|counts_per_m| sinusoid_error(name, counts_per_m, 0.5));
        assert!(errors.is_sorted_by(|coarse, fine| coarse > fine), "{name}: {errors:?}");
    }
}

#[test]
fn adaptive_beats_the_difference_where_the_encoder_is_coarse_for_the_motion() {
    for (counts_per_m, frequency_hz) in [(1e4, 0.5), (1e4, 2.0), (1e5, 0.5), (2e5, 0.25)] {
        let difference = sinusoid_error("difference", counts_per_m, frequency_hz);
        let adaptive = sinusoid_error("adaptive", counts_per_m, frequency_hz);
        assert!(adaptive < 0.5 * difference, "{counts_per_m} {frequency_hz}: {adaptive} {difference}");
    }
}

#[test]
fn adaptive_lags_constant_acceleration_by_half_the_window_that_bends_by_one_count() {
    for acceleration in [0.05, 0.3, 1.7, 12.0] {
        let positions: Vec<f64> =
            (0..100).map(|tick| 0.5 * acceleration * (PERIOD_S * f64::from(tick)).powi(2)).collect();
        let last = *estimates::<f64>(&named("adaptive"), &positions).last().unwrap();
        // A parabola leaves its chord over k ticks by a·T²/2·⌊k/2⌋·⌈k/2⌉ at most.
        let bend = |k: i32| 0.5 * acceleration * PERIOD_S.powi(2) * f64::from((k / 2) * (k - k / 2));
        let window = (1..=16).rev().find(|k| bend(*k) <= COUNT_M * (1.0 + SLACK)).unwrap();
        let lag_s = 0.099 - last / acceleration;
        assert!((lag_s - 0.5 * PERIOD_S * f64::from(window)).abs() < 1e-9, "{acceleration}: {lag_s} {window}");
        assert!(
            acceleration * lag_s
                < (2.0 * acceleration * COUNT_M * (1.0 + SLACK)).sqrt() + 0.5 * acceleration * PERIOD_S
        );
    }
}

/// The definition, in whole counts and O(window²): the slope, as (counts, ticks), of the longest window that fits.
fn longest_fit(counts: &[i64], newest: usize, window: usize) -> (i64, i64) {
    let back = |ticks: i64| counts[newest] - counts[newest.saturating_sub(ticks as usize)];
    let fits = |k: i64| (1..k).all(|i| (back(i) * k - back(k) * i).abs() <= k);
    let longest = (1..=window as i64).rev().find(|k| fits(*k)).unwrap();
    (back(longest), longest)
}

fn adaptive_is_the_definition<S: Scalar>(steps: &[i64], window: usize, tolerance: f64) {
    let settings =
        settings(&[("axis.velocity", Value::Text("adaptive")), ("axis.velocity_window_ticks", number(window as f64))]);
    let counts: Vec<i64> = steps
        .iter()
        .scan(0, |total, step| {
            *total += step;
            Some(*total)
        })
        .collect();
    let positions: Vec<f64> = counts.iter().map(|counts| *counts as f64 * COUNT_M).collect();
    for (tick, velocity) in estimates::<S>(&settings, &positions).iter().enumerate() {
        let (moved, ticks) = longest_fit(&counts, tick, window);
        let expected = moved as f64 / ticks as f64 * COUNT_M / PERIOD_S;
        assert!((velocity - expected).abs() <= tolerance, "{} {tick}: {velocity} {expected}", S::NAME);
    }
}

proptest! {
    #[test]
    fn adaptive_is_the_longest_window_that_fits(
        smooth in prop::collection::vec(-1..=1_i64, 1..100),
        rough in prop::collection::vec(-6..=6_i64, 1..40),
        drift in -3..=3_i64,
        window in 2..=16_usize,
    ) {
        let drifting = smooth.iter().map(|step| step + drift);
        let steps: Vec<i64> = drifting.chain(rough).chain(smooth.iter().copied()).collect();
        adaptive_is_the_definition::<f64>(&steps, window, 1e-9);
        adaptive_is_the_definition::<f32>(&steps, window, 1e-5);
        adaptive_is_the_definition::<Fixed>(&steps, window, 1e-6);
    }

    #[test]
    fn adaptive_is_the_longest_window_that_fits_a_sampled_line(slope in -3.0..3.0_f64, offset in 0.0..1.0_f64) {
        let counts: Vec<i64> = (0..80).map(|tick| (slope * f64::from(tick) + offset).floor() as i64).collect();
        let steps: Vec<i64> = core::iter::once(counts[0]).chain(counts.windows(2).map(|two| two[1] - two[0])).collect();
        adaptive_is_the_definition::<f64>(&steps, 16, 1e-9);
        // A sampled line fits the whole window, so the error is at most a count over it.
        let positions: Vec<f64> = counts.iter().map(|counts| *counts as f64 * COUNT_M).collect();
        let last = *estimates::<f64>(&named("adaptive"), &positions).last().unwrap();
        prop_assert!((last - slope * COUNT_M / PERIOD_S).abs() <= COUNT_M / (16.0 * PERIOD_S) + 1e-12);
    }

    #[test]
    fn any_bits_may_come_in_and_two_good_readings_later_all_but_the_filter_have_recovered(
        bits in prop::collection::vec(any::<u32>(), 1..40),
        bad in prop::sample::select(vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY]),
    ) {
        for name in ["measured", "difference", "filtered", "adaptive"] {
            let mut model = AnyVelocity::<f32>::build(&named(name)).expect("good settings");
            for bits in &bits {
                model.step(Motion::at(f32::from_bits(*bits)));
            }
            model.step(Motion { position: bad, velocity: bad });
            model.step(Motion::at(0.01));
            let recovered = model.step(Motion::at(0.01));
            prop_assert!(name == "filtered" || recovered.is_finite(), "{name}: {recovered}");
            model.start(Motion::at(0.01));
            prop_assert_eq!(model.step(Motion::at(0.01)), 0.0);
        }
    }
}

#[test]
fn every_number_of_a_state_is_visited() {
    for (name, numbers) in [("measured", 0), ("difference", 1), ("filtered", 2), ("adaptive", 16)] {
        let mut model = AnyVelocity::<f64>::build(&named(name)).expect("good settings");
        let mut count = 0;
        model.visit(&mut |number: &mut f64| {
            *number = 7.0;
            count += 1;
        });
        assert_eq!(count, numbers, "{name}");
    }
}
