//! A bad network between two peers: takes their datagrams, and does with each what a rule says, of the scene's network table, of a
//! trace, or any other. It has no key, so all it can do is what a network can.
//!
//! **Fixed ends**: it passes on what comes from one of the two stated addresses, to the other, and from nowhere else to nobody.
//! What is on its way is at most 1 MiB each way; what comes on top is lost, as on any full line.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use cohold_sim::engine::{Actor, Out};
use cohold_sim::network::link::{Counts, Link, Route};
use serde::Serialize;

use super::batch::ReceivedBatch;
use super::endpoint::{Endpoint, Live, Stop, Ticker};
use crate::Error;

/// How often the relay looks: what it adds to the delay at the most.
const PERIOD: Duration = Duration::from_micros(200);
/// Most that is on its way in one direction, bytes with what each datagram takes beside its own: two peers that send 72 bytes
/// every 8 ms have that much on a line of a minute.
const MOST_BYTES: usize = 1 << 20;

/// One end of what is relayed.
#[derive(Clone, Copy, Debug)]
pub struct End {
    /// Where the peer sends to.
    pub listen: SocketAddr,
    /// The peer, and nobody else.
    pub peer: SocketAddr,
}

/// The packets that were relayed, and what became of them.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Packets from peer 1 to 2, and from 2 to 1.
    pub ways: [Counts; 2],
    /// Datagrams from anywhere else, which went nowhere.
    pub strangers: u64,
}

/// The first peer talks to the endpoint that runs this, the second one to another.
struct Relay {
    second: Endpoint,
    came: ReceivedBatch,
    peers: [SocketAddr; 2],
    lines: [Link<[u8]>; 2],
    strangers: u64,
    end: Option<Result<(), Error>>,
}

impl Actor<SocketAddr> for Relay {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, from: SocketAddr, datagram: &mut [u8], _: &mut Out<'_, SocketAddr, [u8]>) {
        if from == self.peers[0] {
            self.lines[0].send(now_ns, datagram);
        } else {
            self.strangers += 1;
        }
    }

    fn act(&mut self, now_ns: u64, first: &mut Out<'_, SocketAddr, [u8]>) {
        let Self { second, came, peers: [one, two], lines: [there, back], strangers, .. } = self;
        let heard = second.drain(came, Instant::now() + PERIOD / 2, |from, datagram| {
            if from == *two {
                back.send(now_ns, datagram);
            } else {
                *strangers += 1;
            }
        });
        // Each is sent from the socket that its receiver talks to.
        while let Some((_, datagram)) = back.take(now_ns) {
            first(*one, &datagram);
        }
        while let Some((_, datagram)) = there.take(now_ns) {
            second.send(*two, &datagram);
        }
        self.end = heard.is_err().then_some(heard);
    }
}

impl Live for Relay {
    fn end(&mut self) -> Option<Result<(), Error>> {
        self.end.take()
    }
}

/// Relays over `routes` between two peers for `duration_s`, or until it is stopped.
///
/// # Errors
/// A socket failed.
pub fn run(routes: [Route; 2], ends: [End; 2], duration_s: f64, stop: &Stop) -> Result<Report, Error> {
    let [first, second] = ends.map(|end| Endpoint::polled(end.listen));
    let (first, second, peers) = (first?, second?, ends.map(|end| end.peer));
    first.reaches(peers[0]).and_then(|()| second.reaches(peers[1]))?;
    let lines = routes.map(|route| Link::new(route).holding(MOST_BYTES));
    let mut relay = Relay { second, came: ReceivedBatch::default(), peers, lines, strangers: 0, end: None };
    first.run(Ticker::realtime(PERIOD).lasting(duration_s), f64::MAX, stop, &mut relay)?;
    Ok(Report { ways: relay.lines.map(|line| line.counts()), strangers: relay.strangers })
}
