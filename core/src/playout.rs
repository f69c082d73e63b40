//! Play-out: makes the delay constant, by letting what came early wait for what comes late.
//!
//! Flow carries its sender's tick. What arrives `now` and was sent at tick t took `now − t`, up to the unknown and constant
//! difference of the two clocks; the least that any packet took is the **anchor**. Each packet is played at
//! `t + anchor + depth`: all of them equally late, as long as none is later than the fastest one by more than the depth. One
//! that is later is played at once if nothing newer was.
//!
//! **Drift.** Clocks run apart, and paths change. A packet that is faster than the anchor moves it at once. Where the
//! fastest of [`WINDOW`] packets is slower than the anchor by more than a quarter of a packet period, the anchor moves there;
//! less is left alone, so that jitter does not push it about. Where [`RUN`] packets in a row come too late, it moves to
//! their fastest. In between the delay is constant to the tick.
//!
//! **Units**: control periods, each peer's own, in counts that wrap. **Bounded**: [`MOST`] packets; when more wait, the oldest
//! goes. Total: any tick may come at any time. **Cost**: the depth, on top of the fastest packet's delay.

/// Packets that wait at the most: a depth of half as many packet periods leaves as much for jitter.
pub const MOST: usize = 64;
/// Packets over which the fastest is looked for.
pub const WINDOW: u32 = 64;
/// Packets in a row, all too late, that are a new path and no accident.
pub const RUN: u32 = 8;

/// Packets that wait to be played.
#[derive(Clone, Debug)]
pub struct Playout<P> {
    /// Ticks that every packet waits, if it was as fast as the fastest.
    depth: u32,
    /// What the anchor may be off by before it moves up, ticks.
    slack: u32,
    /// Tick of the sender and packet, in no order.
    waiting: [Option<(u32, P)>; MOST],
    /// The least that a packet took, in ticks and up to the difference of the clocks.
    anchor: Option<u32>,
    /// All packets of late.
    window: Fastest,
    /// Packets that came too late, since one that did not.
    run: Fastest,
    /// Sender's tick of the newest packet played.
    played: Option<u32>,
}

/// Some packets: how many, and the least by which one was slower than the anchor, ticks.
#[derive(Clone, Copy, Debug)]
struct Fastest {
    count: u32,
    least: u32,
}

impl Fastest {
    const NONE: Self = Self { count: 0, least: u32::MAX };

    /// With one more: the least, once there are `enough`.
    fn with(&mut self, slower: u32, enough: u32) -> Option<u32> {
        *self = Self { count: self.count.saturating_add(1), least: self.least.min(slower) };
        (self.count >= enough).then_some(self.least)
    }
}

/// Whether tick `a` is after tick `b`, in a count that wraps.
fn after(a: u32, b: u32) -> bool {
    (a.wrapping_sub(b) as i32) > 0
}

impl<P> Playout<P> {
    /// An empty buffer; packets come every `ticks_per_packet` and wait for `depth_packets` times that.
    pub fn new(depth_packets: u32, ticks_per_packet: u32) -> Self {
        Self {
            depth: depth_packets.saturating_mul(ticks_per_packet).min(i32::MAX as u32 / 2),
            slack: ticks_per_packet / 4,
            waiting: [const { None }; MOST],
            anchor: None,
            window: Fastest::NONE,
            run: Fastest::NONE,
            played: None,
        }
    }

    /// Forgets everything: the other peer has started anew.
    pub fn clear(&mut self) {
        let Self { depth, slack, .. } = *self;
        *self = Self { depth, slack, ..Self::new(0, 0) };
    }

    /// Takes a packet that was sent at `tick` on its sender's clock and came `now` on this one's; false if it is too old
    /// to be played or to be kept, or a copy.
    pub fn put(&mut self, now: u32, tick: u32, packet: P) -> bool {
        self.measure(now.wrapping_sub(tick));
        let old = self.played.is_some_and(|played| !after(tick, played));
        if old || self.ticks().any(|(_, waiting)| waiting == tick) {
            return false;
        }
        let free = self.waiting.iter().position(Option::is_none).or_else(|| self.oldest_before(tick));
        let Some(place) = free.and_then(|at| self.waiting.get_mut(at)) else { return false };
        *place = Some((tick, packet));
        true
    }

    /// Moves the anchor, if a packet that took `took` is a reason to.
    fn measure(&mut self, took: u32) {
        let anchor = *self.anchor.get_or_insert(took);
        if after(anchor, took) {
            return self.move_to(took);
        }
        let slower = took.wrapping_sub(anchor);
        if slower <= self.depth {
            self.run = Fastest::NONE;
        } else if let Some(least) = self.run.with(slower, RUN) {
            return self.move_to(anchor.wrapping_add(least));
        }
        if let Some(least) = self.window.with(slower, WINDOW) {
            self.move_to(anchor.wrapping_add(if least > self.slack { least } else { 0 }));
        }
    }

    fn move_to(&mut self, anchor: u32) {
        self.anchor = Some(anchor);
        self.window = Fastest::NONE;
        self.run = Fastest::NONE;
    }

    /// The newest packet whose time has come `now`; older ones are dropped.
    pub fn take(&mut self, now: u32) -> Option<P> {
        let late = self.anchor?.wrapping_add(self.depth);
        let due = self.ticks().filter(|(_, tick)| !after(tick.wrapping_add(late), now));
        let (at, newest) = due.reduce(|newest, tick| if after(tick.1, newest.1) { tick } else { newest })?;
        self.played = Some(newest);
        let packet = self.waiting.get_mut(at)?.take();
        for place in &mut self.waiting {
            place.take_if(|(tick, _)| !after(*tick, newest));
        }
        packet.map(|(_, packet)| packet)
    }

    /// Number of packets in the buffer.
    pub fn waiting(&self) -> usize {
        self.ticks().count()
    }

    /// Places and ticks of the packets in the buffer.
    fn ticks(&self) -> impl Iterator<Item = (usize, u32)> {
        self.waiting.iter().enumerate().filter_map(|(at, place)| place.as_ref().map(|(tick, _)| (at, *tick)))
    }

    /// Place of the oldest packet that waits, unless it was sent after `tick`.
    fn oldest_before(&self, tick: u32) -> Option<usize> {
        let older = self.ticks().filter(|(_, waiting)| after(tick, *waiting));
        older.reduce(|oldest, other| if after(oldest.1, other.1) { other } else { oldest }).map(|(at, _)| at)
    }
}
