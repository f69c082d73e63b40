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
///
/// # Errors
/// A socket that cannot be opened, in one line.
pub(crate) fn run(
    routes: [Route; 2],
    listen: [SocketAddr; 2],
    duration_s: f64,
    stop: &Stop,
) -> Result<[Counts; 2], String> {
    let (first, second) = (Endpoint::polled(listen[0])?, Endpoint::polled(listen[1])?);
    let (peers, lines) = ([None; 2], routes.map(Link::new));
    let mut relay = Relay { second, peers, lines, over_ns: 1e9 * duration_s, end: None };
    first.run(Ticker::new(PERIOD), f64::MAX, stop, &mut relay)?;
    Ok(relay.lines.map(|line| line.counts()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_sim::network::rule::Fate;

    /// The rule is the one that a test of the engine would plant: every other datagram is lost, the rest pass.
    #[test]
    fn a_planted_rule_decides_what_passes() {
        let every_other = |number: u64, _: u64| if number % 2 == 1 { Fate::Drop } else { Fate::Pass };
        let [one, two] = [(); 2].map(|()| Endpoint::polled(([127, 0, 0, 1], 0).into()).expect("a socket on loopback"));
        let addresses = [(); 2].map(|()| Endpoint::polled(([127, 0, 0, 1], 0).into()).expect("a free port").address());
        let stop = Stop::default();
        let (counts, came) = std::thread::scope(|scope| {
            let routes = [Route::new(0).with_rule(every_other), Route::new(0)];
            let relay = scope.spawn(|| run(routes, addresses, 20.0, &stop));
            let mut came = Vec::new();
            // The second peer has to speak first: the relay knows it from that.
            for sent in 0..200_u8 {
                two.send(addresses[1], &[sent]);
                std::thread::sleep(Duration::from_millis(2));
                one.send(addresses[0], &[sent]);
                let until = Instant::now() + Duration::from_millis(1);
                two.drain(until, |_, datagram| came.extend_from_slice(datagram)).expect("a socket that works");
                if came.len() >= 50 {
                    break;
                }
            }
            stop.ask();
            (relay.join().expect("the relay ends"), came)
        });
        let [there, back] = counts.expect("two sockets on loopback");
        assert!(came.len() >= 50 && came.windows(2).all(|two| two[1] == two[0] + 2), "{came:?}");
        assert_eq!((there.lost, back.lost), (there.taken / 2, 0), "{there:?} {back:?}");
    }
}
