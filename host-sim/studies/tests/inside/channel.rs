use cohold_core::law::decimate::{Mean, Newest, OnePole};

use super::*;

/// The closed form of this file's head, for M and cutoffs beside the paper's.
#[test]
fn the_worst_wave_is_that_of_the_closed_form() {
    for (ticks, cutoff_hz) in [(8, 60.0), (8, 20.0), (8, 200.0), (2, 60.0), (16, 31.25), (1, 60.0)] {
        let mut settings = Settings::default();
        (settings.timing.ticks_per_packet, settings.coordination.cutoff_hz) = (ticks, cutoff_hz);
        let (a, m) = (pole(&settings), f64::from(ticks));
        let closed = m * (1.0 - a) * (1.0 + a.powf(m)) / ((1.0 + a) * (1.0 - a.powf(m)));
        let driven = worst::<OnePole<f64>>(&settings, a);
        assert!((driven / closed - 1.0).abs() < 1e-9, "M {ticks}, {cutoff_hz} Hz: {driven}, {closed}");
        assert!((worst::<Newest>(&settings, 0.0) / m - 1.0).abs() < 1e-12);
        assert!((worst::<Mean<f64>>(&settings, 1.0) - 1.0).abs() < 1e-12);
    }
    let settings = Settings::default();
    assert!((worst::<OnePole<f64>>(&settings, pole(&settings)) - 1.64).abs() < 0.01);
}

/// No other wave of the same period is worse.
#[test]
fn no_random_wave_is_worse() {
    let settings = Settings::default();
    let most = worst::<OnePole<f64>>(&settings, pole(&settings));
    let mut rng = cohold_sim::rng::Rng::new(1);
    for _ in 0..200 {
        let wave: Vec<f64> = (0..8 * 25).map(|_| rng.unit() - 0.5).collect();
        let got = out_over_in::<OnePole<f64>>(&settings, |tick| wave[tick % wave.len()]);
        assert!(got <= most, "{got} is more than {most}");
    }
}
