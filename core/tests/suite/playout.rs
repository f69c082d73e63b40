//! Play-out over clocks that differ and drift, and over paths that change.

use cohold_core::playout::{MOST, Playout};

const M: u32 = 8;

/// Packets 0.. that take `took(number)` ticks on a wire whose two clocks differ by `offset`; `rate` is the sender's
/// clock over the receiver's. What is played at each of the receiver's exchanges.
fn played(
    count: u32,
    depth: u32,
    offset: u32,
    rate: f64,
    took: impl Fn(u32) -> u32,
) -> (Vec<Option<u32>>, Playout<u32>) {
    let mut playout = Playout::new(depth, M);
    // Arrival in ticks of the receiver, and number.
    let mut on_the_way: Vec<(u32, u32)> =
        (0..count).map(|number| ((f64::from(number * M) / rate) as u32 + took(number), number)).collect();
    on_the_way.sort_unstable();
    let (mut next, mut out) = (on_the_way.into_iter().peekable(), Vec::new());
    for local in 0..(f64::from(count * M) / rate) as u32 {
        while let Some((_, number)) = next.next_if(|(at, _)| *at <= local) {
            playout.put(local.wrapping_add(offset), number * M, number);
        }
        if local % M == 0 {
            out.push(playout.take(local.wrapping_add(offset)));
        }
    }
    (out, playout)
}

/// Whether tick `a` is after tick `b`, in a count that wraps.
fn after(a: u32, b: u32) -> bool {
    (a.wrapping_sub(b) as i32) > 0
}

/// Something that looks random in 0..=most.
fn noise(number: u32, most: u32) -> u32 {
    (number.wrapping_mul(2_654_435_761) >> 16) % (most + 1)
}

#[test]
fn every_packet_is_as_late_as_every_other_whatever_the_clocks_show() {
    for offset in [0, 5, 1_000_003, u32::MAX - 3_000, 1 << 31] {
        let (out, _) = played(4_000, 2, offset, 1.0, |number| M + noise(number, 12));
        // The fastest takes one packet period; two more are waited.
        let settled = 100;
        for (period, number) in out.iter().enumerate().skip(settled) {
            assert_eq!(*number, Some(period as u32 - 3), "period {period} with clocks {offset} apart");
        }
    }
}

#[test]
fn clocks_that_drift_skip_or_repeat_a_packet_when_a_whole_period_has_gathered_and_never_else() {
    for (rate, skips) in [(1.0 + 500e-6, true), (1.0 - 500e-6, false)] {
        let count = 100_000;
        let (out, _) = played(count, 3, 77, rate, |number| M + noise(number, 12));
        let (mut missed, mut empty, mut last) = (0, 0, None::<u32>);
        for number in out.into_iter().skip(100) {
            match (number, last) {
                (Some(number), Some(last)) => missed += number - last - 1,
                (None, _) => empty += 1,
                _ => {}
            }
            last = number.or(last);
        }
        // 500 ppm of 100,000 packets; the anchor moves in steps, which may cross a boundary there and back.
        let (wanted, unwanted) = if skips { (missed, empty) } else { (empty, missed) };
        assert!((48..=60).contains(&(wanted - unwanted)) && unwanted <= 8, "{missed} missed, {empty} empty");
    }
}

#[test]
fn a_path_that_becomes_longer_or_shorter_is_followed() {
    for (before, since) in [(M, 13 * M), (13 * M, M)] {
        let (out, _) = played(2_000, 2, 9, 1.0, |number| {
            let path = if number < 1_000 { before } else { since };
            path + noise(number, 12)
        });
        // Long after the change everything is as late as before it, measured from the new path.
        let late = since / M + 2;
        for (period, number) in out.iter().enumerate().skip(1_200) {
            assert_eq!(*number, Some(period as u32 - late), "period {period}");
        }
        // And no packet had to wait for that: silence is no longer than the change itself.
        let silent = out.iter().skip(100).filter(|number| number.is_none()).count();
        assert!(silent <= 20, "{silent} periods without a packet");
    }
}

#[test]
fn copies_and_the_past_are_refused() {
    let mut playout = Playout::new(1, M);
    assert!(playout.put(100, 0, 'a'));
    assert!(!playout.put(101, 0, 'a'));
    assert_eq!((playout.take(107), playout.take(108), playout.take(109)), (None, Some('a'), None));
    assert!(!playout.put(109, 0, 'a') && !playout.put(110, u32::MAX - 7, 'z'));
    assert!(playout.put(110, 8, 'b'));
    playout.clear();
    assert!(playout.waiting() == 0 && playout.put(5, 0, 'c'));
    assert_eq!(playout.take(13), Some('c'));
}

#[test]
fn more_than_can_wait_drops_the_oldest() {
    let mut playout = Playout::new(1_000, M);
    for number in 0..=MOST as u32 {
        assert!(playout.put(number * M, number * M, number));
    }
    assert_eq!(playout.waiting(), MOST);
    assert_eq!(playout.take(1_000 * M), None);
    assert_eq!(playout.take(1_001 * M), Some(1));
    // One that is older than all that wait is the oldest itself.
    let mut playout = Playout::new(1_000, M);
    for number in 1..=MOST as u32 {
        assert!(playout.put(number * M, number * M, number));
    }
    assert!(!playout.put(65 * M, 0, 0) && playout.put(65 * M, 65 * M, 65));
    assert_eq!(playout.take(1_002 * M), Some(2));
}

#[test]
fn anything_at_any_time_is_played_in_order_or_not_at_all() {
    let mut random = 1_u64;
    let mut draw = || {
        // Knuth's generator: its upper half.
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as u32
    };
    let (mut playout, mut last) = (Playout::new(3, M), None::<u32>);
    for step in 0..200_000_u32 {
        // Mostly about now, now and then from anywhere.
        let tick = if draw() % 100 == 0 { draw() << 1 } else { step.wrapping_sub(draw() % 64) };
        let kept = playout.put(step, tick, tick);
        assert!(!kept || last.is_none_or(|last| after(tick, last)));
        assert!(playout.waiting() <= MOST);
        if let Some(played) = playout.take(step) {
            assert!(last.is_none_or(|last| after(played, last)), "{played} after {last:?}");
            last = Some(played);
        }
    }
}
