//! Motor and hold against closed forms.

use haptic_core::device::constraint::Hold;
use haptic_core::device::motor::{Duty, Motor};
use haptic_core::num::{Fixed, Motion, Scalar};
use haptic_core::settings::Value;
use proptest::prelude::*;

use super::{number, settings};

const REVERSED: (&str, Value<'static>) = ("motor.reversed", Value::Flag(true));

#[test]
fn half_of_full_force_is_half_of_full_duty() {
    // 8 N/A and 5 A are 40 N at 32767; 20 N are 16383.5, away from zero.
    let motor = Motor::<f64>::build(&settings(&[]));
    assert_eq!(motor.duty(20.0), (Duty(16384), false));
    assert_eq!(motor.duty(-20.0), (Duty(-16384), false));
    assert_eq!(motor.duty(0.0), (Duty::OFF, false));
    assert!((motor.joint_force(Duty(Duty::FULL_SCALE)) - 40.0).abs() < 1e-12);
    let against = Motor::<f64>::build(&settings(&[REVERSED]));
    assert_eq!(against.duty(20.0), (Duty(-16384), false));
    assert!((against.joint_force(Duty(-Duty::FULL_SCALE)) - 40.0).abs() < 1e-12);
}

#[test]
fn the_duty_limit_holds_whatever_comes_in() {
    let motor = Motor::<f32>::build(&settings(&[]));
    // 0.95 · 32767 = 31128.65
    assert_eq!(motor.duty(38.1), (Duty(31128), true));
    assert_eq!(motor.duty(f32::INFINITY), (Duty(31128), true));
    assert_eq!(motor.duty(f32::NEG_INFINITY), (Duty(-31128), true));
    assert_eq!(motor.duty(f32::MAX), (Duty(31128), true));
    assert_eq!(motor.duty(f32::NAN).0, Duty::OFF);
    let whole = Motor::<f32>::build(&settings(&[("motor.max_duty", number(1.0))]));
    assert_eq!(whole.duty(f32::MIN), (Duty(-32767), true));
}

fn every_code_survives<S: Scalar>() {
    for changes in [&[("motor.max_duty", number(1.0))][..], &[("motor.max_duty", number(1.0)), REVERSED]] {
        let motor = Motor::<S>::build(&settings(changes));
        for code in -Duty::FULL_SCALE..=Duty::FULL_SCALE {
            assert_eq!(motor.duty(motor.joint_force(Duty(code))).0, Duty(code), "{}", S::NAME);
        }
    }
}

#[test]
fn every_code_survives_the_way_to_a_force_and_back() {
    every_code_survives::<f32>();
    every_code_survives::<f64>();
    every_code_survives::<Fixed>();
}

#[test]
fn the_hold_is_a_spring_and_a_damper() {
    let hold = Hold::<f64>::build(&settings(&[]));
    assert_eq!(hold.force(Motion { position: 0.002, velocity: 0.0 }), -3.0);
    assert_eq!(hold.force(Motion { position: 0.0, velocity: -0.5 }), 1.5);
    assert_eq!(hold.force(Motion { position: 0.002, velocity: -0.5 }), -1.5);
}

/// Whether a mass of 0.1 kg, exactly integrated, comes to rest under the hold.
fn comes_to_rest(stiffness: f64, damping: f64) -> bool {
    let hold = Hold::<f64>::build(&settings(&[
        ("axis.hold_stiffness_n_per_m", number(stiffness)),
        ("axis.hold_damping_n_s_per_m", number(damping)),
    ]));
    let mut at = Motion { position: 0.01, velocity: 0.0 };
    for _ in 0..20000 {
        let gain = hold.force(at) / 0.1 * 0.001;
        at.position += 0.001 * (at.velocity + 0.5 * gain);
        at.velocity += gain;
    }
    at.position.abs() < 1e-3
}

#[test]
fn the_hold_is_stable_where_it_says() {
    assert!(comes_to_rest(1500.0, 3.0));
    // k·T_c/2 = 0.75 N·s/m, 2m/T_c = 200 N·s/m.
    assert!(comes_to_rest(1500.0, 0.8) && !comes_to_rest(1500.0, 0.7));
    assert!(comes_to_rest(1500.0, 198.0) && !comes_to_rest(1500.0, 202.0));
}

proptest! {
    #[test]
    fn the_force_is_met_to_half_a_code(force in -37.999..37.999_f64) {
        // The largest whole code under 95 % of full scale is 37.9992 N.
        let motor = Motor::<f64>::build(&settings(&[]));
        let (duty, saturated) = motor.duty(force);
        prop_assert!(!saturated);
        prop_assert!((motor.joint_force(duty) - force).abs() <= 0.5000001 * 40.0 / 32767.0);
    }

    #[test]
    fn any_bits_give_a_duty_within_the_limit(bits: u32, whole: i64) {
        let (duty, _) = Motor::<f32>::build(&settings(&[])).duty(f32::from_bits(bits));
        prop_assert!(duty.0.abs() <= 31128);
        let (duty, _) = Motor::<Fixed>::build(&settings(&[])).duty(Fixed::from_bits(whole));
        prop_assert!(duty.0.abs() <= 31128);
    }
}
