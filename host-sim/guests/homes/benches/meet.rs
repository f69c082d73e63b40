//! What one core of a meeting place carries, beside a bare forwarder in the same run, and what 1,000 relayed sessions would take.
//!
//! Both run on one endpoint in a thread of their own; a second thread loads them with sealed-looking datagrams of 88 bytes from both ends of 256
//! sessions, as quickly as it can, on loopback, each host of 127.0.0.0/8 with 8 of them. What counts is the processor time of the server's thread for each datagram that it passed on, its
//! system calls included. The bare forwarder knows for each address where to send, and does nothing else. They take turns, and the median of the turns is printed.
//! Both ask for a real-time priority: who has one is woken sooner and finds fewer in a batch, so that one with and one without cannot be compared. Loaded like this both are
//! busy and find full batches: a server with less to do takes up to 8.5 µs for a datagram, one at a time.
//! **Memory**: what the process has more of in memory with 1,000 sessions seated than before.
//! **Limit**: loopback has no network card; receivers do not empty their sockets.

use std::collections::HashMap;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use cohold_homes::frame::Welcome;
use cohold_homes::meet::Meet;
use cohold_homes::place::Place;
use cohold_homes::seat::Seat;
use cohold_live::Error;
use cohold_live::endpoint::{Endpoint, Live, Stop, Ticker};
use cohold_protocol::key::Key;
use cohold_protocol::wire::VERSION;
use cohold_sim::engine::{Actor, Out};
use rustix::time::{ClockId, clock_gettime};

const SESSIONS: usize = 256;
/// Sessions whose memory is looked at.
const ALL_SESSIONS: usize = 1000;
/// Ends of one host.
const OF_HOST: usize = 8;
const TURNS: usize = 7;
const TURN: Duration = Duration::from_secs(1);
const LENGTH: usize = 88;

/// Sends on from each address to another.
struct Forwarder {
    to: HashMap<SocketAddr, SocketAddr>,
    passed: u64,
}

impl Actor<SocketAddr> for Forwarder {
    type Packet = [u8];

    fn hear(&mut self, _: u64, from: SocketAddr, datagram: &mut [u8], out: &mut Out<'_, SocketAddr, [u8]>) {
        if let Some(to) = self.to.get(&from) {
            self.passed += 1;
            out(*to, datagram);
        }
    }

    fn act(&mut self, _: u64, _: &mut Out<'_, SocketAddr, [u8]>) {}
}

impl Live for Forwarder {}

fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Both ends of each session, at addresses of loopback.
fn ends() -> Vec<UdpSocket> {
    let address = |end: usize| SocketAddr::from(([127, 7, (end / OF_HOST) as u8, 1], 0));
    (0..2 * SESSIONS).map(|end| UdpSocket::bind(address(end)).expect("a socket on loopback")).collect()
}

/// Every end takes its seat.
fn join(ends: &[UdpSocket], place: SocketAddr) {
    for (at, end) in ends.iter().enumerate() {
        let (key, entropy) = (Key::new([(at / 2) as u8 + 1; 32]), Key::new([at as u8; 32]));
        let mut seat = Seat::new(&key, (at % 2) as u8, &entropy);
        end.set_read_timeout(Some(Duration::from_millis(200))).expect("a timeout");
        while !seat.is_seated(Instant::now()) {
            if let Some(join) = seat.poll(Instant::now(), true) {
                end.send_to(&join, place).expect("it is sent");
            }
            let mut welcome = [0; Welcome::LEN];
            if end.recv_from(&mut welcome).is_ok() {
                seat.hear(Instant::now(), &welcome);
            }
        }
    }
}

/// Bytes of this process that are in memory; none where the system does not tell.
fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix(" kB")?.parse().ok().map(|kilobytes: u64| 1024 * kilobytes)
}

/// A meeting place at which both ends of so many sessions are seated.
fn seated(sessions: usize) -> Place {
    let now = Instant::now();
    let mut place = Place::new(&Key::new([9; 32]), now);
    for at in 0..2 * sessions {
        let [.., high, low] = (at / OF_HOST).to_be_bytes();
        let from = SocketAddr::from(([127, 8, high, low], (at % OF_HOST) as u16 + 1));
        let mut key = [1; 32];
        key[..8].copy_from_slice(&(at / 2).to_le_bytes());
        let mut seat = Seat::new(&Key::new(key), (at % 2) as u8, &Key::new([at as u8; 32]));
        // The first welcome brings the cookie, the second the seat.
        while !seat.is_seated(now) {
            let join = seat.poll(now, true).expect("it joins");
            place.hear(now, from, &join, &mut |_, welcome| _ = seat.hear(now, welcome));
        }
    }
    place
}

/// Loads what listens there for a turn; `serve` runs it and says how many datagrams it passed on. Processor time of each, ns.
fn turn(ends: &[UdpSocket], place: SocketAddr, joins: bool, serve: impl FnOnce() -> u64 + Send) -> f64 {
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            if joins {
                join(ends, place);
            }
            let mut flow = [0x5A; LENGTH];
            flow[0] = VERSION;
            while !over.load(Ordering::Relaxed) {
                // No quicker than a seat may send: so many system calls take more than half a millisecond.
                for end in ends {
                    let _ = end.send_to(&flow, place);
                }
            }
        });
        let served = scope.spawn(|| {
            let before = processor_s();
            let passed = serve();
            1e9 * (processor_s() - before) / passed.max(1) as f64
        });
        let cost = served.join().expect("it ends");
        over.store(true, Ordering::Relaxed);
        cost
    })
}

fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    of[of.len() / 2]
}

fn main() -> Result<(), Error> {
    let loopback = SocketAddr::from(([127, 0, 0, 1], 0));
    let before = resident_bytes();
    let place = seated(ALL_SESSIONS);
    assert_eq!(place.rooms(), ALL_SESSIONS);
    let grown = before.zip(resident_bytes()).map(|(before, after)| after.saturating_sub(before));
    drop(place);
    let (mut meets, mut bare) = (Vec::new(), Vec::new());
    for _ in 0..TURNS {
        let ends = ends();
        let meet = Meet::open(loopback)?;
        let serve = || meet.run(TURN.as_secs_f64(), &Stop::default()).expect("it serves").counts.passed;
        meets.push(turn(&ends, meet.address(), true, serve));
        let addresses: Vec<_> = ends.iter().map(|end| end.local_addr().expect("its address")).collect();
        let to = addresses.chunks_exact(2).flat_map(|pair| [(pair[0], pair[1]), (pair[1], pair[0])]).collect();
        let endpoint = Endpoint::answering(loopback)?;
        let serve = || {
            let mut forwarder = Forwarder { to, passed: 0 };
            let ticker = Ticker::realtime(Duration::from_millis(100)).lasting(TURN.as_secs_f64());
            endpoint.run(ticker, f64::MAX, &Stop::default(), &mut forwarder).expect("it forwards");
            forwarder.passed
        };
        bare.push(turn(&ends, endpoint.address, false, serve));
    }
    let (meet, bare) = (median(meets), median(bare));
    println!(
        "processor time for a datagram: meeting place {meet:.0} ns, bare forwarder {bare:.0} ns, {:.2} times",
        meet / bare
    );
    println!("one core passes on {:.0} datagrams/s", 1e9 / meet);
    // Both ends of each send 1,000 a second.
    println!(
        "1,000 sessions, 1,000 datagrams/s each way: {:.1} cores (bare {:.1})",
        2e6 * meet * 1e-9,
        2e6 * bare * 1e-9
    );
    if let Some(grown) = grown {
        println!("1,000 sessions: {:.0} kB in memory", grown as f64 / 1024.0);
    }
    Ok(())
}
