//! A network between two machines, measured packet by packet: a prober that sends, a listener that answers, and a trace of what became of each.
//!
//! A probe is as long as a sealed packet of a scene (88 bytes) and carries its number and when it left; the answer, as long, carries that back, when the probe came,
//! when the answer left, and how many probes have come so far. Each end has only its own monotonic clock:
//!
//! - **One way, each way.** A delay by two clocks that do not agree is off by a constant. It is therefore taken less the least of its direction, as irtt's are.
//!   Clocks that run unlike make one direction longer and the other shorter. [`Clocks`] finds this and takes it out. What is constant is half of the quickest round trip.
//! - **Lost where.** The count tells how many of the probes between two answers came. All or none of them: then it is known of each. Else the first of them are
//!   booked as lost on the way back.
//!
//! **Bounds**: at most [`MOST_PER_S`] probes a second, and [`MOST_S`] s; a listener answers no more than that, nothing that is no probe, and never with more bytes than
//! came, so that nobody is served by it to flood another. It has no key: who can reach it can measure, for as long as it runs.

use std::net::{SocketAddr, UdpSocket};
use std::thread;
use std::time::{Duration, Instant};

use cohold_sim::network::clocks::{Clocks, Trip};
use cohold_sim::network::rule::{Arrival, NetworkTrace};
use serde::Serialize;

use super::Error;
use super::addresses::any_towards;
use super::endpoint::Stop;

/// Most probes a second, and longest measurement, s.
pub const MOST_PER_S: f64 = 1000.0;
/// Longest measurement, s.
pub const MOST_S: f64 = 3600.0;

/// Bytes of a probe and of its answer.
const LEN: usize = 88;
const MAGIC: [u8; 8] = *b"hapticm1";
/// How long the last answers are waited for.
const LAST: Duration = Duration::from_secs(1);
/// How often it is asked whether to stop.
const LOOK: Duration = Duration::from_millis(50);

/// Numbers of a probe and its answer, in their order on the wire, ns since the clock of whoever says it began.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Stamps {
    number: u64,
    left_ns: u64,
    /// Probes that had come by then; 0 in a probe.
    count: u64,
    came_ns: u64,
    answered_ns: u64,
}

impl Stamps {
    fn bytes(self) -> [u8; LEN] {
        let mut bytes = [0; LEN];
        let numbers = [self.number, self.left_ns, self.count, self.came_ns, self.answered_ns].map(u64::to_le_bytes);
        let whole = MAGIC.into_iter().chain(numbers.into_iter().flatten());
        bytes.iter_mut().zip(whole).for_each(|(to, from)| *to = from);
        bytes
    }

    fn read(bytes: &[u8]) -> Option<Self> {
        let rest = bytes.strip_prefix(&MAGIC).filter(|_| bytes.len() == LEN)?;
        let mut numbers = rest.chunks_exact(8).filter_map(|chunk| Some(u64::from_le_bytes(chunk.try_into().ok()?)));
        let mut next = || numbers.next();
        Some(Self { number: next()?, left_ns: next()?, count: next()?, came_ns: next()?, answered_ns: next()? })
    }
}

fn bound(listen: SocketAddr) -> Result<UdpSocket, Error> {
    let failed = cohold_sim::Error::cannot("listen on", &listen);
    let socket = UdpSocket::bind(listen).map_err(&failed)?;
    socket.set_read_timeout(Some(LOOK)).map_err(&failed)?;
    Ok(socket)
}

/// What a listener did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Listened {
    /// Probes that came and were answered.
    pub answered: u64,
    /// Datagrams that were none, or too many.
    pub ignored: u64,
}

/// Answers probes for so long, or until it is stopped; `ready` gets the address.
///
/// # Errors
/// The address cannot be listened on.
pub fn listen(
    address: SocketAddr,
    duration_s: f64,
    stop: &Stop,
    ready: impl FnOnce(SocketAddr),
) -> Result<Listened, Error> {
    let socket = bound(address)?;
    ready(socket.local_addr().map_err(cohold_sim::Error::cannot("listen on", &address))?);
    let (start, mut buffer) = (Instant::now(), [0; LEN + 1]);
    let now_ns = || start.elapsed().as_nanos() as u64;
    let mut listened = Listened::default();
    // Whose probes they are, how many came, and in which second how many were answered.
    let (mut whose, mut count, mut second, mut in_second) = (None, 0, 0, 0);
    while start.elapsed().as_secs_f64() < duration_s.min(MOST_S) && !stop.is_asked() {
        let Ok((length, from)) = socket.recv_from(&mut buffer) else { continue };
        let came_ns = now_ns();
        if came_ns / 1_000_000_000 != second {
            (second, in_second) = (came_ns / 1_000_000_000, 0);
        }
        in_second += 1;
        let probe = Stamps::read(&buffer[..length]).filter(|_| f64::from(in_second) <= 1.1 * MOST_PER_S);
        let Some(probe) = probe else {
            listened.ignored += 1;
            continue;
        };
        if whose.replace(from) != Some(from) || probe.number == 0 {
            count = 0;
        }
        count += 1;
        listened.answered += 1;
        let answer = Stamps { count, came_ns, answered_ns: now_ns(), ..probe };
        // What cannot be sent is lost, as anywhere on its way.
        let _ = socket.send_to(&answer.bytes(), from);
    }
    Ok(listened)
}

/// What a measurement found.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// Probes that were sent, and those whose answer came.
    pub sent: u64,
    /// Answers that came.
    pub answered: u64,
    /// Lost on the way there, and back.
    pub lost: [u64; 2],
    /// Half of the quickest round trip, ms: what is constant, and in no trace.
    pub constant_ms: f64,
    /// Largest delay beyond that, there and back, ms.
    pub most_ms: [f64; 2],
    /// By how much the other clock is faster, which was taken out, ppm.
    pub drift_ppm: f64,
    /// What became of each probe.
    #[serde(skip)]
    pub trace: NetworkTrace,
}

/// An answer, and when it came.
type Came = (Stamps, u64);

/// Sends a probe every so often for so long, or until it is stopped; from this address, or from any.
///
/// # Errors
/// More or longer than the bounds allow, no socket, or not one answer.
pub fn probe(
    to: SocketAddr,
    from: Option<SocketAddr>,
    every_s: f64,
    duration_s: f64,
    stop: &Stop,
) -> Result<Measured, Error> {
    cohold_sim::refuse_if!(
        1.0 / every_s > MOST_PER_S * (1.0 + 1e-9) || duration_s > MOST_S,
        "at most {MOST_PER_S} probes a second for {MOST_S} s are allowed"
    );
    let socket = bound(from.unwrap_or_else(|| any_towards(to)))?;
    socket.connect(to).map_err(cohold_sim::Error::cannot("reach", &to))?;
    let start = Instant::now();
    let now_ns = || start.elapsed().as_nanos() as u64;
    let over = Stop::default();
    let (sent, answers) = thread::scope(|scope| {
        let hearing = scope.spawn(|| {
            let (mut answers, mut buffer) = (Vec::new(), [0; LEN + 1]);
            while !over.is_asked() {
                let Ok(length) = socket.recv(&mut buffer) else { continue };
                answers.extend(Stamps::read(&buffer[..length]).map(|answer| (answer, now_ns())));
            }
            answers
        });
        let mut number = 0;
        while (number as f64) * every_s < duration_s && !stop.is_asked() {
            let due = Duration::from_secs_f64(number as f64 * every_s);
            thread::sleep(due.saturating_sub(start.elapsed()));
            // A probe that cannot be sent is lost there.
            let _ = socket.send(&Stamps { number, left_ns: now_ns(), ..Stamps::default() }.bytes());
            number += 1;
        }
        let last = Instant::now();
        while last.elapsed() < LAST && !stop.is_asked() {
            thread::sleep(LOOK);
        }
        over.ask();
        (number, hearing.join().unwrap_or_default())
    });
    measured(sent, &answers)
        .ok_or_else(|| format!("no answer came from {to}: does `network measure --listen` run there?").into())
}

/// What these answers to so many probes say; none where there are none.
fn measured(sent: u64, answers: &[Came]) -> Option<Measured> {
    let mut by_number: Vec<Option<Came>> = vec![None; sent as usize];
    for came in answers {
        if let Some(place) = usize::try_from(came.0.number).ok().and_then(|number| by_number.get_mut(number)) {
            place.get_or_insert(*came);
        }
    }
    let between = |from_ns: u64, to_ns: u64| to_ns.wrapping_sub(from_ns).cast_signed();
    let trip = |(stamps, back_ns): &Came| Trip {
        at_ns: stamps.left_ns.cast_signed(),
        there_ns: between(stamps.left_ns, stamps.came_ns),
        back_ns: between(stamps.answered_ns, *back_ns),
    };
    let trips: Vec<Trip> = by_number.iter().flatten().map(trip).collect();
    let clocks = Clocks::of(&trips)?;
    let mut delays = clocks.delays_ns.iter();
    let mut found = Measured {
        sent,
        answered: trips.len() as u64,
        lost: [0; 2],
        constant_ms: 0.5e-6 * clocks.quickest_ns as f64,
        most_ms: [0.0; 2],
        drift_ppm: clocks.drift_ppm,
        trace: NetworkTrace::default(),
    };
    let mut packets = [Vec::new(), Vec::new()];
    // The number of those that had come by the last answer, and the probes since that have none.
    let (mut counted, mut missing) = (0, 0_u64);
    let mut last = [Arrival { delay_ns: 0, corrupt: false }; 2];
    let mut missed = |missing: &mut u64, came: u64, packets: &mut [Vec<Vec<Arrival>>; 2], last: [Arrival; 2]| {
        for at in 0..*missing {
            let way = usize::from(at < came);
            found.lost[way] += 1;
            packets[way].push(Vec::new());
            packets[1 - way].push(vec![last[1 - way]]);
        }
        *missing = 0;
    };
    let mut most_ms = [0.0_f64; 2];
    for came in &by_number {
        let Some(came) = came else {
            missing += 1;
            continue;
        };
        // One that overtook is no less than the one before.
        let between = came.0.count.saturating_sub(counted + 1).min(missing);
        counted = counted.max(came.0.count);
        missed(&mut missing, between, &mut packets, last);
        for (way, delay_ns) in delays.next().copied().unwrap_or_default().into_iter().enumerate() {
            most_ms[way] = most_ms[way].max(1e-6 * delay_ns as f64);
            last[way] = Arrival { delay_ns, corrupt: false };
            packets[way].push(vec![last[way]]);
        }
    }
    // Of those after the last answer nothing is known: there.
    missed(&mut missing, 0, &mut packets, last);
    Some(Measured { most_ms, trace: NetworkTrace::of_packets(packets), ..found })
}

#[cfg(test)]
#[path = "../tests/inside/measuring.rs"]
mod tests;
