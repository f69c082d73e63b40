//! A load: very many clients on one socket, each of which says something once in a packet period.
//!
//! Their packets are spread evenly over the period. All that are due go in one system call, and what came is taken in as few
//! ([`cohold_live::batch`]). A load that is late by more than a quarter of a packet period does not catch up in a burst that no
//! independent clients would make; it goes on from there.

use std::net::SocketAddr;
use std::time::Duration;

use cohold_live::batch::{MOST, OutgoingBatch, ReceivedBatch};
use cohold_live::endpoint::{Endpoint, Stop, realtime};
use cohold_live::quantiles::{Quantiles, Times};

use crate::Error;
use crate::live::serve::Computed;
use crate::world::PACKET_US;

/// How long the load rests, and how often, ns.
const REST: Duration = Duration::from_micros(20);
const REST_EVERY_NS: u64 = 250_000;
/// A load that is later than this does not catch up, ns.
const LATE_NS: u64 = 250 * PACKET_US;

/// Most batches that are taken between two that are sent: more comes than goes, and a load that falls behind must catch up.
const TAKES: usize = 4;

/// Who makes a load.
pub(super) trait Clients {
    /// What the client with this index says in this packet period. `measured`: the warm-up is over.
    fn exchange(&mut self, at: usize, now_ns: u64, measured: bool, say: &mut dyn FnMut(&[u8]));

    /// Takes what came, for whichever of them, and answers.
    fn receive(&mut self, now_ns: u64, measured: bool, datagram: &mut [u8], say: &mut dyn FnMut(&[u8]));
}

/// How long a load is, and from when on it is measured, s.
#[derive(Clone, Copy)]
pub struct Span {
    /// Time before the measurement, s.
    pub warm_up_s: f64,
    /// Length of the measurement, s.
    pub seconds: f64,
}

/// How a load was kept up.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Kept {
    pub(super) measured_s: f64,
    /// How late it was with its packets.
    pub(super) late: Quantiles,
    pub(super) cpu_share: Option<f64>,
    pub(super) realtime_priority: bool,
}

/// Lets `count` clients exchange datagrams with `server`, until the time is over or it is stopped.
pub(super) fn run(
    endpoint: &Endpoint,
    server: SocketAddr,
    count: u64,
    Span { warm_up_s, seconds }: Span,
    stop: &Stop,
    clients: &mut impl Clients,
) -> Result<Kept, Error> {
    let mut kept = Kept { realtime_priority: realtime(), ..Kept::default() };
    let (period_ns, warm_ns, end_ns) =
        (1_000 * PACKET_US, (1e9 * warm_up_s) as u64, (1e9 * (warm_up_s + seconds)) as u64);
    let (mut came, mut going, mut late) = (ReceivedBatch::default(), OutgoingBatch::default(), Times::default());
    let (mut next, mut slipped_ns, mut rested_ns) = (0_u64, endpoint.now_ns(), 0);
    let mut measured: Option<(Computed, u64)> = None;
    loop {
        let mut now_ns = endpoint.now_ns();
        if now_ns >= end_ns || stop.is_asked() {
            break;
        }
        if measured.is_none() && now_ns >= warm_ns {
            measured = Some((Computed::now(), now_ns));
        }
        // Packet number `next` of all: the clients in turn, evenly over each packet period.
        let due_ns = |next: u64, slipped_ns| slipped_ns + next / count * period_ns + next % count * period_ns / count;
        for _ in 0..MOST {
            if due_ns(next, slipped_ns) > now_ns {
                break;
            }
            let late_ns = now_ns - due_ns(next, slipped_ns);
            slipped_ns += if late_ns > LATE_NS { late_ns } else { 0 };
            if measured.is_some() {
                late.add(late_ns);
            }
            clients.exchange((next % count) as usize, now_ns, measured.is_some(), &mut |bytes| {
                endpoint.say(&mut going, server, bytes);
            });
            next += 1;
            now_ns = endpoint.now_ns();
        }
        endpoint.flush(&mut going);
        take(endpoint, server, measured.is_some(), &mut came, &mut going, clients)?;
        now_ns = endpoint.now_ns();
        let left_ns = due_ns(next, slipped_ns).saturating_sub(now_ns);
        if came.each().len() == 0 && left_ns > 200_000 {
            std::thread::sleep(Duration::from_nanos(left_ns - 100_000));
        } else if now_ns > rested_ns + REST_EVERY_NS {
            // A thread of real-time priority that never rests is stopped by the system, and for longer.
            std::thread::sleep(REST);
            rested_ns = endpoint.now_ns();
        }
    }
    if let Some((computed, since_ns)) = &measured {
        kept.measured_s = 1e-9 * (endpoint.now_ns() - since_ns) as f64;
        kept.cpu_share = computed.share();
    }
    // What is under way still counts.
    let until_ns = endpoint.now_ns() + 100_000_000;
    while endpoint.now_ns() < until_ns {
        take(endpoint, server, measured.is_some(), &mut came, &mut going, clients)?;
        std::thread::sleep(REST);
    }
    Ok(Kept { late: late.quantiles(), ..kept })
}

/// Takes what has come, up to [`TAKES`] batches.
fn take(
    endpoint: &Endpoint,
    server: SocketAddr,
    measured: bool,
    came: &mut ReceivedBatch,
    going: &mut OutgoingBatch,
    clients: &mut impl Clients,
) -> Result<(), Error> {
    for _ in 0..TAKES {
        endpoint.take(came)?;
        for (_, datagram) in came.each() {
            clients.receive(endpoint.now_ns(), measured, datagram, &mut |bytes| endpoint.say(going, server, bytes));
        }
        endpoint.flush(going);
        if came.each().len() < MOST {
            break;
        }
    }
    Ok(())
}
