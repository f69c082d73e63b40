//! Post: one peer's sealed links to everybody else in a game of squash, on one socket, and who of them was there.
//!
//! The paper's enhanced UDP: single events (join, leave, hit, miss) go as the link's reliable events, the flow (places, pings,
//! the state of the game) as samples, which are lost if they are lost; a role drops what is old by itself. What a link has no
//! room for is dropped, too: the role says it again.

use haptic_sim::key_file::entropy;
use std::fmt;
use std::net::{SocketAddr, UdpSocket};
use std::time::Instant;

use haptic_protocol::ends::Ends;
use haptic_protocol::key::Key;
use haptic_protocol::link::{Config, Link, Stage};
use haptic_protocol::parameters::{Parameters, Table};
use haptic_protocol::roles::squash::{Court, Message, SERVER};
use haptic_protocol::roles::{Carried, Outbox};
use haptic_protocol::wire::{MAX_DATAGRAM, PeerId};
use serde::Serialize;

use super::socket;

/// Packet period of the links, µs: a link ends after 12 of them in silence.
const PACKET_US: u32 = 50_000;

/// When another was there.
#[derive(Clone, Debug, Serialize)]
pub struct Met {
    /// 0 is the server, 1 … the players.
    pub number: u8,
    /// Where it should listen.
    pub address: SocketAddr,
    /// When it was first heard under the key, s after the start; absent if it never was.
    pub first_heard_s: Option<f64>,
    /// When it was last heard.
    pub last_heard_s: Option<f64>,
    /// Datagrams of it that were refused.
    pub refused: u32,
    /// Why the last of them was.
    pub refusal: Option<String>,
}

impl Met {
    /// Whether it was ever heard under the key.
    pub fn is_met(&self) -> bool {
        self.first_heard_s.is_some()
    }
}

impl fmt::Display for Met {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.number {
            number if number == SERVER.0 => f.write_str("the server")?,
            number => write!(f, "player {number}")?,
        }
        write!(f, " at {} ", self.address)?;
        match (self.first_heard_s, self.last_heard_s, &self.refusal) {
            (Some(first_s), Some(last_s), _) => write!(f, "was heard from {first_s:.2} s to {last_s:.2} s"),
            (_, _, Some(why)) => write!(f, "sent {} datagrams, all refused ({why})", self.refused),
            _ => f.write_str("was silent"),
        }
    }
}

struct Other {
    link: Link,
    met: Met,
}

/// The links to everybody else, on one socket.
pub(super) struct Post {
    socket: UdpSocket,
    /// Where this one listens.
    own: SocketAddr,
    others: Vec<Other>,
    /// Who else sent something, last, and how many datagrams came from such.
    stranger: Option<(SocketAddr, u32)>,
}

impl Post {
    /// Everybody listens at one of `addresses`, in the order of their numbers; this one is `number`.
    pub(super) fn new(key: &Key, number: u8, addresses: &[SocketAddr]) -> Result<Self, String> {
        let socket = socket::open(addresses[usize::from(number)])?;
        let own = socket.local_addr().map_err(|cause| format!("no address of its own: {cause}"))?;
        let mut others = Vec::new();
        for (other, address) in (0..).zip(addresses).filter(|(other, _)| *other != number) {
            let Court { length_m, width_m } = Court::SINGLES;
            let table = Table::new("squash").number("length_m", length_m.into()).number("width_m", width_m.into());
            let mut parameters = Parameters::new();
            parameters.add(table).map_err(|error| format!("{error:?}"))?;
            let link = Link::new(Config {
                key: key.clone(),
                ends: Ends { local: PeerId(number), remote: PeerId(other) },
                packet_period_us: PACKET_US,
                parameters,
                entropy: entropy()?,
            })
            .map_err(|error| error.to_string())?;
            let met = Met {
                number: other,
                address: *address,
                first_heard_s: None,
                last_heard_s: None,
                refused: 0,
                refusal: None,
            };
            others.push(Other { link, met });
        }
        Ok(Self { socket, own, others, stranger: None })
    }

    /// What has come.
    pub(super) fn take(&mut self, now: u64, until: Instant) -> Vec<(PeerId, Message)> {
        let mut came = Vec::new();
        let Self { socket, others, stranger, .. } = self;
        socket::drain(socket, until, |address, datagram| {
            // The address only tells which link to ask; whether it is true, the seal does.
            let Some(Other { link, met }) = others.iter_mut().find(|other| other.met.address == address) else {
                *stranger = Some((address, stranger.map_or(0, |(_, count)| count) + 1));
                return;
            };
            let taken = link.receive(now, datagram);
            met.refused = link.counts().refused;
            match taken {
                Err(why) => met.refusal = Some(why.to_string()),
                Ok(taken) => {
                    if is_up(link) {
                        met.last_heard_s = Some(now as f64 * 1e-6);
                        met.first_heard_s = met.first_heard_s.or(met.last_heard_s);
                    }
                    came.extend(
                        taken.and_then(|taken| Message::read(&taken)).map(|(_, message)| (PeerId(met.number), message)),
                    );
                }
            }
        });
        for Other { link, met } in others {
            while let Some(event) = link.take_event() {
                came.extend(Message::parse(&event).map(|(_, message)| (PeerId(met.number), message)));
            }
        }
        came
    }

    /// Says what a role wants to say, and what the links themselves have to.
    pub(super) fn say<const Q: usize>(&mut self, now: u64, roles: &mut Outbox<Message, Q>) {
        let mut out = [0; MAX_DATAGRAM];
        let Self { socket, others, .. } = self;
        // A datagram that the socket does not take now is one that is lost.
        let send = |address: SocketAddr, bytes: &[u8]| drop(socket.send_to(bytes, address));
        while let Some((to, message)) = roles.take() {
            let Some(Other { link, met }) = others.iter_mut().find(|other| other.met.number == to.0) else { continue };
            if let Ok(message) = message.carry(0)
                && let Some(len) = link.send(now, message, &mut out)
            {
                send(met.address, &out[..len]);
            }
        }
        for Other { link, met } in others {
            while let Some(len) = link.poll(now, &mut out) {
                send(met.address, &out[..len]);
            }
        }
    }

    /// The others, in order.
    pub(super) fn met(&self) -> Vec<Met> {
        self.others.iter().map(|other| other.met.clone()).collect()
    }

    /// Links that are up.
    pub(super) fn links(&self) -> usize {
        self.others.iter().filter(|other| is_up(&other.link)).count()
    }

    /// Datagrams that were refused.
    pub(super) fn refused(&self) -> u32 {
        self.others.iter().map(|other| other.met.refused).sum()
    }

    /// What there is to say of a game in which nobody was met, and what to check.
    pub(super) fn nobody(&self, seconds: f64) -> String {
        let mut heard: Vec<String> = self.others.iter().map(|other| other.met.to_string()).collect();
        if let Some((address, count)) = self.stranger {
            heard.push(format!("{count} datagrams came from elsewhere, the last from {address}"));
        }
        format!(
            "nobody answered within {seconds} s: {}; check that they run now, with the same --addresses in the same order and \
             the same --key-file, and that UDP reaches {}",
            heard.join(", "),
            self.own
        )
    }
}

/// Whether the other end is there and holds the key.
fn is_up(link: &Link) -> bool {
    matches!(link.stage(), Stage::Idle | Stage::Running | Stage::Fading)
}
