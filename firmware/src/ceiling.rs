//! Ceiling: from afar limits are lowered only; who raises one stands at the board.
//!
//! Over the network nobody sees the hand at the device. So what an operator has taken is held against the settings that the board
//! started with, or that were taken while its blue button was held down: no number of the tables `safety` and `probe`, nor
//! `motor.max_duty`, may be larger, for whichever it is, larger is the weaker guard: more force, more power, more room, or longer
//! until something is noticed. And the tables `encoder`, `kinematics` and `motor` must be the same: they say what a newton and a
//! metre per second are, without which no limit means anything.
//!
//! A key that is added to one of these tables is under the rule of its table.
//!
//! **Limit**: how velocity is estimated (`axis`) is free, and with it how soon a limit of speed or power notices; that of force holds.

use core::fmt;

use cohold_core::settings::{Settings, Value};

/// Tables of limits, and a limit elsewhere.
const LIMITS: [&str; 3] = ["safety.", "probe.", "motor.max_duty"];
/// Tables of what the device is.
const DEVICE: [&str; 3] = ["encoder.", "kinematics.", "motor."];

/// A value that only who is at the board may have taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Above {
    /// Name of the key.
    pub key: &'static str,
    /// The value that was asked for.
    pub value: Value<'static>,
    /// What the board was set to.
    pub ceiling: Value<'static>,
}

impl fmt::Display for Above {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { key, value, ceiling } = self;
        let is = if is_limit(key) { "above" } else { "not" };
        write!(
            f,
            "{key} = {value} is {is} what this board was set to, {ceiling}: hold the blue button while saying apply"
        )
    }
}

impl core::error::Error for Above {}

fn is_limit(key: &str) -> bool {
    LIMITS.iter().any(|limits| key.starts_with(limits))
}

/// What only who is at the board, which was set to `ceiling`, may have taken of these settings.
pub fn above<'a>(wanted: &'a Settings, ceiling: &'a Settings) -> impl Iterator<Item = Above> + 'a {
    let guarded = |key: &str| is_limit(key) || DEVICE.iter().any(|device| key.starts_with(device));
    Settings::keys().map(|key| key.name).filter(move |key| guarded(key)).filter_map(|key| {
        let (value, ceiling) = (wanted.get(key)?, ceiling.get(key)?);
        let lower = match (value, ceiling) {
            (Value::Number(value), Value::Number(ceiling)) => is_limit(key) && value <= ceiling,
            _ => false,
        };
        (!lower && value != ceiling).then_some(Above { key, value, ceiling })
    })
}
