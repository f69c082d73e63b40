//! The exact integrator against itself: an exact step is the same as two exact steps of half the period. The midpoint rule against
//! the parabola, which it follows exactly: what rounding takes from a sum in f32 comes back.

use cohold_core::law::wave::Decode;
use cohold_core::num::Motion;
use cohold_core::object::{AnyIntegrator, IntegratorName};
use cohold_core::settings::Settings;

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

/// x = ½·(F/m)·t² + t, ẋ = 1 + (F/m)·t, with numbers that f32 holds. A tick adds 2⁻³⁰ to a velocity whose steps are 2⁻²³, and
/// 2⁻¹⁰·ẋ to a position whose steps are 2⁻¹⁷ in the end: without its carry the one never moves, the other loses 2 mm.
#[test]
fn the_midpoint_keeps_what_f32_rounds_away() {
    let (period_s, force_n, ticks) = ((-10.0_f64).exp2(), (-20.0_f64).exp2(), 1 << 16);
    let mut settings = Settings::default();
    settings.timing.control_period_s = period_s;
    settings.object.integrator = IntegratorName::Midpoint;
    settings.object.mass_kg = 1.0;
    settings.object.damping_n_s_per_m = 0.0;
    settings.object.force_delay_ticks = 0.0;
    settings.coordination.decode = Decode::Implicit;
    let mut integrator = AnyIntegrator::<f32>::build(&settings).expect("good settings");
    let start = Motion { position: 0.0, velocity: 1.0 };
    let end = (0..ticks).fold(start, |motion, _| integrator.step(motion, force_n as f32));
    let time_s = f64::from(ticks) * period_s;
    let (velocity, position) = (1.0 + force_n * time_s, time_s * (1.0 + 0.5 * force_n * time_s));
    let steps = |got: f32, wanted: f64| (f64::from(got) - wanted).abs() / f64::from(f32::EPSILON * got);
    assert!(steps(end.velocity, velocity) < 1.0, "{} m/s, {velocity} without rounding", end.velocity);
    assert!(steps(end.position, position) < 1.0, "{} m, {position} without rounding", end.position);
}
