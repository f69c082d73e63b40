//! Who wants to edit, and for how long one may.

use cohold_environments::roles::collaborative::{Approach, Lease, Wish};

#[test]
fn between_the_two_distances_nothing_changes() {
    let approach = Approach { near_m: 0.02, far_m: 0.03 };
    let wishes = [0.019, 0.025, 0.031, f32::NAN].map(|distance| approach.wish(distance));
    assert_eq!(wishes, [Wish::Edit, Wish::AsBefore, Wish::Leave, Wish::AsBefore]);
}

#[test]
fn the_holder_stops_first_on_the_worst_pair_of_clocks() {
    let drift = f64::from(Lease::MAX_DRIFT_PPM) * 1e-6;
    for us in [Lease::SHORTEST_US, 300_000, Lease::LONGEST_US] {
        let lease = Lease::new(us).unwrap();
        // A slow clock counts more true time.
        let (held, given) = (lease.holder_us() as f64 / (1.0 - drift), lease.giver_us() as f64 / (1.0 + drift));
        assert!(held < given, "{held} {given}");
    }
    assert!(Lease::new(Lease::SHORTEST_US - 1).is_err() && Lease::new(Lease::LONGEST_US + 1).is_err());
}
