//! A bad network between two peers: takes their datagrams, and does with each what a rule says, of the scene's network table, of a
//! trace, or any other. It has no key, so all it can do is what a network can.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use haptic_sim::engine::{Actor, Out};
use haptic_sim::network::link::{Counts, Link, Route};

use super::endpoint::{Endpoint, Live, Stop, Ticker};

/// How often the relay looks: what it adds to the delay at the most.
const PERIOD: Duration = Duration::from_micros(200);

/// The first peer talks to the endpoint that runs this, the second one to another.
struct Relay {
    second: Endpoint,
    peers: [Option<SocketAddr>; 2],
    lines: [Link<[u8]>; 2],
    over_ns: f64,
    end: Option<Result<(), String>>,
}

impl Actor<SocketAddr> for Relay {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, from: SocketAddr, datagram: &mut [u8], _: &mut Out<'_, SocketAddr, [u8]>) {
        self.peers[0] = Some(from);
        self.lines[0].send(now_ns, datagram);
    }

    fn act(&mut self, now_ns: u64, first: &mut Out<'_, SocketAddr, [u8]>) {
        let Self { second, peers, lines: [there, back], .. } = self;
        let heard = second.drain(Instant::now() + PERIOD / 2, |from, datagram| {
            peers[1] = Some(from);
            back.send(now_ns, datagram);
        });
        // Kept until the peer it is for has spoken; sent from the socket that this one talks to.
        let [one, two] = *peers;
        while let Some((to, (_, datagram))) = one.and_then(|to| Some((to, back.take(now_ns)?))) {
            first(to, &datagram);
        }
        while let Some((to, (_, datagram))) = two.and_then(|to| Some((to, there.take(now_ns)?))) {
            second.send(to, &datagram);
        }
        self.end = (heard.is_err() || now_ns as f64 >= self.over_ns).then_some(heard);
    }
}

impl Live for Relay {
    fn end(&self) -> Option<Result<(), String>> {
        self.end.clone()
    }
}

/// Relays over `routes` between a peer that talks to `listen[0]` and one that talks to `listen[1]` for `duration_s`, or until it is
/// stopped.
pub fn run(routes: [Route; 2], listen: [SocketAddr; 2], duration_s: f64, stop: &Stop) -> Result<[Counts; 2], String> {
    let (first, second) = (Endpoint::polled(listen[0])?, Endpoint::polled(listen[1])?);
    let (lines, over_ns) = (routes.map(Link::new), 1e9 * duration_s);
    let mut relay = Relay { second, peers: [None; 2], lines, over_ns, end: None };
    first.run(Ticker::new(PERIOD), f64::MAX, stop, &mut relay)?;
    Ok(relay.lines.map(|line| line.counts()))
}
