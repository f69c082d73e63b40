//! A server of a static world over UDP: one thread, one socket, no queue of its own.
//!
//! **Turnaround** is measured in two ways. `answer`: from the datagram in hand to its last answer handed to the system.
//! `turnaround`: the same, and how long it may have waited in the socket's queue at the most. A queue is first in, first out,
//! so a datagram came after the queue was last known to be empty; where it is known when its client sent it ([`crate::trials::crowd`]), that
//! is taken instead.
//! Real-time priority is asked for and reported; the thread is not pinned (`taskset` does that).

use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::histogram::{Histogram, Quantiles};
use super::pace::realtime;
use crate::shared::visit::PACKET_US;
use crate::shared::visit::host::{Counts, Host};

/// A socket that takes longer than this had nothing, and the datagram came right then, ns.
const WAITED_NS: u64 = 20_000;
/// What a socket may say without being broken.
const PASSING: [ErrorKind; 4] =
    [ErrorKind::WouldBlock, ErrorKind::TimedOut, ErrorKind::ConnectionRefused, ErrorKind::Interrupted];

/// What a server saw and did.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Time served, s.
    pub served_s: f64,
    /// Checksum of the world.
    pub world: String,
    /// Most clients with a session at once.
    pub clients: usize,
    /// Datagrams and what they were.
    pub counts: Counts,
    /// From a datagram taken to its last answer sent.
    pub answer: Quantiles,
    /// From a datagram in the socket's queue, at the earliest it can have come, to its last answer sent.
    pub turnaround: Quantiles,
    /// Answers that the system did not take.
    pub unsent: u64,
    /// Share of one core that the thread used; `None` where the system does not tell.
    pub cpu_share: Option<f64>,
    /// The thread ran at a real-time priority.
    pub realtime_priority: bool,
}

/// Time that this thread has computed so far, s.
pub(crate) fn computed_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(1e-9 * text.split_whitespace().next()?.parse::<f64>().ok()?)
}

/// Opens the socket that a server listens on.
///
/// # Errors
/// It cannot be opened, in one line.
pub fn listen(address: SocketAddr) -> Result<UdpSocket, String> {
    let failed = |cause| format!("cannot listen on {address}: {cause}");
    let socket = UdpSocket::bind(address).map_err(failed)?;
    // Only how long an idle server sleeps: it wakes with the first datagram.
    socket.set_read_timeout(Some(Duration::from_millis(2))).map_err(failed)?;
    Ok(socket)
}

/// Serves until `stop` says so; it is asked once a packet period with the time served since `start`, s. Times before
/// `warm_up_s` are not in the quantiles. `sent_ns` is asked with a line for when its client last sent, ns since `start`, if
/// that is known.
///
/// # Errors
/// The socket fails, in one line.
pub fn run(
    socket: &UdpSocket,
    host: &mut Host<SocketAddr>,
    start: Instant,
    warm_up_s: f64,
    sent_ns: impl Fn(u32) -> Option<u64>,
    mut stop: impl FnMut(f64) -> bool,
) -> Result<Report, String> {
    let failed = |cause: std::io::Error| format!("the socket failed: {cause}");
    let realtime_priority = realtime();
    let since = |start: Instant| start.elapsed().as_nanos() as u64;
    let (mut answer, mut turnaround) = (Histogram::default(), Histogram::default());
    let (mut bytes, mut unsent, mut next_tick_us) = ([0; 2048], 0_u64, 0);
    let (mut computed, mut clients) = (None, 0);
    let mut warm = false;
    // When the queue was last known to be empty, ns.
    let mut empty_ns = 0;
    loop {
        let now_ns = since(start);
        let now_us = now_ns / 1_000;
        if now_us >= next_tick_us {
            next_tick_us = now_us + PACKET_US;
            host.tick(now_us, |to, datagram| unsent += u64::from(socket.send_to(datagram, to).is_err()));
            clients = clients.max(host.clients());
            if !warm && 1e-9 * now_ns as f64 >= warm_up_s {
                warm = true;
                computed = computed_s().map(|computed| (computed, Instant::now()));
            }
            if stop(1e-9 * now_ns as f64) {
                break;
            }
        }
        let asked_ns = since(start);
        let (len, from) = match socket.recv_from(&mut bytes) {
            Ok(taken) => taken,
            // Nothing came, or a client that is gone answers with this, which says nothing about the others.
            Err(error) if PASSING.contains(&error.kind()) => continue,
            Err(error) => return Err(failed(error)),
        };
        let taken_ns = since(start);
        if taken_ns - asked_ns > WAITED_NS {
            empty_ns = taken_ns;
        }
        let line = host.receive(taken_ns / 1_000, from, &mut bytes[..len], |to, datagram| {
            unsent += u64::from(socket.send_to(datagram, to).is_err());
        });
        if warm {
            let done_ns = since(start);
            answer.add(done_ns - taken_ns);
            turnaround.add(done_ns - line.and_then(&sent_ns).unwrap_or(empty_ns).min(taken_ns));
        }
    }
    let cpu_share =
        computed.and_then(|(before, at)| Some((computed_s()? - before) / at.elapsed().as_secs_f64().max(1e-9)));
    Ok(Report {
        served_s: start.elapsed().as_secs_f64(),
        world: format!("{:016x}", host.server().world()),
        clients,
        counts: host.counts(),
        answer: answer.quantiles(),
        turnaround: turnaround.quantiles(),
        unsent,
        cpu_share,
        realtime_priority,
    })
}
