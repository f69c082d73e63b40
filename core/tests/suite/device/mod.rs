//! The `axis` room against oracles that do not share its code: brute force, exact integers, inverse kinematics, finite
//! differences, closed forms.

mod arm;
mod check;
mod current;
mod encoder;
mod kinematics;
mod motor;
mod velocity;

use cohold_core::settings::{Settings, Value};

/// The default settings with some keys changed; whole table and range checks included.
fn settings(changes: &[(&str, Value<'static>)]) -> Settings {
    let mut settings = Settings::default();
    for (key, value) in changes {
        settings.set(key, *value).unwrap_or_else(|error| panic!("{key}: {error:?}"));
    }
    settings
}

/// A number for a key.
fn number(value: f64) -> Value<'static> {
    Value::Number(value)
}
