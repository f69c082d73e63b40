//! The carrier: under the socket of one end, above it the link, which knows one address and sees no path.
//!
//! What the link says goes by the relay from the first moment on; meanwhile ICE looks for a direct path, and flow changes over to it within
//! the session (`paths.rs` says when, and when back). What comes is told apart by its first byte ([`crate::frame`]): signals, STUN and
//! welcomes are for the carrier, sealed datagrams for the link, and only from the meeting place or from an address that has proved itself.
//! Where both paths bring the same datagram, byte for byte, the second is counted as a copy and goes no further; all else the
//! link judges itself, for only it can. What comes directly after flow has come by the relay waits for a while (`hold.rs`), so that a line becomes shorter
//! slowly; [`Carrier::release`] gives it.
//!
//! **Signals** go every `DIRECT_EVERY` directly where no flow does, else every `BESIDE_FLOW`; by the relay every `RELAY_EVERY`, or `RELAY_RESTS` while it rests.
//! **A direct path that dies** is missed by flow (`paths.rs`); after `RESTART` ICE begins anew, and again after twice as long, up to `LONGEST_RESTART`.
//! **Flow to an address** ends `CONSENT` after it last proved that it wants it.

use std::collections::VecDeque;
use std::hash::{BuildHasher, RandomState};
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use cohold_live::road::{Change, PathReport, Way};
use cohold_protocol::key::Key;

use crate::Send;
use crate::frame::Frame;
use crate::hold::Hold;
use crate::ice::{CONSENT, Ice, Origin, is_local};
use crate::paths::{DEAF, Paths};
use crate::seat::Seat;
use crate::signal::{Instance, MOST_ADDRESSES, Sealer, Signal, open};

const DIRECT_EVERY: Duration = Duration::from_millis(5);
const BESIDE_FLOW: Duration = Duration::from_millis(20);
const RELAY_EVERY: Duration = Duration::from_millis(20);
const RELAY_RESTS: Duration = Duration::from_millis(200);
/// How long there is no direct path before ICE begins anew.
const RESTART: Duration = Duration::from_secs(3);
const LONGEST_RESTART: Duration = Duration::from_secs(48);
/// The other end's restarts are followed no quicker.
const FOLLOWS: Duration = Duration::from_secs(2);
/// Nothing by the relay for so long, though it is used: the seat is taken anew.
const SILENT: Duration = Duration::from_millis(100);
/// Nothing of the other end for so long: it may be another run of it that calls.
const ABSENT: Duration = Duration::from_secs(1);
/// Datagrams among which copies are found: half a second of both paths.
const REMEMBERED: usize = 1024;
/// Earlier runs of the other end that are remembered, so that none is taken for a new one.
const RETIRED: usize = 64;
/// Changes of path that wait to be taken.
const CHANGES: usize = 256;

/// The other end's present run.
struct Other {
    instance: Instance,
    ice: Option<Ice>,
    heard: Instant,
    /// Counter of its newest signal by any path.
    said: u64,
    followed: Instant,
}

/// What a carrier is told.
#[derive(Clone, Debug)]
pub struct Config {
    /// The key that both ends share.
    pub key: Key,
    /// 0 for peer 1, 1 for peer 2.
    pub side: u8,
    /// The meeting place.
    pub meet: SocketAddr,
    /// The socket's addresses as this machine has them, one of each family at the most.
    pub bases: Vec<SocketAddr>,
    /// An outer address that a router passes on to the socket, where somebody has told it to.
    pub mapped: Option<SocketAddr>,
    /// Flow stays on the relay, so that the partner learns no address.
    pub relay_only: bool,
}

/// One end's carrier.
pub struct Carrier {
    config: Config,
    start: Instant,
    instance: Instance,
    sealer: Sealer,
    seat: Seat,
    /// The newest run of the other end that was heard, which may be an old one.
    caller: Option<Instance>,
    other: Option<Other>,
    retired: Vec<Instance>,
    paths: Paths,
    hold: Hold,
    /// When flow came directly last.
    flow_heard: Option<Instant>,
    relay_heard: Instant,
    flowed: Option<Instant>,
    /// Where flow goes directly, as far as it does.
    flows_to: Option<SocketAddr>,
    restart_after: Duration,
    restarted: Instant,
    came: VecDeque<(u64, bool)>,
    hasher: RandomState,
    way: Way,
    report: PathReport,
    changes: VecDeque<Change>,
}

impl std::fmt::Debug for Carrier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Carrier({:?} by {})", self.way, self.config.meet)
    }
}

impl Carrier {
    /// One that begins at `now`; `entropy` must be unforeseeable and another at every start.
    pub fn new(config: Config, entropy: &Key, now: Instant) -> Self {
        let instance: Instance = entropy.derive("instance").first();
        Self {
            start: now,
            instance,
            sealer: Sealer::new(&config.key, config.side, instance),
            seat: Seat::new(&config.key, config.side, entropy),
            caller: None,
            other: None,
            retired: Vec::new(),
            paths: Paths::new(now),
            hold: Hold::default(),
            flow_heard: None,
            relay_heard: now,
            flowed: None,
            flows_to: None,
            restart_after: RESTART,
            restarted: now,
            came: VecDeque::with_capacity(REMEMBERED),
            hasher: RandomState::new(),
            way: Way::Nowhere,
            report: PathReport::default(),
            changes: VecDeque::new(),
            config,
        }
    }

    /// The meeting place: the one address that the link above knows.
    pub fn address(&self) -> SocketAddr {
        self.config.meet
    }

    /// Which way flow goes.
    pub fn way(&self) -> Way {
        self.way
    }

    /// The oldest change of path that was not taken yet.
    pub fn take_change(&mut self) -> Option<Change> {
        self.changes.pop_front()
    }

    /// A router passes this outer address on to the socket, from now on.
    pub fn add_mapped(&mut self, mapped: SocketAddr) {
        if self.config.mapped.replace(mapped) != Some(mapped)
            && let Some(ice) = self.ice()
        {
            ice.add_seen(mapped);
        }
    }

    /// What there is to say of the paths.
    pub fn report(&self) -> PathReport {
        let [relayed, direct] = [0, 1].map(|at: usize| self.paths.of[at].figures());
        let (way, lan, mapped) = (self.way, self.is_lan(), self.config.mapped);
        PathReport { way, lan, mapped, relayed, direct, ..self.report.clone() }
    }

    fn us(&self, now: Instant) -> u64 {
        now.saturating_duration_since(self.start).as_micros() as u64 + 1
    }

    fn ice(&mut self) -> Option<&mut Ice> {
        self.other.as_mut()?.ice.as_mut()
    }

    /// Where flow goes directly.
    fn direct(&self, now: Instant) -> Option<SocketAddr> {
        self.other.as_ref()?.ice.as_ref()?.destination(now)
    }

    fn is_lan(&self) -> bool {
        self.paths.is_direct() && self.flows_to.is_some_and(is_local)
    }

    /// Sends a datagram of the link's; whether there was a path.
    pub fn send(&mut self, now: Instant, datagram: &[u8], send: &mut Send<'_>) -> bool {
        let direct = self.direct(now);
        if let Some(to) = direct {
            self.flowed = Some(now);
            send(to, datagram);
        }
        let relayed = self.paths.uses_relay(now) && self.seat.other_is_there(now);
        if relayed {
            send(self.config.meet, datagram);
        }
        let sent = relayed || direct.is_some();
        self.report.pathless += u64::from(!sent);
        sent
    }

    /// Takes a datagram; whether it is for the link.
    pub fn hear(&mut self, now: Instant, from: SocketAddr, datagram: &[u8], send: &mut Send<'_>) -> bool {
        let by_relay = from == self.config.meet;
        match Frame::of(datagram) {
            Frame::Stun => {
                if let Some(ice) = self.ice() {
                    ice.hear(now, from, datagram);
                    ice.poll(now, send);
                }
                return false;
            }
            Frame::Welcome if by_relay => {
                if self.seat.hear(now, datagram) == Some(true) {
                    self.join(now, send);
                }
                if let (Some(seen), Some(ice)) = (self.seat.seen, self.ice()) {
                    ice.add_seen(seen);
                }
                return false;
            }
            Frame::Signal if self.signal(now, from, datagram, send).is_some() => return false,
            Frame::Sealed if by_relay => {
                self.relay_heard = now;
                let new = self.is_new(datagram, false);
                if new && self.flow_heard.is_none_or(|at| now.saturating_duration_since(at) > DEAF) {
                    self.hold.is_relayed();
                }
                return new;
            }
            Frame::Sealed if self.is_proved(now, from) => {
                self.paths.heard(now, false);
                self.flow_heard = Some(now);
                return !self.hold.takes(now, datagram) && self.is_new(datagram, true);
            }
            _ => {}
        }
        self.report.strangers += 1;
        false
    }

    /// What has waited for long enough and is for the link, oldest first; none: nothing has by now.
    pub fn release(&mut self, now: Instant) -> Option<Vec<u8>> {
        while let Some(datagram) = self.hold.release(now) {
            if self.is_new(&datagram, true) {
                return Some(datagram);
            }
        }
        None
    }

    fn is_proved(&self, now: Instant, from: SocketAddr) -> bool {
        let ice = self.other.as_ref().and_then(|other| other.ice.as_ref());
        ice.is_some_and(|ice| ice.is_proved(now, from, CONSENT))
    }

    /// Whether the other path has not brought these very bytes.
    fn is_new(&mut self, datagram: &[u8], direct: bool) -> bool {
        let hash = self.hasher.hash_one(datagram);
        if self.came.contains(&(hash, !direct)) {
            self.report.copies += 1;
            return false;
        }
        if self.came.len() == REMEMBERED {
            self.came.pop_front();
        }
        self.came.push_back((hash, direct));
        self.paths.of[usize::from(direct)].datagrams += 1;
        true
    }

    /// Takes a signal; none where it is nothing that counts.
    fn signal(&mut self, now: Instant, from: SocketAddr, datagram: &[u8], send: &mut Send<'_>) -> Option<()> {
        let by_relay = from == self.config.meet;
        let (instance, counter, signal) = open(&self.config.key, 1 - self.config.side, datagram)?;
        let known = self.other.as_ref().filter(|other| other.instance == instance);
        let absent = self.other.as_ref().is_none_or(|other| now.saturating_duration_since(other.heard) > ABSENT);
        if signal.direct == by_relay || known.is_none() && (!absent || self.retired.contains(&instance)) {
            return None;
        }
        self.caller = Some(instance);
        if signal.echo != self.instance {
            // It does not know this run yet, or is an old one: it is greeted, and nothing of it is believed.
            return by_relay.then_some(());
        }
        if known.is_none() {
            self.begin(now, instance);
        }
        if !by_relay && !self.is_proved(now, from) {
            // Who makes this signal has heard of this run, but what came from there may have been sent on by anybody.
            return None;
        }
        let path = &mut self.paths.of[usize::from(!by_relay)];
        if path.newest.is_some_and(|(newest, ..)| counter <= newest) {
            return None;
        }
        path.newest = Some((counter, signal.sent_us, now));
        let now_us = now.saturating_duration_since(self.start).as_micros() as u64 + 1;
        let away_us = (signal.echo_us > 0).then(|| now_us.saturating_sub(signal.echo_us));
        path.came(signal.count, away_us.map(|us| us.saturating_sub(signal.held_us.into())));
        self.hold.took(now, !by_relay, signal.sent_us, now_us);
        if by_relay {
            self.relay_heard = now;
        } else {
            self.paths.heard(now, true);
        }
        let other = self.other.as_mut()?;
        other.heard = now;
        // What comes by the longer path is older, and says what was.
        if counter > other.said {
            other.said = counter;
            self.paths.said(now, signal.hears);
        }
        self.paths.look(now);
        if let Some(ice) = &mut other.ice {
            if !by_relay {
                ice.prove(now, from);
            }
            let newer = signal.generation.wrapping_sub(ice.generation);
            if (1..128).contains(&newer) && now.saturating_duration_since(other.followed) >= FOLLOWS {
                other.followed = now;
                self.report.restarts += 1;
                ice.restart(signal.generation);
            }
            for (seen, address) in signal.addresses {
                ice.add_theirs(seen, address);
            }
            ice.poll(now, send);
        }
        Some(())
    }

    /// The other end's run is this one.
    fn begin(&mut self, now: Instant, instance: Instance) {
        if let Some(before) = self.other.take() {
            if self.retired.len() == RETIRED {
                self.retired.remove(0);
            }
            self.retired.push(before.instance);
        }
        self.paths.of.iter_mut().for_each(|path| path.forget());
        (self.hold, self.flow_heard) = Default::default();
        let own = self.instance;
        let instances = if self.config.side == 0 { [own, instance] } else { [instance, own] };
        let origin = Origin { key: self.config.key.clone(), side: self.config.side, instances };
        let mut ice = (!self.config.relay_only).then(|| Ice::new(origin, self.config.bases.clone()));
        if let Some(ice) = &mut ice {
            self.seat.seen.into_iter().chain(self.config.mapped).for_each(|seen| ice.add_seen(seen));
        }
        let long_ago = now.checked_sub(FOLLOWS).unwrap_or(now);
        self.other = Some(Other { instance, ice, heard: now, said: 0, followed: long_ago });
        (self.restart_after, self.restarted) = (RESTART, now);
    }

    fn join(&mut self, now: Instant, send: &mut Send<'_>) {
        let used = self.seat.other_is_there(now) && self.paths.uses_relay(now);
        let silent = used && self.other.is_some() && now.saturating_duration_since(self.relay_heard) > SILENT;
        if let Some(join) = self.seat.poll(now, silent) {
            send(self.config.meet, &join);
        }
    }

    /// Sends what is due: to be called each millisecond.
    pub fn poll(&mut self, now: Instant, send: &mut Send<'_>) {
        self.join(now, send);
        self.paths.look(now);
        if let Some(ice) = self.ice() {
            ice.poll(now, send);
        }
        self.restart(now);
        let due = |at: Option<Instant>, every| at.is_none_or(|at| now.saturating_duration_since(at) >= every);
        let every = if self.paths.uses_relay(now) { RELAY_EVERY } else { RELAY_RESTS };
        if self.seat.other_is_there(now) && due(self.paths.of[0].sent_at, every) {
            let signal = self.say(now, false);
            send(self.config.meet, &signal);
        }
        let every = if due(self.flowed, DIRECT_EVERY) { DIRECT_EVERY } else { BESIDE_FLOW };
        self.flows_to = self.direct(now);
        if let Some(to) = self.flows_to.filter(|_| due(self.paths.of[1].sent_at, every)) {
            let signal = self.say(now, true);
            send(to, &signal);
        }
        self.see(now);
    }

    /// A signal for a path.
    fn say(&mut self, now: Instant, direct: bool) -> Vec<u8> {
        let hears = self.paths.hears(now);
        let sent_us = self.us(now);
        let path = &mut self.paths.of[usize::from(direct)];
        path.sent = path.sent.wrapping_add(1);
        path.sent_at = Some(now);
        let (echo_us, held) = path.newest.map_or_else(Default::default, |(_, sent_us, at)| (sent_us, now - at));
        let count = path.sent;
        let echo = self.caller.unwrap_or_default();
        let generation = self.other.as_ref().and_then(|other| other.ice.as_ref()).map_or(0, |ice| ice.generation);
        let mut addresses = Vec::new();
        if !direct && !self.config.relay_only && self.other.is_some() {
            addresses.extend(self.config.bases.iter().map(|base| (false, *base)));
            let outer = self.seat.seen.into_iter().chain(self.config.mapped);
            addresses.extend(outer.filter(|seen| !self.config.bases.contains(seen)).map(|seen| (true, seen)));
            addresses.truncate(MOST_ADDRESSES);
        }
        let held_us = u32::try_from(held.as_micros()).unwrap_or(u32::MAX);
        self.sealer.seal(&Signal { hears, direct, generation, count, sent_us, echo_us, held_us, echo, addresses })
    }

    /// Has ICE begin anew where there is no direct path for long: one end decides.
    fn restart(&mut self, now: Instant) {
        if self.paths.is_direct() {
            (self.restart_after, self.restarted) = (RESTART, now);
            return;
        }
        let bad = self.paths.bad_for(now).min(now.saturating_duration_since(self.restarted));
        if self.config.side != 0 || bad < self.restart_after {
            return;
        }
        self.restarted = now;
        self.restart_after = (2 * self.restart_after).min(LONGEST_RESTART);
        if let Some(ice) = self.other.as_mut().and_then(|other| other.ice.as_mut()) {
            self.report.restarts += 1;
            ice.restart(ice.generation.wrapping_add(1));
        }
    }

    /// Which way flow goes now.
    fn see(&mut self, now: Instant) {
        let relayed = self.paths.uses_relay(now);
        let way = match self.paths.is_direct() {
            true if relayed => Way::Both,
            true => Way::Direct,
            false if self.seat.other_is_there(now) => Way::Relayed,
            false => Way::Nowhere,
        };
        if std::mem::replace(&mut self.way, way) != way {
            self.report.changes += 1;
            if self.changes.len() < CHANGES {
                let lan = self.is_lan();
                self.changes.push_back(Change { at: now, way, lan });
            }
        }
    }
}
