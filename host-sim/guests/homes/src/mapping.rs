//! A port asked of the router: PCP (RFC 6887), and NAT-PMP (RFC 6886) where the router knows only that.
//!
//! A router that gives every partner another port lets nobody in, unless it is asked to pass one port on. It is asked from the first moment on, without
//! anybody waiting: once it has said yes, its outer address and port are one candidate more. Bytes in the network's order.
//!
//! **Believed** is an answer from the router's address and port alone, whole, of the protocol that was asked in, about this end's port, and under PCP with the
//! nonce of this run, which nobody can guess who does not hear the question. NAT-PMP has no nonce: what a forged answer can do is name an address
//! that is not this end's, to which the partner then sends five checks (`ice.rs`).
//!
//! **Kept** for `LIFE_S` or what the router grants, renewed at half of it and every `RENEWED`, so that a router that has begun anew and forgotten is told
//! again; given back at the end ([`Mapping::goodbye`]). A router that says no is asked again after `REFUSED`; one that says nothing ever more seldom, up to `SELDOM`.
//! **Limits**: UPnP is not spoken; IPv4 alone, for IPv6 has no ports to map.

use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, SocketAddrV4};
use std::time::{Duration, Instant};

use cohold_protocol::key::Key;

use crate::frame::Bytes;

/// Where a router listens.
pub const PORT: u16 = 5351;
/// For how long a port is asked for, s: a run that dies leaves it behind for no longer.
const LIFE_S: u32 = 600;
/// Longest until it is asked for again.
const RENEWED: Duration = Duration::from_secs(60);
/// Longest that is believed, s.
const LONGEST_S: u32 = 86_400;
/// Until a question is asked again for the first time; doubles from there on (RFC 6886, 3.1).
const AGAIN: Duration = Duration::from_millis(250);
const SELDOM: Duration = Duration::from_secs(64);
/// Until a router is asked again that has said no.
const REFUSED: Duration = Duration::from_secs(60);
/// Questions in PCP that are not answered before NAT-PMP is tried, and the other way round.
const TRIES: u32 = 3;
const UDP: u8 = 17;
/// Result of a router that does not speak this version.
const OTHER_VERSION: u16 = 1;
/// Bytes of a question and an answer in PCP.
const PCP_LEN: usize = 60;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Speaks {
    Pcp,
    NatPmp,
}

/// A port that the router passes on.
#[derive(Clone, Copy, Debug)]
struct Granted {
    outer: SocketAddrV4,
    until: Instant,
}

/// A port of a router's, as one end asks for it and keeps it.
#[derive(Debug)]
pub struct Mapping {
    router: SocketAddr,
    own: SocketAddrV4,
    nonce: [u8; 12],
    speaks: Speaks,
    asked: u32,
    next: Instant,
    granted: Option<Granted>,
    /// Outer address, as NAT-PMP tells it apart from the port, and the port with its life, s.
    outer_ip: Option<Ipv4Addr>,
    outer_port: Option<(u16, u32)>,
    /// The router said no, with this number.
    pub refused: Option<u16>,
}

impl Mapping {
    /// Asks this router, from now on, to pass a port on to there; `entropy` must be unforeseeable.
    pub fn new(router: SocketAddr, own: SocketAddrV4, entropy: &Key, now: Instant) -> Self {
        let nonce = entropy.derive("mapping").first();
        let (granted, outer_ip, outer_port, refused) = Default::default();
        let (speaks, asked, next) = (Speaks::Pcp, 0, now);
        Self { router, own, nonce, speaks, asked, next, granted, outer_ip, outer_port, refused }
    }

    /// The outer address at which this end is reached, as long as the router has said so.
    pub fn outer(&self, now: Instant) -> Option<SocketAddr> {
        self.granted.filter(|granted| now < granted.until).map(|granted| granted.outer.into())
    }

    /// The question that is due: one datagram to the router, or two.
    pub fn poll(&mut self, now: Instant) -> Vec<Vec<u8>> {
        if now < self.next {
            return Vec::new();
        }
        if self.asked > 0 && self.asked.is_multiple_of(TRIES) && self.granted.is_none() {
            self.speaks = if self.speaks == Speaks::Pcp { Speaks::NatPmp } else { Speaks::Pcp };
        }
        self.next = now + (AGAIN * 2_u32.saturating_pow(self.asked.min(16))).min(SELDOM);
        self.asked += 1;
        (self.outer_ip, self.outer_port) = (None, None);
        self.questions(LIFE_S)
    }

    /// Gives the port back.
    pub fn goodbye(&mut self) -> Vec<Vec<u8>> {
        let had = self.granted.take().is_some();
        if had { self.questions(0) } else { Vec::new() }
    }

    fn questions(&self, life_s: u32) -> Vec<Vec<u8>> {
        let port = self.own.port().to_be_bytes();
        // The port that was had before, or the same as inside; no wish where it is given back (RFC 6886, 3.4).
        let wish = self.granted.map_or(self.own.port(), |granted| granted.outer.port());
        let wish = if life_s == 0 { [0; 2] } else { wish.to_be_bytes() };
        match self.speaks {
            Speaks::Pcp => {
                let own = self.own.ip().to_ipv6_mapped().octets();
                let nowhere = Ipv4Addr::UNSPECIFIED.to_ipv6_mapped().octets();
                let head = [&[2, 1, 0, 0][..], &life_s.to_be_bytes(), &own].concat();
                vec![[&head[..], &self.nonce, &[UDP, 0, 0, 0], &port, &wish, &nowhere].concat()]
            }
            Speaks::NatPmp => {
                let map = [&[0, 1, 0, 0][..], &port, &wish, &life_s.to_be_bytes()].concat();
                if life_s == 0 { vec![map] } else { vec![vec![0, 0], map] }
            }
        }
    }

    /// Takes what has come from somewhere; nothing happens where it is no answer that is believed.
    pub fn hear(&mut self, now: Instant, from: SocketAddr, datagram: &[u8]) {
        if from == self.router {
            let _ = match self.speaks {
                Speaks::Pcp => self.hear_pcp(now, datagram),
                Speaks::NatPmp => self.hear_nat_pmp(now, datagram),
            };
        }
    }

    fn hear_pcp(&mut self, now: Instant, datagram: &[u8]) -> Option<()> {
        let mut bytes = Bytes(datagram);
        let [version, kind] = bytes.next()?;
        if version == 0 && kind & 0x80 != 0 && self.granted.is_none() {
            // A router of NAT-PMP answers so what it does not know (RFC 6887, appendix A).
            let result = u16::from_be_bytes(bytes.next()?);
            if result == OTHER_VERSION && self.asked > 0 {
                (self.speaks, self.asked, self.next) = (Speaks::NatPmp, 0, now);
            }
            return None;
        }
        let [_, result] = bytes.next()?;
        let life_s = u32::from_be_bytes(bytes.next()?);
        // The router's clock, which a question that is asked so often has no need of, and what is reserved.
        let _: [u8; 16] = bytes.next()?;
        let (nonce, [kind_of, ..]): ([u8; 12], [u8; 4]) = (bytes.next()?, bytes.next()?);
        let (inner, outer) = (u16::from_be_bytes(bytes.next()?), u16::from_be_bytes(bytes.next()?));
        let ip = Ipv6Addr::from(bytes.next::<16>()?).to_ipv4_mapped();
        // Options may follow, which nobody asked for.
        let whole = version == 2 && kind == 0x81 && datagram.len() >= PCP_LEN && kind_of == UDP;
        if !whole || nonce != self.nonce || inner != self.own.port() {
            return None;
        }
        if result != 0 || life_s == 0 {
            self.refuse(now, result.into());
            return None;
        }
        self.grant(now, ip?, outer, life_s);
        Some(())
    }

    fn hear_nat_pmp(&mut self, now: Instant, datagram: &[u8]) -> Option<()> {
        let mut bytes = Bytes(datagram);
        let [version, kind] = bytes.next()?;
        let result = u16::from_be_bytes(bytes.next()?);
        let _: [u8; 4] = bytes.next()?;
        match (version, kind, datagram.len()) {
            (0, 128, 12) => {
                self.outer_ip = Some(bytes.next::<4>()?.into()).filter(|_| result == 0);
            }
            (0, 129, 16) => {
                let (inner, outer) = (u16::from_be_bytes(bytes.next()?), u16::from_be_bytes(bytes.next()?));
                if inner != self.own.port() {
                    return None;
                }
                let life_s = u32::from_be_bytes(bytes.next()?);
                if result != 0 || life_s == 0 {
                    self.refuse(now, result);
                    return None;
                }
                self.outer_port = Some((outer, life_s));
            }
            _ => return None,
        }
        let (ip, (port, life_s)) = (self.outer_ip?, self.outer_port?);
        self.grant(now, ip, port, life_s);
        Some(())
    }

    fn refuse(&mut self, now: Instant, result: u16) {
        (self.refused, self.granted, self.asked, self.next) = (Some(result), None, 0, now + REFUSED);
    }

    fn grant(&mut self, now: Instant, ip: Ipv4Addr, port: u16, life_s: u32) {
        let nobody = ip.is_unspecified() || ip.is_multicast() || ip.is_broadcast() || ip.is_loopback() || port == 0;
        if nobody {
            return;
        }
        let life = Duration::from_secs(life_s.min(LONGEST_S).into());
        self.granted = Some(Granted { outer: SocketAddrV4::new(ip, port), until: now + life });
        (self.refused, self.asked, self.next) = (None, 0, now + (life / 2).min(RENEWED));
    }
}
