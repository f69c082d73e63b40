//! When the relay rests and when it does not: the rule, tick by tick.

use super::*;

/// A direct path that is heard each millisecond of `good`, and not else; the milliseconds in which the relay is used.
fn used(from_ms: u64, to_ms: u64, good: impl Fn(u64) -> bool, paths: &mut Paths, start: Instant) -> Vec<u64> {
    let mut used = Vec::new();
    for ms in from_ms..to_ms {
        let now = start + Duration::from_millis(ms);
        if good(ms) {
            paths.heard(now, true);
            paths.said(now, true);
        }
        paths.look(now);
        if paths.uses_relay(now) {
            used.push(ms);
        }
    }
    used
}

#[test]
fn a_silence_of_15_ms_brings_the_relay_back_and_a_second_lets_it_rest() {
    let (start, silent) = (Instant::now(), 3000..4000);
    let mut paths = Paths::new(start);
    let used = used(0, 8000, |ms| !silent.contains(&ms), &mut paths, start);
    let first = 0..1000;
    // Heard last at 2999; a trial of two seconds from 4000 on.
    let second = 3015..6000;
    assert_eq!(used, first.chain(second).collect::<Vec<_>>());
}

#[test]
fn a_path_that_fails_again_and_again_is_tried_for_longer_and_longer() {
    let start = Instant::now();
    let mut paths = Paths::new(start);
    // 40 ms of silence every two seconds, for five minutes.
    let used = used(0, 300_000, |ms| ms % 2000 >= 40, &mut paths, start);
    let rests = (1..300_000).filter(|ms| used.binary_search(ms).is_err() && used.binary_search(&(ms - 1)).is_ok());
    assert_eq!(rests.count(), 1, "it rests once, after the first second, and then never for less than the trial");
}

#[test]
fn what_anybody_may_have_sent_keeps_no_path_alive() {
    let start = Instant::now();
    let mut paths = Paths::new(start);
    used(0, 2000, |_| true, &mut paths, start);
    for ms in 2000..2200 {
        let now = start + Duration::from_millis(ms);
        paths.heard(now, false);
        paths.said(now, true);
        paths.look(now);
        assert_eq!(paths.uses_relay(now), ms > 2099, "{ms} ms");
    }
}

#[test]
fn loss_and_round_trips_are_those_of_what_came() {
    let mut path = Path::new();
    for count in (10..110).filter(|count| count % 4 != 1) {
        path.came(count, Some(u64::from(count) * 1000));
    }
    let figures = path.figures();
    assert_eq!(figures.signals, 75);
    // 25 of 100 did not come; the last of them, 109, nobody can miss yet.
    assert!((figures.lost - 24.0 / 99.0).abs() < 1e-12, "{figures:?}");
    assert!((figures.round_trip_ms / 60.0 - 1.0).abs() < 0.03 && (figures.largest_ms / 108.0 - 1.0).abs() < 0.01);
}
