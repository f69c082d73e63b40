//! One peer's sealed links to everybody else in a game of squash, and who of them was there.
//!
//! The paper's enhanced UDP: single events (join, leave, hit, miss) go as the link's reliable events, the flow (places, pings,
//! the state of the game) as samples, which are lost if they are lost; a role drops what is old by itself. What a link has no
//! room for is dropped, too: the role says it again.

use std::{fmt, net::SocketAddr};

use cohold_live::key_file::entropy;
use cohold_protocol::link::{Config, Link};
use cohold_protocol::parameters::{Parameters, Table};
use cohold_protocol::wire::{self, Goodbye, PeerId};
use cohold_protocol::{ends::Ends, key::Key};
use cohold_sim::engine::Out;
use serde::Serialize;

use crate::Error;
use crate::roles::squash::{Court, Message, SERVER};
use crate::roles::{Carried, Outbox};

/// Packet period of the links, µs: a link ends after 12 of them in silence.
const PACKET_US: u32 = 50_000;

/// When another was there.
#[derive(Clone, Debug, Serialize)]
pub struct PeerContact {
    /// 0 is the server, 1 … the players.
    number: u8,
    /// Where it should listen.
    address: SocketAddr,
    /// When it was first heard under the key, s after the start; absent if it never was.
    first_heard_s: Option<f64>,
    last_heard_s: Option<f64>,
    /// Datagrams of it that were refused.
    refused: u32,
    /// Why the last of them was.
    refusal: Option<String>,
}

impl fmt::Display for PeerContact {
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

/// The links to everybody else.
pub(super) struct Links {
    others: Vec<(Link, PeerContact)>,
    /// Who else sent something, last, and how many datagrams came from such.
    stranger: Option<(SocketAddr, u32)>,
}

impl Links {
    /// Everybody listens at one of `addresses`, in the order of their numbers; this one is `number`.
    pub(super) fn new(key: &Key, number: u8, addresses: &[SocketAddr]) -> Result<Self, Error> {
        let Court { length_m, width_m } = Court::SINGLES;
        let table = Table::new("squash").number("length_m", length_m.into()).number("width_m", width_m.into());
        let mut parameters = Parameters::new();
        parameters.add(table).map_err(|error| error.to_string())?;
        let others = (0..).zip(addresses).filter(|(other, _)| *other != number).map(|(other, address)| {
            let link = Link::new(Config {
                key: key.clone(),
                ends: Ends { local: PeerId(number), remote: PeerId(other) },
                packet_period_us: PACKET_US,
                parameters: parameters.clone(),
                entropy: entropy()?,
            });
            let (number, address, refused) = (other, *address, 0);
            let met = PeerContact { number, address, first_heard_s: None, last_heard_s: None, refused, refusal: None };
            Ok((link?, met))
        });
        Ok(Self { others: others.collect::<Result<_, Error>>()?, stranger: None })
    }

    /// Takes a datagram; `each` gets what it brought. The address only tells which link to ask; whether it is true, the seal does.
    pub(super) fn hear(
        &mut self,
        now: u64,
        address: SocketAddr,
        datagram: &mut [u8],
        mut each: impl FnMut(PeerId, &Message),
    ) {
        let Some((link, met)) = self.others.iter_mut().find(|(_, met)| met.address == address) else {
            self.stranger = Some((address, self.stranger.map_or(0, |(_, count)| count) + 1));
            return;
        };
        let taken = link.receive(now, datagram);
        met.refused = link.counts().refused;
        let taken = match taken {
            Ok(taken) => taken,
            Err(why) => return met.refusal = Some(why.to_string()),
        };
        if link.is_up() {
            met.last_heard_s = Some(now as f64 * 1e-6);
            met.first_heard_s = met.first_heard_s.or(met.last_heard_s);
        }
        let events = std::iter::from_fn(|| link.take_event().map(wire::Message::Event));
        let read = events.chain(taken).filter_map(|message| Message::read(&message));
        read.for_each(|(_, message)| each(PeerId(met.number), &message));
    }

    /// Says what a role wants to say, and what the links themselves have to.
    pub(super) fn say<const Q: usize>(
        &mut self,
        now: u64,
        roles: &mut Outbox<Message, Q>,
        net: &mut Out<'_, SocketAddr, [u8]>,
    ) {
        while let Some((to, message)) = roles.pop_front() {
            let Some((link, met)) = self.others.iter_mut().find(|(_, met)| met.number == to.0) else { continue };
            if let Ok(message) = message.carry(0) {
                link.say(now, message, |bytes| net(met.address, bytes));
            }
        }
        for (link, met) in &mut self.others {
            link.say_due(now, |bytes| net(met.address, bytes));
        }
    }

    /// Tells everybody that this is the end.
    pub(super) fn goodbye(&mut self, now: u64, net: &mut Out<'_, SocketAddr, [u8]>) {
        for (link, met) in &mut self.others {
            link.say(now, Goodbye {}, |bytes| net(met.address, bytes));
        }
    }

    /// The others, in order.
    pub(super) fn met(&self) -> impl Iterator<Item = &PeerContact> {
        self.others.iter().map(|(_, met)| met)
    }

    /// Links that are up.
    pub(super) fn up(&self) -> usize {
        self.others.iter().filter(|(link, _)| link.is_up()).count()
    }

    pub(super) fn refused(&self) -> u32 {
        self.met().map(|met| met.refused).sum()
    }

    /// What there is to say of `seconds` at `own` in which nobody was met, and what to check; nothing if somebody was.
    pub(super) fn nobody(&self, seconds: f64, own: SocketAddr) -> Option<String> {
        if self.met().any(|met| met.first_heard_s.is_some()) {
            return None;
        }
        let mut heard: Vec<String> = self.met().map(PeerContact::to_string).collect();
        if let Some((address, count)) = self.stranger {
            heard.push(format!("{count} datagrams came from elsewhere, the last from {address}"));
        }
        Some(format!(
            "nobody answered within {seconds} s: {}; check that they run now, with the same addresses in the same order and \
             the same key, and that UDP reaches {own}",
            heard.join(", "),
        ))
    }
}
