//! The exact integrator against itself: an exact step is the same as two exact steps of half the period.

use haptic_core::num::Motion;
use haptic_core::object::{AnyIntegrator, IntegratorName};
use haptic_core::settings::Settings;

/// From rest through `ticks` ticks of 1 N held.
fn pushed(damping: f64, period_s: f64, ticks: u32) -> Motion<f64> {
    let mut settings = Settings::default();
    settings.timing.control_period_s = period_s;
    settings.object.integrator = IntegratorName::Exact;
    settings.object.damping_n_s_per_m = damping;
    settings.object.force_delay_ticks = 0.0;
    let mut integrator = AnyIntegrator::build(&settings).expect("good settings");
    (0..ticks).fold(Motion::REST, |motion, _| integrator.step(motion, 1.0))
}

/// From b·T/m = 0, through where the series ends, to where the object stands within a tick.
#[test]
fn an_exact_step_is_two_of_half_the_period_to_the_last_digits() {
    let (mass, period) = (0.3, 1e-3);
    for number in 0..4000 {
        let ratio = if number == 0 { 0.0 } else { 1e-7 * 1.005_f64.powi(number) };
        let damping = ratio * mass / period;
        let (whole, halves) = (pushed(damping, period, 1), pushed(damping, 0.5 * period, 2));
        for (whole, halves) in [(whole.position, halves.position), (whole.velocity, halves.velocity)] {
            assert!((whole / halves - 1.0).abs() < 2e-15, "b·T/m = {ratio}: {whole} and {halves}");
        }
    }
}
