//! Encoder against brute force.

use cohold_core::device::encoder::{Counts, Encoder, EncoderState};
use cohold_core::num::{Fixed, Scalar};
use cohold_core::settings::Value;
use proptest::prelude::*;

use super::{number, settings};

fn primed(encoder: &Encoder<f64>, at: u16) -> EncoderState {
    let mut state = EncoderState::default();
    assert_eq!(encoder.step(&mut state, Counts(at)), Some(0.0));
    state
}

#[test]
fn the_longest_step_is_the_fastest_motion_and_a_margin() {
    let longest = |changes: &[_]| Encoder::<f64>::build(&settings(changes)).max_step_counts();
    // 10 m/s for 1 ms at 200 000 counts/m are 2000 counts; a quarter more, and two for rounding.
    assert_eq!(longest(&[]), 2502);
    assert_eq!(longest(&[("encoder.counts_per_m", number(2e8))]), 32767);
    // The paddle's motor turns by 10/0.08 = 125 rad per metre: 1.25 rad in a tick, 8192/2π counts each.
    let capstan = ("kinematics.model", Value::Text("capstan"));
    assert_eq!(longest(&[capstan]), (1.25_f64 * 1.25 * 8192.0 / core::f64::consts::TAU + 2.0).floor() as i32);
}

#[test]
fn every_step_from_every_kind_of_place_is_the_shorter_way_round_or_refused() {
    for reversed in [false, true] {
        let encoder = Encoder::<f64>::build(&settings(&[("encoder.reversed", Value::Flag(reversed))]));
        for from in [0_u16, 1, 1000, 32767, 32768, 65535] {
            for offset in -32768..=32767_i32 {
                let mut state = primed(&encoder, from);
                let before = state;
                let counts = (i32::from(from) + offset).rem_euclid(65536) as u16;
                let along = if reversed { -offset } else { offset };
                let answer = encoder.step(&mut state, Counts(counts));
                if offset.abs() <= 2502 {
                    assert_eq!(answer, Some(f64::from(along) / 200_000.0));
                } else {
                    assert_eq!(answer, None);
                    assert_eq!(state, before);
                }
            }
        }
    }
}

#[test]
fn a_glitch_costs_one_reading_only() {
    let encoder = Encoder::<f64>::build(&settings(&[]));
    let mut state = primed(&encoder, 65000);
    assert!(encoder.step(&mut state, Counts(20000)).is_none());
    assert_eq!(encoder.step(&mut state, Counts(65010)), Some(10.0 / 200_000.0));
}

#[test]
fn half_a_turn_of_the_timer_is_ambiguous_and_refused() {
    let encoder = Encoder::<f64>::build(&settings(&[("encoder.counts_per_m", number(2e8))]));
    let mut state = primed(&encoder, 0);
    assert!(encoder.step(&mut state, Counts(32768)).is_none());
    assert!(encoder.step(&mut state, Counts(32767)).is_some());
}

#[test]
fn the_total_does_not_overflow() {
    let encoder = Encoder::<f64>::build(&settings(&[]));
    for (total, counts) in [(i32::MAX - 5, 6_u16), (i32::MIN + 5, 65530)] {
        let mut state = EncoderState { total, primed: true, ..EncoderState::default() };
        assert!(encoder.step(&mut state, Counts(counts)).is_none());
        assert_eq!(state.total, total);
    }
}

#[test]
fn a_turning_joint_is_in_rad() {
    let encoder = Encoder::<f64>::build(&settings(&[("kinematics.model", Value::Text("capstan"))]));
    let mut state = primed(&encoder, 0);
    let mut angle = 0.0;
    for eighth in 1..=60_u16 {
        angle = encoder.step(&mut state, Counts(eighth * 1024)).unwrap();
    }
    assert!((angle - 7.5 * core::f64::consts::TAU).abs() < 1e-12);
    assert!((encoder.resolution() - core::f64::consts::TAU / 8192.0).abs() < 1e-18);
}

fn follows<S: Scalar>(start: u16, steps: &[i32], reversed: bool, ulp: f64) {
    let encoder = Encoder::<S>::build(&settings(&[("encoder.reversed", Value::Flag(reversed))]));
    let mut state = EncoderState::default();
    encoder.step(&mut state, Counts(start)).unwrap();
    let mut raw = i64::from(start);
    for step in steps {
        raw += i64::from(*step);
        let position = encoder.step(&mut state, Counts(raw.rem_euclid(65536) as u16)).unwrap();
        let moved = (raw - i64::from(start)) as f64 / if reversed { -200_000.0 } else { 200_000.0 };
        assert!((position.to_f64() - moved).abs() <= ulp * (1.0 + moved.abs()), "{position:?} {moved}");
    }
}

proptest! {
    #[test]
    fn any_walk_adds_up(
        start: u16,
        steps in prop::collection::vec(-2502..=2502_i32, 1..400),
        reversed: bool,
    ) {
        follows::<f64>(start, &steps, reversed, 1e-15);
        follows::<f32>(start, &steps, reversed, 1e-7);
        follows::<Fixed>(start, &steps, reversed, 2.4e-10);
    }

    #[test]
    fn anything_may_come_in(
        readings in prop::collection::vec(any::<u16>(), 0..50),
        total: i32,
        last: u16,
        primed: bool,
    ) {
        let encoder = Encoder::<f32>::build(&settings(&[]));
        let mut state = EncoderState { total, last: Counts(last), primed, ..EncoderState::default() };
        for counts in readings {
            if let Some(position) = encoder.step(&mut state, Counts(counts)) {
                prop_assert!(position.is_finite());
            }
        }
    }
}
