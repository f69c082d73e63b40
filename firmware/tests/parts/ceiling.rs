//! From afar every limit can be lowered and none raised, and the device is what it was at the board.

use cohold_core::settings::{Allowed, Key, Settings, Value};
use firmware_parts::ceiling::{Above, above};
use firmware_parts::kept::defaults;

/// Limits by name, of which no table is asked: force, power, room, time.
const LIMITS: [&str; 23] = [
    "safety.max_force_n",
    "safety.max_slew_n_per_s",
    "safety.max_speed_m_per_s",
    "safety.max_hand_power_w",
    "safety.workspace_m",
    "safety.max_rms_force_n",
    "safety.max_rms_power_w",
    "safety.rms_s",
    "safety.operator_lost_s",
    "safety.saturated_ticks",
    "safety.fade_s",
    "safety.disengage_s",
    "safety.peer_lost_s",
    "safety.max_delay_s",
    "safety.stuck_duty",
    "probe.max_duty",
    "probe.max_travel_counts",
    "probe.max_speed_counts_per_s",
    "probe.max_s",
    "probe.check_duty",
    "probe.check_s",
    "probe.check_counts",
    "motor.max_duty",
];

/// The key's smallest and largest number.
fn ends(key: &Key) -> Option<[f64; 2]> {
    match key.allowed {
        Allowed::Number { min, max } => Some([min, max]),
        Allowed::Whole { min, max } => Some([min.into(), max.into()]),
        _ => None,
    }
}

/// What is refused first from afar.
fn check(wanted: &Settings, ceiling: &Settings) -> Result<(), Above> {
    above(wanted, ceiling).next().map_or(Ok(()), Err)
}

fn set(settings: &Settings, key: &str, value: Value<'_>) -> Settings {
    let mut settings = *settings;
    settings.set(key, value).unwrap_or_else(|error| panic!("{key}: {error:?}"));
    settings
}

#[test]
fn every_limit_can_be_lowered_from_afar_and_none_raised() {
    let ceiling = defaults();
    let mut limits = Vec::new();
    for key in Settings::keys() {
        let table = key.name.split('.').next().expect("a table");
        if !["safety", "probe"].contains(&table) && key.name != "motor.max_duty" {
            continue;
        }
        limits.push(key.name);
        let [min, max] = ends(&key).expect("a limit is a number: larger is weaker");
        let Some(Value::Number(now)) = ceiling.get(key.name) else { panic!("{}", key.name) };
        for (value, fits) in [(min, true), (now, true), (max, max <= now)] {
            let wanted = set(&ceiling, key.name, Value::Number(value));
            assert_eq!(check(&wanted, &ceiling).is_ok(), fits, "{} = {value}", key.name);
            // Lowered at the board, or saved, it is the ceiling.
            assert_eq!(check(&ceiling, &wanted).is_ok(), value >= now, "{}", key.name);
        }
    }
    assert!(LIMITS.iter().all(|limit| limits.contains(limit)), "{limits:?}");
}

#[test]
fn what_is_refused_is_named_with_its_ceiling_and_with_what_to_do() {
    let ceiling = defaults();
    let wanted = set(&ceiling, "safety.max_force_n", Value::Number(200.0));
    let said = check(&wanted, &ceiling).expect_err("above the ceiling").to_string();
    let whole =
        "safety.max_force_n = 200 is above what this board was set to, 3: hold the blue button while saying apply";
    assert_eq!(said, whole);
    let wanted = set(&ceiling, "motor.full_scale_a", Value::Number(2.0));
    let said = check(&wanted, &ceiling).expect_err("another motor").to_string();
    let whole = "motor.full_scale_a = 2 is not what this board was set to, 5: hold the blue button while saying apply";
    assert_eq!(said, whole);
}

/// Why: with a hundredth of the newtons per ampere, 40 N are 4000.
#[test]
fn the_device_is_what_it_was_at_the_board() {
    let ceiling = defaults();
    for key in Settings::keys() {
        let table = key.name.split('.').next().expect("a table");
        let device = ["encoder", "kinematics", "motor"].contains(&table) && key.name != "motor.max_duty";
        let limit = ["safety", "probe"].contains(&table) || key.name == "motor.max_duty";
        let others: Vec<Value<'_>> = match (ends(&key), ceiling.get(key.name)) {
            _ if limit => continue,
            (Some(ends), Some(Value::Number(now))) => {
                ends.into_iter().filter(|end| *end != now).map(Value::Number).collect()
            }
            (None, Some(Value::Flag(now))) => vec![Value::Flag(!now)],
            _ => continue,
        };
        for other in others {
            let wanted = set(&ceiling, key.name, other);
            assert_eq!(check(&wanted, &ceiling).is_err(), device, "{} = {other}", key.name);
        }
    }
    assert!(check(&set(&ceiling, "kinematics.model", Value::Text("capstan")), &ceiling).is_err());
    assert!(check(&set(&ceiling, "coordination.comm", Value::Text("power")), &ceiling).is_ok());
}
