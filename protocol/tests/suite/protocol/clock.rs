//! The other peer's clock: offset, drift and jitter as they are, and never nonsense.

use cohold_protocol::clock::{Clock, Implausible};
use proptest::prelude::*;

use crate::protocol::world::{CLEAN, Impairment, World};

#[test]
fn four_times_by_hand() {
    let mut clock = Clock::default();
    assert_eq!((clock.round_trip_us(), clock.offset_us(0)), (None, None));
    // There 1000 ahead; 30 to get there, 5 to answer, 30 back.
    assert_eq!(clock.sample(100, 1_130, 1_135, 165), Ok(60));
    assert_eq!((clock.round_trip_us(), clock.offset_us(165)), (Some(60), Some(1_000)));
    // A slower one does not move the offset.
    assert_eq!(clock.sample(1_000, 2_530, 2_535, 1_565), Ok(560));
    assert_eq!(clock.offset_us(1_565), Some(1_000));
    assert_eq!(clock.round_trip_us(), Some(60 + 500 / 8));
    // Answered at once; the longest that is believed; offsets whose halves do not come out even.
    assert_eq!(Clock::default().sample(0, 7, 7, 0), Ok(0));
    assert_eq!(Clock::default().sample(0, 0, 0, 10_000_000), Ok(10_000_000));
    for (t2, t4, offset) in [(3, 2, 2), (4, 1, 3), (3, 1, 2), (5, 7, 1)] {
        let mut clock = Clock::default();
        clock.sample(0, t2, t2, t4).unwrap();
        // ((t2 − t1) + (t3 − t4))/2, towards 0.
        assert_eq!(clock.offset_us(t4), Some(offset), "{t2} {t4}");
    }
}

#[test]
fn offset_drift_and_jitter_through_two_links() {
    for (ppm, jitter, offset_bound, drift_bound) in
        [(0.0, 0, 2, 0.1), (190.0, 0, 20, 0.5), (-190.0, 12_000, 1_500, 20.0), (100.0, 4_000, 700, 7.0)]
    {
        let mut world = World::new(1, Impairment { delay: 5_000, jitter, ..CLEAN });
        world.clocks[1] = (3_600_000_000, 1.0 + ppm * 1e-6);
        world.run(90_000_000);
        let (here, there) = (world.clock(0), world.clock(1));
        let clock = world.links[0].clock();
        let offset_error = clock.offset_us(here).unwrap() - (there as i64 - here as i64);
        // The harness delivers on whole milliseconds: two ways of equal length may differ by one.
        assert!(offset_error.abs() <= offset_bound, "{ppm} ppm, {jitter} µs: offset off by {offset_error} µs");
        let drift_error = f64::from(clock.drift_ppm()) - ppm;
        assert!(drift_error.abs() < drift_bound, "{ppm} ppm, {jitter} µs: drift off by {drift_error} ppm");
        let round_trip = i64::from(clock.round_trip_us().unwrap());
        assert!((round_trip - 10_000 - jitter as i64).abs() < 4_000, "{round_trip}");
        assert_eq!(jitter == 0, clock.jitter_us() < 500, "{}", clock.jitter_us());
        println!("{ppm} ppm, {jitter} µs jitter: offset off by {offset_error} µs, drift by {drift_error:.2} ppm");
    }
}

/// Whoever delays what is sent can feign any drift: what no quartz has is not believed.
#[test]
fn a_drift_above_200_ppm_is_refused() {
    for ppm in [250.0, -4_000.0] {
        let mut world = World::new(1, Impairment { delay: 5_000, ..CLEAN });
        world.clocks[1] = (3_600_000_000, 1.0 + ppm * 1e-6);
        world.run(90_000_000);
        let clock = world.links[0].clock();
        assert_eq!(clock.drift_ppm(), 0.0, "{ppm}");
        let offset_error = clock.offset_us(world.clock(0)).unwrap() - (world.clock(1) as i64 - world.clock(0) as i64);
        // What it runs away in the two seconds from which the offset is taken, and the next two.
        assert!(offset_error.abs() < (4.0 * ppm.abs()) as i64 + 1_000, "{ppm}: {offset_error} µs");
    }
}

#[test]
fn a_peer_that_restarts_is_measured_anew() {
    let mut world = World::engaged(2);
    world.clocks[1] = (9_000_000_000, 1.0);
    world.restart(1);
    world.run(400_000);
    let error = world.links[0].clock().offset_us(world.clock(0)).unwrap() - (9_000_000_000 - 5_000_000);
    assert!(error.abs() < 100, "{error}");
}

#[test]
fn impossible_times_are_refused() {
    let mut clock = Clock::default();
    for (t1, t2, t3, t4) in [
        (100, 0, 0, 99),            // Back before it left.
        (0, 10, 5, 20),             // Answered before it came.
        (0, 0, 50, 40),             // Longer there than away.
        (0, 0, 0, 10_000_001),      // Ages ago.
        (0, u64::MAX, u64::MAX, 1), // An offset that does not fit.
        (u64::MAX, 0, 0, 0),
    ] {
        assert_eq!(clock.sample(t1, t2, t3, t4), Err(Implausible), "{t1} {t2} {t3} {t4}");
    }
    assert_eq!(clock.round_trip_us(), None);
}

proptest! {
    #[test]
    fn estimates_are_finite_whatever_comes(times in prop::collection::vec(any::<[u64; 4]>(), 0..50),
                                           near in prop::collection::vec((0..u64::MAX / 2, any::<u64>(), 0..1_000_000u64), 0..200)) {
        let mut clock = Clock::default();
        for [t1, t2, t3, t4] in times {
            let _ = clock.sample(t1, t2, t3, t4);
        }
        for (t1, t2, trip) in near {
            let _ = clock.sample(t1, t2, t2, t1 + trip);
            prop_assert!(clock.drift_ppm().is_finite());
            prop_assert!(clock.drift_ppm().abs() <= 200.0);
            prop_assert!(clock.timeout_us(16_000) <= 500_000);
            let _ = clock.offset_us(u64::MAX);
        }
    }
}
