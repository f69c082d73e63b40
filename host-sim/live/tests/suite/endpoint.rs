//! The runner of live actors: ticks, floods, goodbyes; and the relay on it, under a planted rule.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use cohold_live::Error;
use cohold_live::batch::ReceivedBatch;
use cohold_live::endpoint::{Endpoint, Live, Punctuality, Stop, Ticker, realtime};
use cohold_live::relay;
use cohold_sim::engine::{Actor, Out};
use cohold_sim::network::link::Route;
use cohold_sim::network::rule::Fate;

/// Counts what it hears; sends itself twice as much of it, so that its socket is never empty again; ends after 20 ticks.
struct Echo {
    own: SocketAddr,
    heard: u64,
    ticks: u32,
    goodbyes: u32,
    alone: bool,
}

impl Actor<SocketAddr> for Echo {
    type Packet = [u8];

    fn hear(&mut self, _: u64, from: SocketAddr, packet: &mut [u8], out: &mut Out<'_, SocketAddr, [u8]>) {
        self.heard += 1;
        self.own = from;
        out(from, packet);
        out(from, packet);
    }

    fn act(&mut self, _: u64, out: &mut Out<'_, SocketAddr, [u8]>) {
        self.ticks += 1;
        out(self.own, &[1]);
    }
}

impl Live for Echo {
    fn end(&mut self) -> Option<Result<(), Error>> {
        (self.ticks == 20).then_some(Ok(()))
    }

    fn missing(&self) -> Option<String> {
        self.alone.then(|| "nobody".to_owned())
    }

    fn goodbye(&mut self, _: u64, _: &mut Out<'_, SocketAddr, [u8]>) {
        self.goodbyes += 1;
    }
}

/// What came of a run, and how many ticks and goodbyes there were.
fn run(open: fn(SocketAddr) -> Result<Endpoint, Error>, alone: bool, stop: &Stop) -> (Result<u64, String>, Echo) {
    let endpoint = open(SocketAddr::from(([127, 0, 0, 1], 0))).expect("a socket on loopback");
    let mut echo = Echo { own: endpoint.address, heard: 0, ticks: 0, goodbyes: 0, alone };
    let kept = endpoint.run(Ticker::new(Duration::from_millis(5)), 0.02, stop, &mut echo);
    (kept.map(|kept| kept.ticks).map_err(|why| why.to_string()), echo)
}

#[test]
fn ticks_are_counted_and_so_is_their_lateness() {
    let mut ticker = Ticker::new(Duration::from_secs(60));
    ticker.wait();
    assert_eq!((ticker.kept.ticks, ticker.kept.missed), (1, 0), "{ticker:?}");
    let mut ticker = Ticker::new(Duration::from_millis(10));
    let mut late = ticker.wait();
    std::thread::sleep(Duration::from_millis(45));
    // Due at 10 ms and 20 ms, and not skipped.
    (0..2).for_each(|_| late += ticker.wait());
    let Punctuality { ticks, missed, worst_us, .. } = ticker.kept;
    assert!(ticks == 3 && (2..=3).contains(&missed) && worst_us >= 35_000, "{ticker:?}");
    let mean_us = late.as_micros() as f64 / 3.0;
    assert!(mean_us >= 20_000.0 && mean_us <= worst_us as f64, "{mean_us}: {ticker:?}");
}

/// What the system says of this thread is what [`realtime`] says.
#[cfg(target_os = "linux")]
#[test]
fn a_realtime_priority_is_told_as_it_is() {
    let (told, policy) = std::thread::spawn(|| {
        let told = realtime();
        let stat = std::fs::read_to_string("/proc/thread-self/stat").expect("a thread's state");
        // Field 41 of proc(5), counted behind the name, which is field 2: 1 is SCHED_FIFO.
        (told, stat.rsplit(") ").next().and_then(|rest| rest.split(' ').nth(38)).map(str::to_owned))
    })
    .join()
    .expect("a thread");
    assert_eq!(told, policy.as_deref() == Some("1"), "{policy:?}");
}

#[test]
fn a_flood_holds_up_no_tick_and_every_end_has_its_goodbye() {
    let stop = Stop::default();
    for open in [Endpoint::polled, Endpoint::answering] {
        let start = Instant::now();
        let (kept, echo) = run(open, false, &stop);
        assert!(kept == Ok(20) && echo.heard > 1_000 && echo.goodbyes == 1, "{kept:?}, {} heard", echo.heard);
        assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
    }
    let (kept, echo) = run(Endpoint::polled, true, &stop);
    assert_eq!((kept, echo.goodbyes), (Err("nobody".into()), 1));
    assert!((1..20).contains(&echo.ticks), "{} ticks", echo.ticks);
    stop.ask();
    let (kept, echo) = run(Endpoint::polled, true, &stop);
    assert_eq!((kept, echo.ticks, echo.goodbyes), (Ok(1), 0, 1));
}

/// The rule is the one that a test of the engine would plant: every other datagram is lost, the rest pass.
#[test]
fn a_planted_rule_decides_what_passes() {
    let every_other = |number: u64, _: u64| if number % 2 == 1 { Fate::Drop } else { Fate::Pass };
    let [one, two] = [(); 2].map(|()| Endpoint::polled(([127, 0, 0, 1], 0).into()).expect("a socket on loopback"));
    let addresses = [(); 2].map(|()| Endpoint::polled(([127, 0, 0, 1], 0).into()).expect("a free port").address);
    let stop = Stop::default();
    let (counts, came) = std::thread::scope(|scope| {
        let routes = [Route::new(0).with_rule(every_other), Route::new(0)];
        let ends = [(addresses[0], &one), (addresses[1], &two)];
        let ends = ends.map(|(listen, peer)| relay::End { listen, peer: peer.address });
        let stop = &stop;
        let relay = scope.spawn(move || relay::run(routes, ends, 20.0, stop));
        let (mut batch, mut came) = (ReceivedBatch::default(), Vec::new());
        for sent in 0..200_u8 {
            two.send(addresses[1], &[sent]);
            std::thread::sleep(Duration::from_millis(2));
            one.send(addresses[0], &[sent]);
            let until = Instant::now() + Duration::from_millis(1);
            two.drain(&mut batch, until, |_, datagram| came.extend_from_slice(datagram)).expect("a socket that works");
            if came.len() >= 50 {
                break;
            }
        }
        stop.ask();
        (relay.join().expect("the relay ends"), came)
    });
    let [there, back] = counts.expect("two sockets on loopback").ways;
    assert!(came.len() >= 50 && came.windows(2).all(|two| two[1] == two[0] + 2), "{came:?}");
    assert_eq!((there.lost, back.lost), (there.taken / 2, 0), "{there:?} {back:?}");
}

/// Only the two stated ends are served: what comes from elsewhere reaches nobody, and nobody is taken for an end by it.
#[test]
fn a_relay_has_fixed_ends() {
    let open = || Endpoint::polled(([127, 0, 0, 1], 0).into()).expect("a socket on loopback");
    let [one, two, stranger] = [open(), open(), open()];
    let listen = [open().address, open().address];
    let stop = Stop::default();
    let (report, came) = std::thread::scope(|scope| {
        let ends = [(listen[0], one.address), (listen[1], two.address)];
        let ends = ends.map(|(listen, peer)| relay::End { listen, peer });
        let stop = &stop;
        let relay = scope.spawn(move || relay::run([Route::new(0), Route::new(0)], ends, 20.0, stop));
        let (mut batch, mut came) = (ReceivedBatch::default(), [0; 3]);
        let end = Instant::now() + Duration::from_secs(10);
        while came[..2].iter().any(|count| *count < 20) && Instant::now() < end {
            one.send(listen[0], b"peer 1");
            two.send(listen[1], b"peer 2");
            // Last before the peers are answered: whoever follows the newest sender would answer here.
            for listen in listen {
                stranger.send(listen, b"junk");
            }
            std::thread::sleep(Duration::from_millis(2));
            for ((socket, from), came) in
                [(&one, b"peer 2"), (&two, b"peer 1"), (&stranger, b"nobody")].into_iter().zip(&mut came)
            {
                let until = Instant::now() + Duration::from_millis(1);
                socket
                    .drain(&mut batch, until, |_, datagram| {
                        assert_eq!(datagram, from, "only what the other end sent");
                        *came += 1;
                    })
                    .expect("a socket that works");
            }
        }
        stop.ask();
        (relay.join().expect("the relay ends").expect("two sockets on loopback"), came)
    });
    assert!(came[0] >= 20 && came[1] >= 20 && came[2] == 0, "{came:?}");
    assert!(report.strangers >= 20, "{report:?}");
}
