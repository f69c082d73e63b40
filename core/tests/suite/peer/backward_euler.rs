//! Backward Euler at a spring that is too stiff for the tick: what a jolt leaves, against the closed form of the linear recurrence.

use cohold_core::law::Packet;
use cohold_core::law::wave::Decode;
use cohold_core::num::{Fixed, Scalar};
use cohold_core::object::IntegratorName;
use cohold_core::settings::Settings;

use super::Bench;

const PERIOD_S: f64 = 1e-3;

/// A copy that nobody holds, at the end of a wave line.
fn settings(integrator: IntegratorName, stiffness: f64) -> Settings {
    let mut settings = Settings::default();
    settings.timing.control_period_s = PERIOD_S;
    settings.timing.ticks_per_packet = 1;
    settings.object.integrator = integrator;
    settings.object.force_delay_ticks = 0.0;
    settings.object.mass_kg = 0.02;
    settings.object.damping_n_s_per_m = 0.0;
    settings.coordination.comm = "wave";
    settings.coordination.decode = Decode::Implicit;
    settings.coordination.stiffness_n_per_m = stiffness;
    settings.coordination.damping_n_s_per_m = 0.0;
    settings.coordination.wave_impedance_n_s_per_m = 60.0;
    (settings.contact.stiffness_n_per_m, settings.contact.damping_n_s_per_m) = (0.0, 0.0);
    settings
}

/// F_T at every tick after a wave of 1 √W came in for one of them.
fn after_a_jolt<S: Scalar>(settings: &Settings) -> Vec<f64> {
    let mut bench = Bench::<S>::armed(settings);
    let force = |tick: u32| {
        let wave = if tick == 0 { S::ONE } else { S::ZERO };
        bench.peer.hear(&[Packet { wave, ..Packet::default() }]);
        bench.peer.exchange();
        bench.at(S::ZERO, S::ZERO);
        bench.peer.observed()[0].coordination_force.to_f64()
    };
    (0..200).map(force).collect()
}

/// Trace and determinant of the tick as a map of (s, ẋ_o), u_in = 0: F = k·(s − θ·T·ẋ_o) with k = K/(1 + θ·K·T/z), 1/z = 1/b + θ·T/m,
/// s ← s − T·ẋ_o − T·F/z, ẋ_o ← ẋ_o + T·F/m. The two roots of λ² − trace·λ + det are what a tick keeps.
fn recurrence(settings: &Settings, part: f64) -> [f64; 2] {
    let (mass, line) = (settings.object.mass_kg, settings.coordination.wave_impedance_n_s_per_m);
    let admittance = 1.0 / line + part * PERIOD_S / mass;
    let softened = 1.0 / (1.0 / settings.coordination.stiffness_n_per_m + part * PERIOD_S * admittance);
    let (drawn, moved) = (PERIOD_S * softened * admittance, PERIOD_S * PERIOD_S * softened / mass);
    [2.0 - drawn - part * moved, 1.0 - drawn + (1.0 - part) * moved]
}

/// The root of the smaller real part: of the spring.
fn of_the_spring([trace, determinant]: [f64; 2]) -> f64 {
    0.5 * trace - (0.25 * trace * trace - determinant).max(0.0).sqrt()
}

#[test]
fn a_jolt_fades_as_the_recurrence_says() {
    for stiffness in [1e3, 1e5, 1e7] {
        for (integrator, part) in [(IntegratorName::Midpoint, 0.5), (IntegratorName::BackwardEuler, 1.0)] {
            let settings = settings(integrator, stiffness);
            let [trace, determinant] = recurrence(&settings, part);
            let forces = after_a_jolt::<f64>(&settings);
            let largest = forces.iter().fold(0.0_f64, |largest, force| largest.max(force.abs()));
            for three in forces[1..].windows(3) {
                let open = three[2] - trace * three[1] + determinant * three[0];
                assert!(open.abs() < 1e-10 * largest, "{integrator:?} at {stiffness} N/m: {open} N of {largest} N");
            }
        }
    }
}

/// 10⁷ N/m: midway the sign of what is left changes from tick to tick for a tenth of a second; at the end of the tick nothing alternates.
#[test]
fn what_is_too_stiff_for_the_tick_rests_within_it() {
    fn alternation<S: Scalar>(integrator: IntegratorName) -> f64 {
        let forces = after_a_jolt::<S>(&settings(integrator, 1e7));
        let swing = |three: &[f64]| 0.25 * (three[2] - 2.0 * three[1] + three[0]).abs();
        forces[20..].windows(3).map(swing).fold(0.0, f64::max) / forces[1].abs()
    }
    let [midway, at_the_end] = [(IntegratorName::Midpoint, 0.5), (IntegratorName::BackwardEuler, 1.0)]
        .map(|(name, part)| of_the_spring(recurrence(&settings(name, 1e7), part)));
    assert!((-1.0..-0.97).contains(&midway), "{midway}");
    assert!((0.0..0.01).contains(&at_the_end), "{at_the_end}");
    assert!(alternation::<f64>(IntegratorName::Midpoint) > 5e-3, "{}", alternation::<f64>(IntegratorName::Midpoint));
    for left in [
        alternation::<f64>(IntegratorName::BackwardEuler),
        alternation::<f32>(IntegratorName::BackwardEuler),
        alternation::<Fixed>(IntegratorName::BackwardEuler),
    ] {
        assert!(left < 1e-3, "{left} of the jolt");
    }
}
