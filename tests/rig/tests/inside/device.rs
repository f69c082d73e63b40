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
    device.moved_by(Moves::Sweep(4));
    let mut at = 0_i32;
    for _ in 0..5000 {
        let before = at;
        at += (0..20).map(|_| device.step(0.0)).sum::<i32>();
        assert!(at.abs() <= SPAN && (at - before).abs() <= 5, "{at}");
    }
}

#[test]
fn a_shake_is_elsewhere_in_every_tick_and_comes_back() {
    let mut device = Device::default();
    device.moved_by(Moves::Shake(10));
    let moved: Vec<i32> = (0..6).map(|_| (0..TICK).map(|_| device.step(0.0)).sum()).collect();
    assert_eq!(moved, [10, -10, 10, -10, 10, -10]);
}

#[test]
fn one_channel_changes_with_every_count() {
    for counts in -9..9 {
        let ([a, b], [next_a, next_b]) = (levels(counts), levels(counts + 1));
        assert_eq!(u8::from(a != next_a) + u8::from(b != next_b), 1, "{counts}");
    }
    assert_eq!([levels(1), levels(-1)], [[true, false], [false, true]]);
}
