//! Guides and walls at the object: where they hold it, and that no speed, stiffness or crossing makes energy.

use cohold_core::names::{Decode, FixtureName};
use cohold_core::num::Motion;
use cohold_core::object::IntegratorName;
use cohold_core::settings::Settings;

use super::Bench;

fn fixture(kind: FixtureName, stiffness: f64, damping: f64) -> Settings {
    let mut settings = Settings::default();
    settings.coordination.comm = "none";
    settings.coordination.decode = Decode::Implicit;
    (settings.object.integrator, settings.object.force_delay_ticks) = (IntegratorName::Midpoint, 0.0);
    settings.fixture.kind = kind;
    settings.fixture.position_m = 0.01;
    (settings.fixture.stiffness_n_per_m, settings.fixture.damping_n_s_per_m) = (stiffness, damping);
    settings
}

/// Pushed by the spring of the contact, F = K_LC·(x_h − x_o), against K·(x_o − x_f): where both are as strong.
#[test]
fn a_pushed_object_rests_where_springs_balance() {
    for (kind, device, at) in [
        (FixtureName::Guide, 0.0, (1000.0 * 0.0 + 3000.0 * 0.01) / 4000.0),
        (FixtureName::Guide, 0.03, (1000.0 * 0.03 + 3000.0 * 0.01) / 4000.0),
        (FixtureName::ForbiddenAbove, 0.03, (1000.0 * 0.03 + 3000.0 * 0.01) / 4000.0),
        (FixtureName::ForbiddenAbove, 0.005, 0.005),
        (FixtureName::ForbiddenBelow, 0.03, 0.03),
        (FixtureName::ForbiddenBelow, 0.002, (1000.0 * 0.002 + 3000.0 * 0.01) / 4000.0),
    ] {
        for one_sided in [false, true] {
            let mut settings = fixture(kind, 3000.0, 20.0);
            (settings.contact.damping_n_s_per_m, settings.contact.one_sided) = (20.0, one_sided);
            settings.object.damping_n_s_per_m = 5.0;
            // From where the device is: a one-sided contact only pushes on.
            let start = if device < 0.01 { 0.02 } else { 0.0 };
            if one_sided && (device < start || kind != FixtureName::ForbiddenAbove) {
                continue;
            }
            let mut bench = Bench::<f64>::at_rest(&settings, Motion::at(start));
            bench.command(cohold_core::safety::Command::Arm);
            for tick in 0..8000 {
                let share = f64::from(tick.min(4000)) / 4000.0;
                bench.at(start + share * (device - start), 0.0);
            }
            let found = bench.peer.observed()[0].object.position;
            assert!((found - at).abs() < 1e-6, "{kind:?} {device} {one_sided}: {found} m, not {at}");
        }
    }
}

/// The hand's work, less what is stored, is never negative: in the copy, in the contact and in the fixture.
#[test]
fn no_fixture_gives_more_than_it_was_given() {
    let mut draw = 1_u64;
    let mut random = move || {
        draw ^= draw << 13;
        draw ^= draw >> 7;
        draw ^= draw << 17;
        (draw >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut crossed = 0;
    for case in 0..600 {
        let kind = [FixtureName::Guide, FixtureName::ForbiddenAbove, FixtureName::ForbiddenBelow][case % 3];
        let mut settings = fixture(kind, 10_f64.powf(1.0 + 5.0 * random()), 20.0 * random() * random().round());
        settings.object.integrator = [IntegratorName::Midpoint, IntegratorName::BackwardEuler][case / 3 % 2];
        settings.object.mass_kg = 10_f64.powf(-2.0 + 2.0 * random());
        settings.contact.stiffness_n_per_m = 10_f64.powf(1.0 + 3.0 * random());
        settings.contact.damping_n_s_per_m = 0.0;
        settings.contact.one_sided = false;
        let mut bench = Bench::<f64>::armed(&settings);
        let (rate, size) = (5.0 + 60.0 * random(), 0.004 + 0.05 * random());
        let (contact, spring) = (settings.contact.stiffness_n_per_m, settings.fixture.stiffness_n_per_m);
        let (mut given, mut largest, mut was_past) = (0.0, 1e-6_f64, false);
        let mut last: Option<(f64, f64)> = None;
        for tick in 0..3000 {
            let device = size * (rate * f64::from(tick) * 1e-3).sin();
            bench.at(device, 0.0);
            let seen = *bench.peer.observed()[0];
            let (object, speed) = (seen.object.position, seen.object.velocity);
            if let Some((felt, before)) = last {
                // Held through the tick, the device as it was sensed: the work on the copy.
                given += felt * (object - before);
            }
            last = Some((seen.contact_force, object));
            let past = match kind {
                FixtureName::Guide => object - 0.01,
                FixtureName::ForbiddenAbove => (object - 0.01).max(0.0),
                _ => (0.01 - object).max(0.0),
            };
            let stored = 0.5 * spring * past * past + 0.5 * settings.object.mass_kg * speed * speed;
            // The guide is stretched from the beginning.
            let first = if kind == FixtureName::ForbiddenAbove { 0.0 } else { 0.5 * spring * 0.01 * 0.01 };
            largest = largest.max(stored);
            assert!(
                stored <= given + first + 1e-9 * largest,
                "case {case}, tick {tick}: {stored} J of {given} J, {contact}"
            );
            crossed += u32::from((past > 0.0) != was_past);
            was_past = past > 0.0;
        }
    }
    assert!(crossed > 5000, "{crossed} crossings");
}

#[test]
fn a_fixture_needs_an_object_that_is_moved_by_ports() {
    let mut settings = Settings::default();
    settings.fixture.kind = FixtureName::Guide;
    let refused = settings.check().unwrap_err().to_string();
    assert!(refused.contains("fixture.kind = \"guide\" is not allowed"), "{refused}");
}
