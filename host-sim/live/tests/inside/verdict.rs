use super::*;

/// A judge who answers when the test does, at a clock that is the test's.
struct Bench {
    judging: Judging,
    asked: Receiver<Measured>,
    answers: SyncSender<Verdict>,
    now_us: u64,
}

impl Bench {
    fn new(unless: Option<&'static str>) -> Self {
        let ((asks, asked), (answers, answered)) = (sync_channel(1), sync_channel(1));
        Self { judging: Judging::new(asks, answered, unless, 1e-3), asked, answers, now_us: 0 }
    }

    /// So many exchanges of this round trip, one every 10 ms; the other clock is another one, and answers after 3 ms.
    fn exchanges(&mut self, count: usize, round_trip_us: u64) {
        for _ in 0..count {
            self.now_us += 10_000;
            let there = 77_000_000 + self.now_us;
            self.judging.see(Some([self.now_us, there, there + 3_000, self.now_us + 3_000 + round_trip_us]));
        }
    }

    /// What is asked now, ms one way.
    fn asks(&mut self, armed: bool) -> Option<[f64; 2]> {
        assert_eq!(self.judging.look(self.now_us, armed), None);
        self.asked.try_recv().ok().map(|measured| measured.one_way_s.map(|s| 1e3 * s))
    }

    /// What is said of this answer.
    fn answers(&mut self, stable: Option<bool>, armed: bool) -> Option<String> {
        let verdict = Verdict { one_way_ms: [1.0, 2.0], stable, text: "as it is".to_owned(), ..Verdict::default() };
        self.answers.send(verdict).expect("it listens");
        self.judging.look(self.now_us, armed)
    }

    /// A second goes by.
    fn waits(&mut self) {
        self.now_us += AGAIN_US;
    }
}

fn close(asked: Option<[f64; 2]>, wanted: [f64; 2]) {
    let asked = asked.expect("it asks");
    assert!(asked.iter().zip(wanted).all(|(asked, wanted)| (asked - wanted).abs() < 1e-9), "{asked:?}, {wanted:?}");
}

#[test]
fn it_asks_after_enough_round_trips_and_waits_for_the_answer() {
    let mut bench = Bench::new(Some("say anyway"));
    bench.exchanges(LEAST - 1, 4_000);
    // The same exchange over and over is one.
    let newest = bench.judging.exchange;
    (0..10).for_each(|_| bench.judging.see(newest));
    assert_eq!(bench.asks(false), None);
    bench.exchanges(1, 4_000);
    close(bench.asks(false), [2.0, 2.0]);
    assert!(!bench.judging.lets_arm());
    // While it is being judged nothing else is asked.
    bench.exchanges(KEPT, 16_000);
    bench.waits();
    assert_eq!(bench.asks(false), None);
    let said = bench.answers(Some(true), false).expect("the first verdict is said");
    assert_eq!(said, "the scene at 1.00 to 2.00 ms one way: as it is");
    assert!(bench.judging.lets_arm() && bench.judging.refuses().is_none());
}

#[test]
fn a_refused_peer_looks_again_when_the_network_moves() {
    let mut bench = Bench::new(Some("say anyway"));
    bench.exchanges(LEAST, 4_000);
    close(bench.asks(false), [2.0, 2.0]);
    let said = bench.answers(Some(false), false).expect("it is said");
    assert!(said.ends_with("as it is. It does not arm until the network is better; say anyway"), "{said}");
    assert!(!bench.judging.lets_arm() && bench.judging.refuses().is_some());
    // The same delay is not judged twice, another one is, but not at once.
    bench.waits();
    assert_eq!(bench.asks(false), None);
    // Of what was before a step nothing counts, and nothing is asked while it is not clear where it leads.
    bench.exchanges(KEPT, 4_000);
    for _ in 0..LEAST - 1 {
        bench.exchanges(1, 1_000);
        assert_eq!(bench.asks(false), None);
    }
    bench.exchanges(1, 1_000);
    close(bench.asks(false), [0.5, 0.5]);
    assert_eq!(bench.answers(Some(false), false), None, "it is as it was");
    bench.exchanges(KEPT, 2_500);
    assert_eq!(bench.asks(false), None);
    bench.waits();
    close(bench.asks(false), [1.25, 1.25]);
    assert!(bench.answers(Some(true), false).is_some() && bench.judging.lets_arm());
    assert_eq!(bench.judging.said.len(), 2);
}

#[test]
fn an_armed_peer_is_told_and_stays_armed() {
    let mut bench = Bench::new(Some("say anyway"));
    bench.exchanges(LEAST, 100);
    bench.asks(false);
    bench.answers(Some(true), false);
    for (stable, round_trip_us) in [(Some(false), 4_000), (Some(true), 100), (None, 400_000)] {
        bench.exchanges(KEPT, round_trip_us);
        bench.waits();
        assert!(bench.asks(true).is_some());
        let said = bench.answers(stable, true).expect("it is said");
        assert_eq!(said.ends_with("as it is. It stays armed"), stable == Some(false), "{said}");
    }
    assert_eq!(bench.judging.said.len(), 4);
}

/// Whoever is to arm anyway, and whoever was not judged, is not refused.
#[test]
fn what_is_not_judged_is_not_refused() {
    for (unless, stable, ends) in [(None, Some(false), "It arms all the same"), (Some("say so"), None, "as it is")] {
        let mut bench = Bench::new(unless);
        bench.exchanges(LEAST, 4_000);
        bench.asks(false);
        let said = bench.answers(stable, false).expect("it is said");
        assert!(said.ends_with(ends) && bench.judging.lets_arm() && bench.judging.refuses().is_none(), "{said}");
    }
}

/// One round trip in eight that is far out, as on a busy machine, does not count; a range that is there all the time does.
#[test]
fn a_late_tick_is_no_delay() {
    let mut bench = Bench::new(None);
    for _ in 0..KEPT / 8 {
        bench.exchanges(7, 4_000);
        bench.exchanges(1, 40_000);
    }
    close(bench.asks(false), [2.0, 2.0]);
    let mut bench = Bench::new(None);
    for _ in 0..KEPT / 2 {
        bench.exchanges(1, 4_000);
        bench.exchanges(1, 6_000);
    }
    close(bench.asks(false), [2.0, 3.0]);
}

/// The judge of a real one has a thread, and ends with it.
#[test]
fn a_thread_judges() {
    let find = |Measured { one_way_s: [least_s, most_s], .. }: Measured| Verdict {
        one_way_ms: [1e3 * least_s, 1e3 * most_s],
        stable: Some(most_s < 1e-3),
        ..Verdict::default()
    };
    let mut judging = Judging::start(&Judge { find: Arc::new(find), unless: Some("") }, 1e-3).expect("a thread");
    (1..=LEAST as u64).for_each(|at| judging.see(Some([at, 0, 0, at + 5_000])));
    let end = std::time::Instant::now() + std::time::Duration::from_secs(10);
    while judging.verdict.is_none() && std::time::Instant::now() < end {
        judging.look(0, false);
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    close(judging.refuses().map(|verdict| verdict.one_way_ms), [2.5, 2.5]);
}

/// The device of this end is part of what is asked, once it has been read, and again when it has become later.
#[test]
fn it_asks_about_the_device_as_late_as_it_is_read() {
    let mut bench = Bench::new(None);
    let seen = Seen::default();
    bench.judging = bench.judging.of_device(Some(seen.clone()));
    bench.exchanges(LEAST, 4_000);
    assert_eq!(bench.asks(false), None, "nobody has read it");
    let ticks = |bench: &mut Bench| {
        bench.judging.look(bench.now_us, false);
        bench.asked.try_recv().ok().map(|measured| measured.device_ticks)
    };
    // What the next tick reads is asked for right after this one; a tick may come late by a little.
    (0..95).for_each(|_| seen.act(std::time::Duration::from_micros(960)));
    (0..5).for_each(|_| seen.act(std::time::Duration::from_micros(7_000)));
    assert_eq!(ticks(&mut bench), Some(Some(1)));
    let said = bench.judging.words(false);
    assert_eq!(said, None, "there is no verdict yet");
    let verdict =
        Verdict { device_delay_ticks: Some(1), stable: Some(true), text: "as it is".to_owned(), ..Verdict::default() };
    bench.answers.send(verdict).expect("it listens");
    let said = bench.judging.look(bench.now_us, false);
    assert_eq!(said.as_deref(), Some("the scene at 0.00 to 0.00 ms one way, its device late by 1 tick: as it is"));
    (0..2_000).for_each(|_| seen.act(std::time::Duration::from_micros(2_400)));
    assert_eq!(ticks(&mut bench), None, "not at once");
    bench.waits();
    assert_eq!(ticks(&mut bench), Some(Some(3)));
    // Only the newest count: after a minute as well, a device that has become later is so within four seconds, and prompt again as soon.
    (0..60_000).for_each(|_| seen.act(std::time::Duration::from_micros(2_400)));
    for (age_us, late) in [(5_900, 6), (960, 1)] {
        (0..4_000).for_each(|_| seen.act(std::time::Duration::from_micros(age_us)));
        assert_eq!(seen.delay_ticks(1e-3), Some(late));
    }
    // A hiccup of a tenth of a second is none.
    (0..100).for_each(|_| seen.act(std::time::Duration::from_micros(40_000)));
    (0..2_000).for_each(|_| seen.act(std::time::Duration::from_micros(960)));
    assert_eq!(seen.delay_ticks(1e-3), Some(1));
}
