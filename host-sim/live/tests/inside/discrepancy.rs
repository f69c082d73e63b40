//! Two copies on known courses, two clocks, and what one tells the other.

use cohold_protocol::wire::Telemetry;

use super::{PositionHistory, Sum};
use crate::recording::common_clock::Watched;

/// The other clock is 7 s ahead, the other copy 2 mm behind; both go at 0.1 m/s.
#[test]
fn the_distance_is_that_of_one_instant() {
    let (mut clock, mut own, mut sum) = (Watched::default(), PositionHistory::default(), Sum::default());
    let telemetry =
        |at_s: f64| Telemetry { mode: 1, object_position: (0.1 * at_s - 0.002) as f32, ..Telemetry::default() };
    for tick in 0..4000_u64 {
        let now_us = 1_000_000 + 1000 * tick;
        clock.see(Some([now_us - 400, now_us + 6_999_800, now_us + 6_999_800, now_us]));
        own.is_at(now_us as f64 * 1e-6, 1e-7 * now_us as f64);
        if tick % 50 == 49 {
            clock.look();
            // It took 30 ms, and reported the tick before the one in which it was sealed.
            let sealed_us = now_us - 30_000 + 7_000_000;
            let said = telemetry(1e-6 * (now_us - 31_000) as f64);
            let Some(discrepancy) = own.discrepancy(&said, sealed_us, 0.001, &clock) else { panic!("tick {tick}") };
            sum.add(discrepancy);
            assert!((discrepancy.offset_m + 0.002).abs() < 1e-6, "{discrepancy:?}");
            // Half of 400 µs and some, at 0.1 m/s.
            assert!((20e-6..30e-6).contains(&discrepancy.error_m), "{discrepancy:?}");
        }
    }
    assert!((sum.rms_m().unwrap() - 0.002).abs() < 1e-6 && (sum.mean_m().unwrap() - 0.002).abs() < 1e-6);
    // Not armed, of a time before all that is kept, after it: nothing is said.
    assert_eq!(own.discrepancy(&Telemetry::default(), 10_000_000, 0.001, &clock), None);
    assert_eq!(own.discrepancy(&telemetry(0.0), 8_000_000, 0.001, &clock), None);
    assert_eq!(own.discrepancy(&telemetry(0.0), 20_000_000, 0.001, &clock), None);
    assert_eq!(Sum::default().rms_m(), None);
}

/// Copies that swing together, and a path that delays one way only: where they turn, too, what is said is within its error.
#[test]
fn the_error_is_how_far_a_copy_goes_within_the_clocks_error() {
    let course = |at_s: f64| 0.05 * (std::f64::consts::TAU * at_s).sin();
    for [there_us, back_us] in [[60_000, 0], [0, 60_000], [100, 100]] {
        let (mut clock, mut own) = (Watched::default(), PositionHistory::default());
        for tick in 0..4000_u64 {
            let now_us = 1_000_000 + 1000 * tick;
            let sent_us = now_us - there_us - back_us;
            clock.see(Some([sent_us, sent_us + there_us + 7_000_000, sent_us + there_us + 7_000_000, now_us]));
            own.is_at(now_us as f64 * 1e-6, course(now_us as f64 * 1e-6));
            if tick > 500 && tick % 20 == 19 {
                clock.look();
                let sealed_us = now_us - back_us;
                let at_s = 1e-6 * (sealed_us - 1_000) as f64;
                let said = Telemetry { mode: 1, object_position: course(at_s) as f32, ..Telemetry::default() };
                let discrepancy = own.discrepancy(&said, sealed_us + 7_000_000, 0.001, &clock).expect("a distance");
                assert!(
                    discrepancy.offset_m.abs() <= discrepancy.error_m + 1e-6,
                    "{there_us}: {discrepancy:?} at {at_s}"
                );
            }
        }
    }
}
