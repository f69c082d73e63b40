//! The simulated device against closed forms.

use super::*;

/// A step of force from rest: x = ½·F/m·t², less what the damping takes.
#[test]
fn a_free_device_goes_where_the_force_sends_it() {
    let mut device = Device::default();
    device.moved_by(Moves::Free);
    let counts: i32 = (0..200).map(|_| device.step(0.02)).sum();
    let (time_s, decay) = (0.01_f64, 10.0_f64);
    // v∞·(t - (1 - e^(-t·b/m))·m/b), of 0.8 N against 1 N·s/m.
    let metres = 0.8 * (time_s - (1.0 - (-decay * time_s).exp()) / decay);
    assert!((f64::from(counts) - metres * 200_000.0).abs() < 0.01 * metres * 200_000.0, "{counts}");
}

#[test]
fn a_sweep_stays_within_its_span_and_moves_in_every_tick() {
    let mut device = Device::default();
    device.moved_by(Moves::Sweep(1, 4, 800));
    let mut at = 0_i32;
    for _ in 0..5000 {
        let before = at;
        at += (0..20).map(|_| device.step(0.0)).sum::<i32>();
        assert!((0..=800).contains(&at) && (at - before).abs() <= 5, "{at}");
    }
}

#[test]
fn a_sweep_of_one_step_is_elsewhere_in_every_tick_and_comes_back() {
    let mut device = Device::default();
    device.moved_by(Moves::Sweep(10, 5, 10));
    let moved: Vec<i32> = (0..6).map(|_| (0..5).map(|_| device.step(0.0)).sum()).collect();
    assert_eq!(moved, [10, -10, 10, -10, 10, -10]);
}

/// A fifth of the supply makes 1 A in 4.8 Ω, within e-fold times of 104 µs; and a hand at 1 m/s makes 8 V.
#[test]
fn a_winding_carries_what_its_voltage_drives_through_it() {
    let mut device = Device::default();
    let (first, _) = device.wind(Some(0.2));
    assert!((first - 0.2 * (1.0 - f32::exp(-4.8 * STEP_S / 0.5e-3))).abs() < 1e-4, "{first}");
    let settled = (0..40).map(|_| device.wind(Some(0.2))).last();
    assert!(settled.is_some_and(|(share, level)| (share - 0.2).abs() < 1e-3 && level == 2345), "{settled:?}");
    device.velocity_m_per_s = 1.0;
    let generates = (0..40).map(|_| device.wind(Some(0.0)).0).last();
    assert!(generates.is_some_and(|share| (share * FULL_A + 8.0 / 4.8).abs() < 1e-3), "{generates:?}");
    assert_eq!(device.wind(None), (0.0, 2048));
}

#[test]
fn one_channel_changes_with_every_count() {
    for counts in -9..9 {
        let ([a, b], [next_a, next_b]) = (levels(counts), levels(counts + 1));
        assert_eq!(u8::from(a != next_a) + u8::from(b != next_b), 1, "{counts}");
    }
    assert_eq!([levels(1), levels(-1)], [[true, false], [false, true]]);
}
