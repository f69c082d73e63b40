//! [`Link`]: one way of a network, from one end to the other; [`Inbox`]: which of what has come the receiver takes.
//!
//! Time is nanoseconds throughout, of the sender's or any other clock that all calls share. What is due by a time is
//! delivered in the order in which it was due, and of things due at once in the order in which they were sent.

use std::borrow::BorrowMut;
use std::collections::VecDeque;

use haptic_protocol::playout::Playout;
use haptic_protocol::wire::Message;

use super::rule::{Arrival, Direction, Fate, Rule, of_scene};
use crate::scene::Scene;

/// What travels.
pub trait Payload: ToOwned<Owned: BorrowMut<Self>> {
    /// Breaks it as a line does. False where what is broken is not delivered, because it would not pass the seal.
    fn corrupt(&mut self) -> bool;
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

/// A message of a role.
impl Payload for Message {
    fn corrupt(&mut self) -> bool {
        false
    }
}

/// A value that crosses without being put into bytes, with the number that a sealed link would give it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbered<T> {
    /// Counted by the sender.
    pub number: u64,
    /// The value.
    pub what: T,
}

impl<T: Clone> Payload for Numbered<T> {
    fn corrupt(&mut self) -> bool {
        false
    }
}

/// What became of what one way was given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// Packets taken in.
    pub taken: u64,
    /// Packets that came out or are on their way, copies included.
    pub sent: u64,
    /// Packets lost.
    pub lost: u64,
    /// Packets broken on purpose.
    pub corrupt: u64,
}

/// What one way of a network does to packets: a constant delay, and what a rule says.
#[derive(Default)]
pub struct Route {
    /// Delay of every packet, ns.
    pub delay_ns: u64,
    /// Nothing passes.
    pub cut: bool,
    /// What becomes of each packet; none, and it passes.
    pub rule: Option<Box<dyn Rule>>,
    counts: Counts,
}

impl Route {
    /// A delay and nothing else.
    pub fn new(delay_ns: u64) -> Self {
        Self { delay_ns, ..Self::default() }
    }

    /// The direction's network as the scene describes it, on line `line` of several with streams of their own.
    pub fn of_scene(scene: &Scene, direction: Direction, line: u32) -> Self {
        let packets = u64::from(scene.world.network.one_way_delay_packets);
        let rule = of_scene(scene, direction, line);
        Self { rule, ..Self::new(packets * scene.peer.timing.packet_period_ns()) }
    }

    /// The same under another rule.
    pub fn with_rule(self, rule: impl Rule + 'static) -> Self {
        Self { rule: Some(Box::new(rule)), ..self }
    }

    /// Takes a packet that is sent at `now_ns`; `each` gets every copy and when it is due.
    #[inline]
    pub fn send<P: Payload + ?Sized>(&mut self, now_ns: u64, packet: &P, mut each: impl FnMut(u64, P::Owned)) {
        let number = self.counts.taken;
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
#[derive(Clone, Debug)]
pub struct InFlight<T>(VecDeque<(u64, T)>);

impl<T> Default for InFlight<T> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

impl<T> InFlight<T> {
    /// Takes something that is due at `due_ns`.
    #[inline]
    pub fn put(&mut self, due_ns: u64, what: T) {
        let at = if self.0.back().is_none_or(|(last_ns, _)| *last_ns <= due_ns) {
            self.0.len()
        } else {
            self.0.partition_point(|(other_ns, _)| *other_ns <= due_ns)
        };
        self.0.insert(at, (due_ns, what));
    }

    /// The next that is due by `now_ns`, and when it was.
    #[inline]
    pub fn take(&mut self, now_ns: u64) -> Option<(u64, T)> {
        self.0.pop_front_if(|(due_ns, _)| *due_ns <= now_ns)
    }
}

/// One way of a network, and what is on it.
pub struct Link<P: Payload + ?Sized> {
    route: Route,
    in_flight: InFlight<P::Owned>,
}

impl<P: Payload + ?Sized> Link<P> {
    /// Over a route.
    pub fn new(route: Route) -> Self {
        Self { route, in_flight: InFlight::default() }
    }

    /// Takes a packet that is sent at `now_ns`.
    pub fn send(&mut self, now_ns: u64, packet: &P) {
        self.route.send(now_ns, packet, |due_ns, copy| self.in_flight.put(due_ns, copy));
    }

    /// The next packet that has arrived by `now_ns`, and when it has.
    pub fn take(&mut self, now_ns: u64) -> Option<(u64, P::Owned)> {
        self.in_flight.take(now_ns)
    }

    /// What became of the packets so far.
    pub fn counts(&self) -> Counts {
        self.route.counts()
    }
}

/// A receiver that looks once a packet period: it takes the newest that has come, and drops what is older, overtaken or a
/// second copy. With `network.playout_packets` what has come goes through the peers' own play-out buffer.
#[derive(Clone, Debug)]
pub struct Inbox<T> {
    waiting: Option<Numbered<T>>,
    newest: Option<u64>,
    playout: Option<Buffered<T>>,
    /// Packets taken by the receiver.
    pub delivered: u64,
    /// Packets that came after a newer one was taken, together with one, or twice.
    pub dropped: u64,
}

/// The play-out buffer, in ticks: the sender's at which a packet was sent, the receiver's at which it came.
#[derive(Clone, Debug)]
struct Buffered<T> {
    playout: Playout<T>,
    /// What has come since the receiver looked last, and when, ns.
    came: Vec<(u64, Numbered<T>)>,
    tick_ns: u64,
    ticks_per_packet: u32,
    /// The receiver's clock, ticks.
    local: u32,
}

impl<T> Buffered<T> {
    fn take(&mut self, now_ns: u64, dropped: &mut u64) -> Option<T> {
        for (came_ns, packet) in self.came.drain(..) {
            let ago = now_ns.saturating_sub(came_ns).div_ceil(self.tick_ns) as u32;
            let sent = (packet.number as u32).wrapping_mul(self.ticks_per_packet);
            let kept = self.playout.put(self.local.wrapping_sub(ago), sent, packet.what);
            *dropped += u64::from(!kept);
        }
        let before = self.playout.waiting();
        let played = self.playout.take(self.local);
        self.local = self.local.wrapping_add(self.ticks_per_packet);
        *dropped += (before - self.playout.waiting()) as u64 - u64::from(played.is_some());
        played
    }
}

impl<T> Inbox<T> {
    /// As the scene asks for.
    pub fn new(scene: &Scene) -> Self {
        let (depth, timing) = (scene.world.network.playout_packets, &scene.peer.timing);
        let buffered = || Buffered {
            playout: Playout::new(depth, timing.ticks_per_packet),
            came: Vec::new(),
            tick_ns: timing.control_period_ns(),
            ticks_per_packet: timing.ticks_per_packet,
            local: 0,
        };
        Self { waiting: None, newest: None, playout: (depth > 0).then(buffered), delivered: 0, dropped: 0 }
    }

    /// Takes a packet that came at `now_ns`.
    #[inline]
    pub fn put(&mut self, now_ns: u64, packet: Numbered<T>) {
        if let Some(buffered) = &mut self.playout {
            buffered.came.push((now_ns, packet));
        } else if self.newest.is_none_or(|newest| packet.number > newest) {
            self.newest = Some(packet.number);
            // One that waited until now is overtaken after all.
            self.dropped += u64::from(self.waiting.replace(packet).is_some());
        } else {
            self.dropped += 1;
        }
    }

    /// What the receiver takes at `now_ns`.
    #[inline]
    pub fn take(&mut self, now_ns: u64) -> Option<T> {
        let taken = match &mut self.playout {
            Some(buffered) => buffered.take(now_ns, &mut self.dropped),
            None => self.waiting.take().map(|packet| packet.what),
        };
        self.delivered += u64::from(taken.is_some());
        taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Packets of 8 ms, and a receiver that looks as often.
    struct Line {
        link: Link<Numbered<u64>>,
        inbox: Inbox<u64>,
    }

    fn scene(overrides: &[&str]) -> Scene {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        Scene::load(crate::Laws::built_in(), None, &overrides).expect("a good scene")
    }

    fn line(overrides: &[&str]) -> Line {
        let scene = scene(overrides);
        Line { link: Link::new(Route::of_scene(&scene, Direction::OneToTwo, 0)), inbox: Inbox::new(&scene) }
    }

    /// One packet period in which both ends are on time.
    fn period(Line { link, inbox }: &mut Line, number: u64) -> Option<u64> {
        let now_ns = 8_000_000 * number;
        link.send(now_ns, &Numbered { number, what: number });
        while let Some((due_ns, packet)) = link.take(now_ns) {
            inbox.put(due_ns, packet);
        }
        inbox.take(now_ns)
    }

    #[test]
    fn without_impairment_every_packet_arrives_after_the_delay() {
        for delay in [0_u64, 1, 5] {
            let mut line = line(&[&format!("network.one_way_delay_packets={delay}")]);
            for number in 0..50_u64 {
                assert_eq!(period(&mut line, number), number.checked_sub(delay));
            }
        }
    }

    #[test]
    fn losses_come_as_often_and_in_runs_as_long_as_the_scene_says() {
        for (loss, burst) in [(0.2, 1.0), (0.1, 5.0), (0.5, 20.0)] {
            let mut line = line(&[
                "network.one_way_delay_packets=0",
                &format!("network.loss={loss}"),
                &format!("network.loss_burst_packets={burst}"),
            ]);
            let got: Vec<bool> = (0..200_000).map(|number| period(&mut line, number).is_some()).collect();
            let lost = got.iter().filter(|got| !**got).count() as f64;
            let runs = got.windows(2).filter(|pair| pair[0] && !pair[1]).count() as f64;
            assert!((lost / 200_000.0 - loss).abs() < 0.02, "{lost} lost at {loss}");
            // Independent losses come in runs of 1/(1 − p).
            let expected = if burst == 1.0 { 1.0 / (1.0 - loss) } else { burst };
            assert!((lost / runs / expected - 1.0).abs() < 0.1, "runs of {} for {expected}", lost / runs);
        }
    }

    #[test]
    fn whatever_happens_on_the_way_numbers_only_grow() {
        let mut line = line(&[
            "network.jitter=gamma",
            "network.jitter_s=0.012",
            "network.reorder=0.3",
            "network.reorder_depth_packets=16",
            "network.duplicate=0.2",
            "network.corrupt=0.1",
            "network.loss=0.1",
        ]);
        let mut last = None;
        for sent in 0..20_000 {
            if let Some(number) = period(&mut line, sent) {
                assert!(last.is_none_or(|last| number > last), "{number} after {last:?}");
                last = Some(number);
            }
        }
        let (counts, Inbox { delivered, dropped, .. }) = (line.link.counts(), line.inbox);
        assert!(counts.corrupt > 1000 && counts.lost > 1000, "{counts:?}");
        assert!(dropped > 1000 && delivered > 5000, "{dropped} dropped, {delivered} delivered");
    }

    #[test]
    fn play_out_makes_the_delay_constant() {
        let mut line = line(&["network.jitter=uniform", "network.jitter_s=0.012", "network.playout_packets=2"]);
        // Once the fastest has been seen.
        for number in 0..5000_u64 {
            let played = period(&mut line, number);
            assert!(number < 200 || played == number.checked_sub(3), "{played:?} in period {number}");
        }
        // Uniform to 12 ms is never later than two packets of 8 ms.
        let (counts, Inbox { delivered, dropped, .. }) = (line.link.counts(), line.inbox);
        assert!(delivered > 4_980 && dropped < 10 && counts.lost == 0, "{counts:?}, {delivered}, {dropped}");
    }

    /// Without impairment the fastest is known from the start, and every packet waits exactly as long as it was told to.
    #[test]
    fn play_out_on_a_good_network_is_more_delay_and_nothing_else() {
        let mut line = line(&["network.one_way_delay_packets=2", "network.playout_packets=4"]);
        for number in 0..500_u64 {
            assert_eq!(period(&mut line, number), number.checked_sub(6));
        }
    }

    fn datagrams(overrides: &[&str]) -> Link<[u8]> {
        Link::new(Route::of_scene(&scene(overrides), Direction::OneToTwo, 0))
    }

    #[test]
    fn every_datagram_comes_out_after_the_delay_in_the_order_it_went_in() {
        let mut line = datagrams(&["network.one_way_delay_packets=2"]);
        for n in 0..5_u8 {
            line.send(1_000_000 * u64::from(n), &[n]);
            line.send(1_000_000 * u64::from(n), &[n, n]);
        }
        let due_ns = 16_000_000;
        assert_eq!(line.take(due_ns - 1), None);
        assert_eq!([(); 3].map(|()| line.take(due_ns)), [Some((due_ns, vec![0])), Some((due_ns, vec![0, 0])), None]);
        assert_eq!(std::iter::from_fn(|| line.take(20_000_000)).count(), 8);
        assert_eq!(line.counts(), Counts { taken: 10, sent: 10, ..Counts::default() });
    }

    #[test]
    fn what_is_lost_never_comes_and_what_is_broken_differs_in_one_bit() {
        let mut line = datagrams(&["network.loss=0.3", "network.corrupt=0.2"]);
        for n in 0..10_000 {
            line.send(n, &[0; 60]);
        }
        let came: Vec<Vec<u8>> = std::iter::from_fn(|| line.take(u64::MAX)).map(|(_, bytes)| bytes).collect();
        let counts = line.counts();
        let flipped = |bytes: &Vec<u8>| bytes.iter().map(|byte| byte.count_ones()).sum::<u32>();
        assert!(came.iter().all(|bytes| bytes.len() == 60 && flipped(bytes) <= 1));
        assert_eq!(came.iter().filter(|bytes| flipped(bytes) == 1).count() as u64, counts.corrupt);
        assert_eq!((counts.taken, counts.sent, came.len() as u64), (10_000, 10_000 - counts.lost, counts.sent));
        assert!(counts.lost.abs_diff(3_000) < 200 && counts.corrupt.abs_diff(1_400) < 200, "{counts:?}");
    }
}
