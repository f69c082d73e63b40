//! Motor and hold against closed forms.

use cohold_core::device::constraint::Hold;
use cohold_core::device::motor::{self, Duty, Motor};
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::settings::{Allowed, Value};
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

/// 0.2 N over 5 mm from 1.2 mm on.
const COGGING: [(&str, Value<'static>); 3] = [
    ("motor.cogging_n_or_n_m", Value::Number(0.2)),
    ("motor.cogging_period_m_or_rad", Value::Number(0.005)),
    ("motor.cogging_at_m_or_rad", Value::Number(0.0012)),
];

fn cancels<S: Scalar>() {
    let motor = Motor::<S>::build(&settings(&COGGING));
    assert!(motor.eases && !Motor::<S>::build(&settings(&[])).eases);
    let eased = |joint: Option<f64>| {
        let mut forces = [S::ZERO; 2];
        motor.eased(&mut forces, &[Motion::REST; 2], joint.map(S::from_f64));
        forces.map(Scalar::to_f64)
    };
    assert_eq!(eased(None), [0.0; 2], "a place that is not known");
    // Over 200 periods either way. The fast sine is 1.1e-3 off; a place of f32 at a metre, 4e-5 rad.
    for step in -2000..=2000 {
        let joint = S::from_f64(5e-4 * f64::from(step) + 1.1e-4).to_f64();
        let exact = -0.2 * (std::f64::consts::TAU * (joint - 0.0012) / 0.005).sin();
        let [force, other] = eased(Some(joint));
        assert!((force - exact).abs() < 0.2 * 1.5e-3 && other == 0.0, "{} at {joint} m: {force}, {exact} N", S::NAME);
    }
    for far in [1e9, -1e9, f64::MAX, f64::INFINITY, f64::NAN] {
        assert!(eased(Some(far))[0].abs() <= 0.2 + 1e-6, "{} at {far} m", S::NAME);
    }
}

#[test]
fn cogging_is_cancelled_over_the_travel() {
    cancels::<f32>();
    cancels::<f64>();
    cancels::<Fixed>();
}

/// A device that is led to and fro, fast and slowly, with a force that is up to two ticks old: never more than k·d·∫v².
#[test]
fn cogging_that_is_cancelled_late_gives_no_more_than_its_bound() {
    let motor = Motor::<f32>::build(&settings(&COGGING));
    let place = |time: f64, [reach, hertz]: [f64; 2]| reach * (std::f64::consts::TAU * hertz * time).sin();
    for way in [[0.02, 0.5], [0.02, 3.0], [0.002, 10.0], [0.0005, 30.0]] {
        let (step, per_tick) = (1e-5, 100);
        let (mut given, mut bound, mut most, mut force) = (0.0, 0.0, f64::MIN, [0.0; 2]);
        for nth in 0..200_000 {
            let time = step * f64::from(nth);
            if nth % per_tick == 0 {
                // Sensed now, it acts from the next tick on.
                let mut new = [0.0; 2];
                motor.eased(&mut new, &[Motion::REST; 2], Some(place(time, way) as f32));
                force = [force[1], f64::from(new[0])];
            }
            let moved = place(time + step, way) - place(time, way);
            let cogging = 0.2 * (std::f64::consts::TAU * (place(time + 0.5 * step, way) - 0.0012) / 0.005).sin();
            if nth >= 2 * per_tick {
                given += (force[0] + cogging) * moved;
                bound += std::f64::consts::TAU * 0.2 / 0.005 * 0.002 * moved * moved / step;
                most = most.max(given);
                // What the fast sine is off is a force, too.
                assert!(given <= bound + 0.2 * 1.5e-3 * 0.08 * time, "{way:?}: {given} J of {bound} at {time} s");
            }
        }
        println!("{way:?}: at most {most:.2e} J, of {bound:.2e}; {given:.2e} in the end");
    }
}

#[test]
fn cogging_without_a_known_phase_is_refused() {
    let said = |changes: &[(&str, Value<'static>)]| {
        motor::check(&settings(&[&COGGING[..], changes].concat())).map_err(|refused| match refused.allowed {
            Allowed::Only(_) => "the place",
            _ => refused.key,
        })
    };
    let index = ("encoder.index", Value::Flag(true));
    assert_eq!(said(&[]), Err("the place"));
    assert_eq!(said(&[index]), Ok(()));
    assert_eq!(said(&[index, ("axis.count", number(2.0))]), Err("the place"));
    assert_eq!(motor::check(&settings(&[("axis.count", number(2.0))])), Ok(()), "0 needs nothing");
    // A fifth of 40 N, and on a capstan of 10 turns and 80 mm of 0.32 N·m.
    assert_eq!(said(&[index, ("motor.cogging_n_or_n_m", number(8.01))]), Err("motor.cogging_n_or_n_m"));
    let capstan = ("kinematics.model", Value::Text("capstan"));
    let torque = |torque| ("motor.cogging_n_or_n_m", number(torque));
    let part = |parts: f64| ("motor.cogging_period_m_or_rad", number(std::f64::consts::TAU / parts));
    assert_eq!(said(&[index, capstan, torque(0.063), part(42.0)]), Ok(()));
    assert_eq!(said(&[index, capstan, torque(0.065), part(42.0)]), Err("motor.cogging_n_or_n_m"));
    assert_eq!(said(&[index, capstan, torque(0.01), part(42.5)]), Err("the place"));
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
