//! What waits, for how long, and in which order: ms by ms.

use super::*;

/// A hold whose paths' signals take so long, ms, and the times at which datagrams of one a ms come out of it: `(came, left)`, ms.
fn run(hold: &mut Hold, took_ms: [u64; 2], ms: std::ops::Range<u64>, start: Instant) -> Vec<(u64, u64)> {
    let mut left = Vec::new();
    for at in ms {
        let now = start + Duration::from_millis(at);
        for (direct, took_ms) in [false, true].into_iter().zip(took_ms) {
            // The other end's clock is an hour ahead.
            hold.took(now, direct, 1000 * (3_600_000 + at - took_ms), 1000 * at);
        }
        while let Some(datagram) = hold.release(now) {
            left.push((u64::from_le_bytes(datagram.try_into().unwrap()), at));
        }
        if !hold.takes(now, &at.to_le_bytes()) {
            left.push((at, at));
        }
    }
    left
}

#[test]
fn a_path_that_became_shorter_is_as_long_as_before_and_then_slowly_as_short_as_it_is() {
    let (start, mut hold) = (Instant::now(), Hold::default());
    assert!(run(&mut hold, [40, 8], 0..100, start).iter().all(|(came, left)| came == left), "nothing to wait for");
    hold.is_relayed();
    let left = run(&mut hold, [40, 8], 100..1000, start);
    assert_eq!(
        left.iter().map(|(came, _)| *came).collect::<Vec<_>>(),
        (100..1000).collect::<Vec<_>>(),
        "in order, all"
    );
    for (came, left) in left {
        // 32 ms less a ms in 20 of what has gone by since the first left, as a staircase of ms.
        let exact = (32.0 - (left as f64 - 132.0) / 20.0).clamp(0.0, 32.0);
        assert!(((left - came) as f64 - exact).abs() <= 1.0, "{came} left at {left}, {exact} held");
    }
}

#[test]
fn a_relay_that_is_no_longer_than_the_direct_path_holds_nothing() {
    let (start, mut hold) = (Instant::now(), Hold::default());
    run(&mut hold, [8, 8], 0..10, start);
    hold.is_relayed();
    assert!(run(&mut hold, [6, 8], 10..100, start).iter().all(|(came, left)| came == left));
}

#[test]
fn what_nobody_has_measured_waits_for_the_longest_and_no_flood_fills_it() {
    let (start, mut hold) = (Instant::now(), Hold::default());
    hold.is_relayed();
    let at = |ms| start + Duration::from_millis(ms);
    assert!((0..ROOM as u64).all(|number| hold.takes(at(0), &number.to_le_bytes())));
    assert!(!hold.takes(at(0), b"one too many"));
    assert!(hold.release(at(199)).is_none() && hold.release(at(200)).is_some());
    // Measured of late is what counts: times of more than a second ago do not.
    let mut hold = Hold::default();
    hold.took(at(0), false, 0, 40_000);
    hold.took(at(0), true, 0, 8_000);
    hold.is_relayed();
    assert!(hold.takes(at(1100), b"unknown") && hold.release(at(1150)).is_none());
    // A clock that is nobody's makes no hold longer than the longest.
    hold.took(at(1160), false, u64::MAX, 0);
    hold.took(at(1160), true, 1 << 63, 0);
    assert!(hold.release(at(1300)).is_some());
}

#[test]
fn the_relay_is_taken_for_what_it_takes_at_its_best() {
    let (start, mut least) = (Instant::now(), Least::default());
    let at = |ms| start + Duration::from_millis(ms);
    for (ms, us) in [(0, 50_000), (100, 40_000), (200, 90_000), (600, 70_000)] {
        least.took(at(ms), us);
    }
    assert_eq!(least.get(at(900)), Some(40_000));
    assert_eq!(least.get(at(1150)), Some(70_000), "the window before last is over");
    assert_eq!(least.get(at(2200)), None);
}
