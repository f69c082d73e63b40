//! Combinations that no single range can refuse.

use cohold_core::device::kinematics::{KinematicsName, Maths};
use cohold_core::device::velocity::VelocityName;
use cohold_core::settings::{Allowed, Choice, Value};

use super::{number, settings};

const FIVE_BAR: (&str, Value<'static>) = ("kinematics.model", Value::Text("five-bar"));
const CAPSTAN: (&str, Value<'static>) = ("kinematics.model", Value::Text("capstan"));
const FILTERED: (&str, Value<'static>) = ("axis.velocity", Value::Text("filtered"));
const TWO_AXES: (&str, Value<'static>) = ("axis.count", Value::Number(2.0));

#[test]
fn defaults_of_every_mechanism_and_estimator_pass() {
    assert_eq!(settings(&[]).check(), Ok(()));
    assert_eq!(settings(&[TWO_AXES]).check(), Ok(()));
    assert_eq!(settings(&[CAPSTAN]).check(), Ok(()));
    assert_eq!(settings(&[FIVE_BAR, TWO_AXES]).check(), Ok(()));
    for name in VelocityName::NAMES {
        assert_eq!(settings(&[("axis.velocity", Value::Text(name))]).check(), Ok(()), "{name}");
    }
}

#[test]
fn a_mechanism_refuses_the_wrong_number_of_axes() {
    let refused = settings(&[CAPSTAN, TWO_AXES]).check().unwrap_err();
    assert_eq!(refused.to_string(), "axis.count = 2 is not allowed: it must be a whole number from 1 to 1");
    let refused = settings(&[FIVE_BAR]).check().unwrap_err();
    assert_eq!(refused.to_string(), "axis.count = 1 is not allowed: it must be a whole number from 2 to 2");
}

#[test]
fn a_five_bar_whose_links_cannot_meet_is_refused_with_lengths_that_would_do() {
    // Half the elbows' distance at home is 0.03 + 0.1·cos 60° = 0.08 m.
    let links = |distal| settings(&[FIVE_BAR, TWO_AXES, ("kinematics.distal_m", number(distal))]);
    let refused = links(0.07).check().unwrap_err();
    assert_eq!((refused.key, refused.value, refused.unit), ("kinematics.distal_m", number(0.07), "m"));
    let Allowed::Number { min, max } = refused.allowed else { panic!("{:?}", refused.allowed) };
    assert!(min > 0.08 && max > min, "{min} {max}");
    assert_eq!(links(min).check(), Ok(()));
    assert_eq!(links(max).check(), Ok(()));
    assert!(links(max + 1e-6).check().is_err());
}

#[test]
fn a_cutoff_above_half_the_sample_rate_is_refused_only_where_it_is_used() {
    let high = ("axis.velocity_cutoff_hz", number(501.0));
    assert_eq!(settings(&[high]).check(), Ok(()));
    let refused = settings(&[FILTERED, high]).check().unwrap_err();
    assert_eq!(
        refused.to_string(),
        "axis.velocity_cutoff_hz = 501 is not allowed: it must be a number from 0.1 to 500 Hz"
    );
    assert_eq!(settings(&[FILTERED, high, ("timing.control_period_s", number(0.0005))]).check(), Ok(()));
}

#[test]
fn names_are_those_of_scene_files() {
    assert_eq!(KinematicsName::NAMES, ["direct", "capstan", "five-bar", "arm"]);
    for name in ["measured", "difference", "filtered", "adaptive"] {
        assert_eq!(VelocityName::from_name(name).map(Choice::name), Some(name));
    }
    assert_eq!(Maths::NAMES, ["libm", "micromath"]);
    for (name, value) in Maths::NAMES.iter().zip(Maths::ALL) {
        assert_eq!(Maths::from_name(name), Some(*value));
    }
}
