//! [`Link`]: one direction of a network, from one end to the other; [`Inbox`]: which packets the receiver takes.
//!
//! Time is nanoseconds throughout, of the sender's or any other clock that all calls share. What is due by a time is
//! delivered in the order in which it was due, and of things due at once in the order in which they were sent.

use std::borrow::{Borrow as _, BorrowMut};
use std::collections::VecDeque;

use cohold_core::playout::Playout;

use super::rule::{Arrival, Direction, Fate, Rule, of_scene};
use crate::scene::Scene;

/// A packet as the network carries it.
pub trait Payload: ToOwned<Owned: BorrowMut<Self>> {
    /// Corrupts the packet as a transmission error does; false if it is then lost, because it would fail authentication.
    fn corrupt(&mut self) -> bool {
        false
    }

    /// Takes note that it will have been on its way for `_delay_ns` (ns).
    fn travels(&mut self, _delay_ns: u64) {}

    /// Number, from 0, of the packet period in which it was sent; `None` if it does not carry that: packets are then counted as sent.
    fn number(&self) -> Option<u64> {
        None
    }
}

/// A datagram: one bit in the middle is another.
impl Payload for [u8] {
    fn corrupt(&mut self) -> bool {
        let middle = self.len() / 2;
        self.get_mut(middle).is_some_and(|byte| {
            *byte ^= 0x10;
            true
        })
    }
}

/// A value that crosses without being put into bytes, with the number that a sealed link would give it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbered<T> {
    /// Packet periods of the sender before this one, those in which it kept silent included.
    pub number: u64,
    /// How long it was on its way, ns; 0 before it is sent.
    pub delay_ns: u64,
    /// The packet of that number.
    pub what: T,
}

impl<T> Numbered<T> {
    /// A packet before it is sent.
    pub fn new(number: u64, what: T) -> Self {
        Self { number, delay_ns: 0, what }
    }
}

impl<T: Clone> Payload for Numbered<T> {
    #[inline]
    fn travels(&mut self, delay_ns: u64) {
        self.delay_ns = delay_ns;
    }

    #[inline]
    fn number(&self) -> Option<u64> {
        Some(self.number)
    }
}

/// What became of the packets that were sent in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// Number of packets that were sent.
    pub taken: u64,
    /// Number of copies that have come out or are under way.
    pub sent: u64,
    /// Number of packets that were lost.
    pub lost: u64,
    /// Number of packets that were corrupted.
    pub corrupt: u64,
}

/// What one direction of a network does to packets: a constant delay, and a rule that decides the fate of each.
#[derive(Default)]
pub struct Route {
    /// Delay of every packet, ns.
    pub delay_ns: u64,
    /// Whether every packet is dropped.
    pub cut: bool,
    /// The rule that decides the fate of each packet; without one every packet passes.
    pub rule: Option<Box<dyn Rule>>,
    counts: Counts,
}

impl Route {
    /// A route with this delay (ns) that changes, loses and repeats nothing.
    pub fn new(delay_ns: u64) -> Self {
        Self { delay_ns, ..Self::default() }
    }

    /// The route in this direction as the scene describes it; each `line` of several has its own random numbers.
    pub fn of_scene(scene: &Scene, direction: Direction, line: u32) -> Self {
        let packets = u64::from(scene.world.network.one_way_delay_packets);
        let rule = of_scene(scene, direction, line);
        Self { rule, ..Self::new(packets * scene.peer.timing.packet_period_ns()) }
    }

    /// This route under another rule.
    pub fn with_rule(self, rule: impl Rule + 'static) -> Self {
        Self { rule: Some(Box::new(rule)), ..self }
    }

    /// Takes a packet that is sent at `now_ns` (ns); `each` gets every copy and when it is due (ns).
    #[inline]
    pub fn send<P: Payload + ?Sized>(&mut self, now_ns: u64, packet: &P, mut each: impl FnMut(u64, P::Owned)) {
        let mut each = |due_ns: u64, mut copy: P::Owned| {
            copy.borrow_mut().travels(due_ns - now_ns);
            each(due_ns, copy);
        };
        let number = packet.number().unwrap_or(self.counts.taken);
        self.counts.taken += 1;
        let due_ns = now_ns + self.delay_ns;
        let fate = match &mut self.rule {
            _ if self.cut => Fate::Drop,
            Some(rule) => rule.decide(number, now_ns),
            None => Fate::Pass,
        };
        match fate {
            Fate::Pass => {
                self.counts.sent += 1;
                each(due_ns, packet.to_owned());
            }
            Fate::Drop => self.counts.lost += 1,
            Fate::Copies(copies) => {
                self.counts.lost += u64::from(copies.is_empty());
                for Arrival { delay_ns, corrupt } in copies {
                    let mut copy = packet.to_owned();
                    self.counts.corrupt += u64::from(corrupt);
                    if !corrupt || copy.borrow_mut().corrupt() {
                        self.counts.sent += 1;
                        each(due_ns + delay_ns, copy);
                    }
                }
            }
        }
    }

    /// What became of the packets so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

/// What is on its way, ordered by when it is due.
pub(crate) struct InFlight<T>(VecDeque<(u64, T)>);

impl<T> Default for InFlight<T> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

impl<T> InFlight<T> {
    #[inline]
    pub(crate) fn put(&mut self, due_ns: u64, what: T) {
        if self.0.back().is_none_or(|(last_ns, _)| *last_ns <= due_ns) {
            return self.0.push_back((due_ns, what));
        }
        let at = self.0.partition_point(|(other_ns, _)| *other_ns <= due_ns);
        self.0.insert(at, (due_ns, what));
    }

    /// The next that is due by `now_ns`, and when it was.
    #[inline]
    pub(crate) fn take(&mut self, now_ns: u64) -> Option<(u64, T)> {
        self.0.pop_front_if(|(due_ns, _)| *due_ns <= now_ns)
    }
}

/// One direction of a network, and the packets that are under way in it.
pub struct Link<P: Payload + ?Sized> {
    route: Route,
    in_flight: InFlight<P::Owned>,
    /// Bytes that there is still room for.
    room: usize,
    /// Packets that there was no room for.
    crowded: u64,
}

impl<P: Payload + ?Sized> Link<P> {
    /// A link over this route that holds any number of packets.
    pub fn new(route: Route) -> Self {
        Self { route, in_flight: InFlight::default(), room: usize::MAX, crowded: 0 }
    }

    /// This link with room for `most_bytes` bytes under way, of packets and their bookkeeping; a packet that finds no
    /// room is lost.
    pub fn holding(self, most_bytes: usize) -> Self {
        Self { room: most_bytes, ..self }
    }

    fn size(packet: &P) -> usize {
        size_of_val(packet) + size_of::<(u64, P::Owned)>()
    }

    /// Takes a packet that is sent at `now_ns`.
    pub fn send(&mut self, now_ns: u64, packet: &P) {
        let size = Self::size(packet);
        self.route.send(now_ns, packet, |due_ns, copy| match self.room.checked_sub(size) {
            Some(room) => {
                self.room = room;
                self.in_flight.put(due_ns, copy);
            }
            None => self.crowded += 1,
        });
    }

    /// The next packet that has arrived by `now_ns`, and when it has.
    pub fn take(&mut self, now_ns: u64) -> Option<(u64, P::Owned)> {
        let taken = self.in_flight.take(now_ns)?;
        self.room = self.room.saturating_add(Self::size(taken.1.borrow()));
        Some(taken)
    }

    /// What became of the packets so far; those that found no room count as lost.
    pub fn counts(&self) -> Counts {
        let counts = self.route.counts();
        Counts { sent: counts.sent - self.crowded, lost: counts.lost + self.crowded, ..counts }
    }
}

/// A receiver's buffer, read every so many control periods: it gives the newest packet that has come, and drops what is
/// older, overtaken, a duplicate, or was on its way for longer than `safety.max_delay_s`. With `network.playout_packets` packets go through the peers' own play-out buffer.
#[derive(Clone, Debug)]
pub struct Inbox<T> {
    /// Where the newest packet lies, taken or not: it is put there, and read there.
    newest: Option<Numbered<T>>,
    /// It has not been taken yet.
    waits: bool,
    /// Its 64 places are not in every inbox: of sixteen lanes they are 100 kB and more.
    playout: Option<Box<Buffered<T>>>,
    /// Longest delay of a packet that is taken, ns.
    pub max_delay_ns: u64,
    /// Whether the packet that came last was older than that.
    pub is_old: bool,
    /// Packets taken by the receiver.
    pub delivered: u64,
    /// Number of packets dropped because they came after a newer one was taken, together with one, or twice.
    pub dropped: u64,
}

/// The play-out buffer, in ticks: the sender's at which a packet was sent, the receiver's at which it came.
#[derive(Clone, Debug)]
struct Buffered<T> {
    playout: Playout<Numbered<T>>,
    /// What has come since the receiver looked last, and when, ns.
    came: Vec<(u64, Numbered<T>)>,
    tick_ns: u64,
    ticks_per_packet: u32,
    /// Ticks from one look to the next.
    every: u32,
    /// The receiver's clock, ticks.
    local: u32,
}

impl<T> Buffered<T> {
    fn take(&mut self, now_ns: u64, dropped: &mut u64) -> Option<Numbered<T>> {
        for (came_ns, packet) in self.came.drain(..) {
            let ago = now_ns.saturating_sub(came_ns).div_ceil(self.tick_ns) as u32;
            let sent = (packet.number as u32).wrapping_mul(self.ticks_per_packet);
            let kept = self.playout.put(self.local.wrapping_sub(ago), sent, packet);
            *dropped += u64::from(!kept);
        }
        let before = self.playout.waiting();
        let played = self.playout.take(self.local);
        self.local = self.local.wrapping_add(self.every);
        *dropped += (before - self.playout.waiting()) as u64 - u64::from(played.is_some());
        played
    }
}

impl<T> Inbox<T> {
    /// An empty inbox with the scene's play-out buffer, if any; the receiver takes from it every `every` ticks.
    pub fn new(scene: &Scene, every: u32) -> Self {
        let (depth, timing) = (scene.world.network.playout_packets, &scene.peer.timing);
        let buffered = || {
            Box::new(Buffered {
                playout: Playout::new(depth, timing.ticks_per_packet),
                came: Vec::new(),
                tick_ns: timing.control_period_ns(),
                ticks_per_packet: timing.ticks_per_packet,
                every,
                local: 0,
            })
        };
        let (playout, max_delay_ns) = ((depth > 0).then(buffered), scene.peer.safety.max_delay_ns());
        Self { newest: None, waits: false, playout, max_delay_ns, is_old: false, delivered: 0, dropped: 0 }
    }

    /// That of peer `index` (0 or 1), which may have a `safety.max_delay_s` of its own.
    pub fn of_end(scene: &Scene, index: usize, every: u32) -> Self {
        Self { max_delay_ns: scene.peers()[index].safety.max_delay_ns(), ..Self::new(scene, every) }
    }

    /// Takes a packet that came at `now_ns`.
    #[inline]
    pub fn put(&mut self, now_ns: u64, packet: Numbered<T>) {
        self.is_old = packet.delay_ns > self.max_delay_ns;
        if self.is_old {
            self.dropped += 1;
        } else if let Some(buffered) = &mut self.playout {
            buffered.came.push((now_ns, packet));
        } else if self.newest.as_ref().is_none_or(|newest| packet.number > newest.number) {
            self.newest = Some(packet);
            // One that waited until now is overtaken after all.
            self.dropped += u64::from(std::mem::replace(&mut self.waits, true));
        } else {
            self.dropped += 1;
        }
    }

    /// The packet that the receiver takes at `now_ns` (ns), if any.
    #[inline]
    pub fn take(&mut self, now_ns: u64) -> Option<&T> {
        if let Some(buffered) = &mut self.playout
            && let Some(played) = buffered.take(now_ns, &mut self.dropped)
        {
            self.newest = Some(played);
            self.waits = true;
        }
        if !std::mem::take(&mut self.waits) {
            return None;
        }
        self.delivered += 1;
        self.taken()
    }

    /// The packet that was taken last.
    #[inline]
    pub fn taken(&self) -> Option<&T> {
        self.newest.as_ref().map(|newest| &newest.what)
    }
}
