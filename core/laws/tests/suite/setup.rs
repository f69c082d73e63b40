//! Settings of a law that is solved together with the copy.

use cohold_core::object::IntegratorName;
use cohold_core::settings::{Settings, Value};

/// A packet a tick of 1 ms, K_T of 1000 N/m, and keys of the law's own.
pub(crate) fn settings(law: &'static str, own: &[(&str, f64)]) -> Settings {
    let mut settings = Settings::default();
    settings.coordination.comm = law;
    settings.object.integrator = IntegratorName::Midpoint;
    settings.timing.ticks_per_packet = 1;
    settings.coordination.stiffness_n_per_m = 1000.0;
    for (key, value) in own {
        crate::SCHEMA.set(&mut settings, key, Value::Number(*value)).unwrap_or_else(|error| panic!("{key}: {error:?}"));
    }
    settings
}
