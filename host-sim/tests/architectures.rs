//! The architectures report: what must hold whatever the numbers are.

use host_sim::architectures::{Architecture, DELAYS_MS, Row, rows};

fn of(rows: &[Row], architecture: Architecture) -> Vec<&Row> {
    rows.iter().filter(|row| row.architecture == architecture).collect()
}

#[track_caller]
fn near(got: f64, want: f64, within: f64) {
    assert!((got - want).abs() <= within, "{got} is not {want}");
}

#[test]
fn every_architecture_does_what_it_is_chosen_for() {
    use Architecture::*;
    let rows = rows(&|| {}).expect("a report");
    assert_eq!(rows.len(), Architecture::ALL.len() * DELAYS_MS.len());
    // A copy each: coherent with nothing, at any delay.
    for row in of(&rows, Static) {
        assert!(row.stable);
        near(row.rests_mm[0], 100.0, 0.5);
        near(row.rests_mm[1], 90.0, 0.5);
    }
    // One after the other: apart while one carries, the same when it is placed, later with every delay.
    for scheme in [CollaborativeLock, CollaborativeRing] {
        let of_this = of(&rows, scheme);
        for row in &of_this {
            assert!(row.stable, "{row:?}");
            assert!(row.peak_discrepancy_mm > 30.0, "{row:?}");
            near(row.rests_mm[0], row.rests_mm[1], 1e-9);
            near(row.rests_mm[0], 90.0, 2.0);
        }
        assert!(of_this[7].placed_s > of_this[0].placed_s + 0.3, "{:?} {:?}", of_this[0], of_this[7]);
    }
    // One engine, equally far from both: the same body for both, stable with the bounder only.
    for row in of(&rows, CooperativeServer) {
        assert!(row.stable && row.peak_discrepancy_mm < 1e-3, "{row:?}");
    }
    assert!(of(&rows, CooperativeServerUnbounded).iter().filter(|row| row.delay_ms >= 10.0).all(|row| !row.stable));
    assert!(of(&rows, CooperativeClient).iter().all(|row| row.stable));
    // Copies held together: waves at any delay, power only while it is short; further apart with every delay.
    for law in [DistributedWave, DistributedPassiveWave, DistributedPassiveMean] {
        let of_this = of(&rows, law);
        assert!(of_this.iter().all(|row| row.stable));
        assert!(of_this.windows(2).all(|pair| pair[1].true_discrepancy_mm > pair[0].true_discrepancy_mm), "{law:?}");
    }
    for row in of(&rows, DistributedPower) {
        assert!(row.stable || row.delay_ms > 10.0, "{row:?}");
        assert!(!row.stable || row.delay_ms < 100.0, "{row:?}");
    }
}

/// Bytes against the layouts: 125 packets a second of flow (36), push (32) and state (48), 32 around each.
#[test]
fn bytes_are_those_of_the_wire() {
    let row = |architecture| host_sim::architectures::row(architecture, 20.0).expect("a run");
    near(row(Architecture::DistributedPower).user_bytes_per_s, 125.0 * 68.0, 1.0);
    let cooperative = row(Architecture::CooperativeServer);
    near(cooperative.user_bytes_per_s, 125.0 * 64.0, 1.0);
    near(cooperative.server_bytes_per_s, 2.0 * 125.0 * 80.0, 1.0);
    // A hand every 50 ms: 28 bytes.
    near(row(Architecture::Static).user_bytes_per_s, 20.0 * 60.0, 1.0);
    // A lock says little: its words are below those of hands.
    let lock = row(Architecture::CollaborativeLock);
    assert!(lock.user_bytes_per_s > 1200.0 && lock.user_bytes_per_s < 2400.0, "{lock:?}");
}
