//! ICE on the sealed socket: which pairs of addresses lead from end to end, by the crate `is` (RFC 8445), and what it may send to whom.
//!
//! Candidates are the addresses of this machine and the one that the meeting place sees; the relayed candidate is the meeting place itself, which the
//! carrier keeps apart, for it works without being looked for. Both ends make both ends' credentials from the key and the two instances, so that
//! none is exchanged, and a STUN message of another run is none here.
//!
//! **Who may be sent to** (RFC 7675): an address has *proved* itself when a response to our own check came from where the check went. Until then it gets at
//! most [`BUDGET`] datagrams and one more every [`REFILL`], whatever the other end claims of it, and there are [`MOST_ASKED`] such addresses at
//! the most. A proof is good for checks for [`PROVED`]; flow stops sooner ([`CONSENT`]).

use std::collections::HashMap;
use std::net::{IpAddr, SocketAddr};
use std::time::{Duration, Instant};

use cohold_protocol::key::Key;
use is::stun::{StunMessage, StunPacket};
use is::{Candidate, IceAgent, IceAgentEvent, IceCreds, Protocol};

use crate::allowance::Allowance;
use crate::signal::Instance;
use crate::{Send, stun};

/// Datagrams to an address that has not proved itself.
pub(crate) const BUDGET: f64 = 5.0;
/// More of them each second.
const REFILL: f64 = 1.0 / 12.0;
/// Addresses that may be asked, in a time of [`FORGET`].
const MOST_ASKED: usize = 32;
/// Until an address that was asked is forgotten.
const FORGET: Duration = Duration::from_secs(60);
/// How long a proof lets checks through.
const PROVED: Duration = Duration::from_secs(30);
/// How long it lets flow through.
pub(crate) const CONSENT: Duration = Duration::from_secs(5);
/// Checks under way that are remembered.
const CHECKS: usize = 64;
/// Pairs that are looked at.
const PAIRS: usize = 48;
/// Between two checks: RFC 8445 allows 5 ms and more. Both ends' first checks open their routers for the other's second.
const PACE: Duration = Duration::from_millis(20);
/// Until a check is sent again for the first time; doubles from there on.
const FIRST_RETRY: Duration = Duration::from_millis(100);
/// Addresses that the other end may name.
const MOST_THEIRS: usize = 8;
/// STUN messages of the agent's are shorter.
const LONGEST: usize = 300;

#[derive(Clone, Copy, Debug)]
struct Asked {
    allowance: Allowance,
    proved: Option<Instant>,
}

/// Whether an address is of a local network.
pub(crate) fn is_local(address: SocketAddr) -> bool {
    match address.ip() {
        IpAddr::V4(ip) => ip.is_private() || ip.is_link_local() || ip.is_loopback(),
        IpAddr::V6(ip) => ip.is_unique_local() || ip.is_unicast_link_local() || ip.is_loopback(),
    }
}

/// What both ends' credentials come from.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    pub(crate) key: Key,
    pub(crate) side: u8,
    /// Of side 0 and of side 1.
    pub(crate) instances: [Instance; 2],
}

impl Origin {
    fn credentials(&self, side: u8, generation: u8) -> IceCreds {
        let [first, second] = &self.instances;
        let bytes: [u8; 20] = self.key.derive("ice").with(first).with(second).with(&[side, generation]).first();
        let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let (ufrag, pass) = hex.split_at(8);
        IceCreds { ufrag: ufrag.to_owned(), pass: pass.to_owned() }
    }
}

/// One end's search for a direct path to one run of the other end.
pub(crate) struct Ice {
    agent: IceAgent,
    origin: Origin,
    pub(crate) generation: u8,
    /// Addresses on which this end listens, by family.
    bases: Vec<SocketAddr>,
    theirs: Vec<(bool, SocketAddr)>,
    /// Where the agent would have flow go.
    nominated: Option<SocketAddr>,
    asked: HashMap<SocketAddr, Asked>,
    checks: Vec<([u8; 12], SocketAddr)>,
}

impl Ice {
    pub(crate) fn new(origin: Origin, bases: Vec<SocketAddr>) -> Self {
        let mut agent = IceAgent::new(origin.credentials(origin.side, 0));
        agent.set_controlling(origin.side == 0);
        agent.set_max_candidate_pairs(PAIRS);
        agent.set_timing_advance(PACE);
        agent.set_initial_stun_rto(FIRST_RETRY);
        agent.set_remote_credentials(origin.credentials(1 - origin.side, 0));
        for base in &bases {
            if let Ok(candidate) = Candidate::host(*base, "udp") {
                agent.add_local_candidate(candidate);
            }
        }
        let (asked, checks, theirs) = Default::default();
        Self { agent, origin, generation: 0, bases, theirs, nominated: None, asked, checks }
    }

    /// Begins anew, with what it knows.
    pub(crate) fn restart(&mut self, generation: u8) {
        let Self { origin, agent, .. } = self;
        agent.ice_restart(origin.credentials(origin.side, generation), true);
        agent.set_remote_credentials(origin.credentials(1 - origin.side, generation));
        self.generation = generation;
        for (seen, address) in std::mem::take(&mut self.theirs) {
            self.add_theirs(seen, address);
        }
    }

    /// This end is seen there from outside.
    pub(crate) fn add_seen(&mut self, seen: SocketAddr) {
        let base = self.bases.iter().find(|base| base.is_ipv4() == seen.is_ipv4());
        let made = base.filter(|base| **base != seen).map(|base| Candidate::server_reflexive(seen, *base, "udp"));
        if let Some(Ok(candidate)) = made {
            self.agent.add_local_candidate(candidate);
        }
    }

    /// The other end says that it may be reached there.
    pub(crate) fn add_theirs(&mut self, seen: bool, address: SocketAddr) {
        let ip = address.ip();
        let nobody = ip.is_unspecified() || ip.is_multicast() || address.port() == 0;
        let broadcast = matches!(ip, IpAddr::V4(ip) if ip.is_broadcast());
        if nobody || broadcast || self.theirs.len() >= MOST_THEIRS || self.theirs.contains(&(seen, address)) {
            return;
        }
        let made =
            if seen { Candidate::server_reflexive(address, address, "udp") } else { Candidate::host(address, "udp") };
        if let Ok(candidate) = made {
            self.theirs.push((seen, address));
            self.agent.add_remote_candidate(candidate);
        }
    }

    /// Whether an address has proved itself within that time.
    pub(crate) fn is_proved(&self, now: Instant, address: SocketAddr, within: Duration) -> bool {
        let proved = self.asked.get(&address).and_then(|asked| asked.proved);
        proved.is_some_and(|at| now.saturating_duration_since(at) < within)
    }

    /// Where flow goes directly: where the agent would have it go, or, until it has made up its mind, to an address that has proved itself.
    pub(crate) fn destination(&self, now: Instant) -> Option<SocketAddr> {
        let proved = |to: &SocketAddr| self.is_proved(now, *to, CONSENT);
        let nearest = || self.asked.keys().copied().filter(proved).max_by_key(|to| (is_local(*to), *to));
        self.nominated.filter(proved).or_else(nearest)
    }

    /// Something that only the other end can have made, in answer to us, came from there.
    pub(crate) fn prove(&mut self, now: Instant, address: SocketAddr) {
        if let Some(asked) = self.asked.get_mut(&address) {
            asked.proved = Some(now);
        }
    }

    /// Takes a STUN message.
    pub(crate) fn hear(&mut self, now: Instant, from: SocketAddr, datagram: &[u8]) {
        let base = self.bases.iter().find(|base| base.is_ipv4() == from.is_ipv4()).copied();
        let (Some(destination), Ok(message)) = (base, StunMessage::parse(datagram)) else { return };
        let response = stun::is_response(datagram);
        // The agent takes for granted that these are there.
        let whole = if message.is_binding_request() {
            message.prio().is_some() && message.split_username().is_some()
        } else {
            !response || message.mapped_address().is_some()
        };
        // A response comes from where its check went.
        let check = stun::transaction(datagram).filter(|_| !message.is_binding_request());
        let asked = check.is_none_or(|check| self.checks.contains(&(check, from)));
        if datagram.len() > LONGEST || !whole || !asked {
            return;
        }
        let packet = StunPacket { proto: Protocol::Udp, source: from, destination, message };
        if self.agent.handle_packet(now, packet) && response {
            self.prove(now, from);
        }
    }

    /// Sends what is due.
    pub(crate) fn poll(&mut self, now: Instant, send: &mut Send<'_>) {
        if self.agent.poll_timeout().is_none_or(|at| at <= now) {
            self.agent.handle_timeout(now);
        }
        while let Some(out) = self.agent.poll_transmit() {
            let to = out.destination;
            if !self.may_send(now, to) {
                continue;
            }
            if let Some(check) = stun::transaction(&out.contents) {
                self.checks.truncate(CHECKS - 1);
                self.checks.insert(0, (check, to));
            }
            send(to, &out.contents);
        }
        while let Some(event) = self.agent.poll_event() {
            if let IceAgentEvent::NominatedSend { destination, .. } = event {
                self.nominated = Some(destination);
            }
        }
    }

    fn may_send(&mut self, now: Instant, to: SocketAddr) -> bool {
        if self.is_proved(now, to, PROVED) {
            return true;
        }
        if !self.asked.contains_key(&to) && self.asked.len() >= MOST_ASKED {
            self.asked.retain(|_, asked| now.saturating_duration_since(asked.allowance.counted) < FORGET);
            if self.asked.len() >= MOST_ASKED {
                return false;
            }
        }
        let asked = self.asked.entry(to).or_insert(Asked { allowance: Allowance::new(BUDGET, now), proved: None });
        asked.allowance.takes(now, 1.0, [REFILL, BUDGET])
    }
}
