//! A network that is measured: over a relay with known delays and losses, and what answers alone would say.

use cohold_sim::network::link::Route;
use cohold_sim::network::rule::Fate;

use super::*;
use crate::relay::{self, End};

#[path = "../../../tests/suite/program/free.rs"]
mod free;
use free::free;

const MS: u64 = 1_000_000;

/// Over a relay: the constant delay is found, what varies in its own direction, and what is lost where it was lost.
#[test]
fn a_relay_s_delays_and_losses_are_found() {
    let [prober, listener, first, second] = [(); 4].map(|()| free());
    // There: 10 ms, every fifth packet 5 ms later, which holds up nobody and is overtaken by none. Back: 10 ms, every tenth is lost.
    let there = |number: u64, _: u64| if number % 5 == 4 { Fate::late(5 * MS) } else { Fate::Pass };
    let back = |number: u64, _: u64| if number % 10 == 9 { Fate::Drop } else { Fate::Pass };
    let routes = [Route::new(10 * MS).with_rule(there), Route::new(10 * MS).with_rule(back)];
    let ends = [End { listen: first, peer: prober }, End { listen: second, peer: listener }];
    let stop = Stop::default();
    let (found, listened, counts) = thread::scope(|scope| {
        let relay = scope.spawn(|| relay::run(routes, ends, 20.0, &stop));
        let listening = scope.spawn(|| listen(listener, 20.0, &stop, |_| ()));
        thread::sleep(Duration::from_millis(200));
        let found = probe(first, Some(prober), 0.01, 2.005, &Stop::default());
        stop.ask();
        (found, listening.join().expect("a listener"), relay.join().expect("a relay"))
    });
    let (found, listened) = (found.expect("answers"), listened.expect("a listener"));
    let [there, back] = counts.expect("a relay").ways;
    // One more than a tenth lost: of those after the last answer nobody knows where.
    assert_eq!((found.sent, found.answered), (201, 181));
    assert_eq!((there.taken, listened.answered, back.lost), (201, 201, 20));
    // Where one that was lost is told from one that was overtaken, by the count of what came: a busy machine has them overtake.
    assert!(found.lost.iter().sum::<u64>() == 20 && found.lost[0] <= 2, "{:?}", found.lost);
    // A relay looks every 0.2 ms, and a loaded machine later.
    assert!((10.0..13.0).contains(&found.constant_ms), "{} ms", found.constant_ms);
    assert!((4.0..20.0).contains(&found.most_ms[0]), "{:?} ms", found.most_ms);
    // Written as a scene reads it.
    let file = std::env::temp_dir().join(format!("cohold-measured-{}.csv", std::process::id()));
    found.trace.write(&file).expect("a file");
    let mut read = NetworkTrace::read(&file).expect("a trace");
    std::fs::remove_file(&file).expect("it was there");
    read.file = found.trace.file.clone();
    assert_eq!(read, found.trace);
}

/// Answers of a line of 5 ms there and 7 back between clocks that are an hour apart, the other one faster by 50 ppm; of every ten probes the
/// fifth is lost there and the sixth back, which the count tells apart where they are alone.
#[test]
fn clocks_that_run_unlike_and_losses_each_way_are_told_apart() {
    let (hour_ns, faster) = (3_600_000_000_000_u64, 50e-6);
    let other = |at_ns: u64| hour_ns + at_ns + (faster * at_ns as f64) as u64;
    let (mut count, mut answers) = (0, Vec::new());
    const SENT: u64 = 60_000;
    for number in 0..SENT {
        let left_ns = number * MS;
        if number % 10 == 4 {
            continue;
        }
        count += 1;
        let came_ns = left_ns + 5 * MS + number % 3 * MS;
        if number % 10 == 7 {
            continue;
        }
        let answered_ns = came_ns + 10_000;
        let stamps = Stamps { number, left_ns, count, came_ns: other(came_ns), answered_ns: other(answered_ns) };
        answers.push((stamps, answered_ns + 7 * MS));
    }
    let found = measured(SENT, &answers).expect("answers");
    assert_eq!(found.lost, [SENT / 10, SENT / 10], "{found:?}");
    assert!((found.drift_ppm - 50.0).abs() < 0.5, "{found:?}");
    assert!((found.constant_ms - 6.0).abs() < 1e-3, "{found:?}");
    // What varies is there and only there; without the drift it would grow to 3 ms on the way back.
    assert!((found.most_ms[0] - 2.0).abs() < 0.05 && found.most_ms[1] < 0.05, "{found:?}");
    assert!(measured(10, &[]).is_none());
}

/// Whatever is no probe is not answered, an answer is as long as what it answers, and the bounds hold.
#[test]
fn nobody_is_served_who_does_not_measure() {
    let stamps = Stamps { number: 1, left_ns: 2, count: 3, came_ns: 4, answered_ns: u64::MAX };
    assert_eq!(Stamps::read(&stamps.bytes()), Some(stamps));
    assert_eq!(Stamps::read(&stamps.bytes()[..LEN - 1]), None);
    assert_eq!(Stamps::read(&[0; LEN]), None);
    let stop = Stop::default();
    assert!(probe(free(), None, 1e-4, 1.0, &stop).is_err() && probe(free(), None, 1e-3, 2.0 * MOST_S, &stop).is_err());
    let address = free();
    let listened = thread::scope(|scope| {
        let listening = scope.spawn(|| listen(address, 20.0, &stop, |_| ()));
        thread::sleep(Duration::from_millis(200));
        let stranger = bound(([127, 0, 0, 1], 0).into()).expect("a socket");
        for datagram in [&b"hello"[..], &[0; LEN], &[0; 300]] {
            stranger.send_to(datagram, address).expect("loopback");
        }
        let silent = stranger.recv(&mut [0; 400]).is_err();
        stop.ask();
        (listening.join().expect("a listener").expect("a socket"), silent)
    });
    assert_eq!(listened, (Listened { answered: 0, ignored: 3 }, true));
}
