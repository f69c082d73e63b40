//! A timer with a quadrature encoder on its two pins.
//!
//! The emulator's timer does the counting, filter included; this puts the edges on its inputs, one after the other, so
//! that the filter sees pulses of a real length. Gray code: two channels a quarter period apart, four edges a period.
//!
//! Faults of an encoder: stuck (edges are swallowed), reversed (the other way round), jumped (a burst of edges).

use std::collections::VecDeque;

use rigless::device::{Device, DeviceContext, InterruptChange, Level, RegisterFile, RequestChange};
use rigless::soc::RegisterSpec;
use rigless::soc::stm32h743::peripherals::tim::{Channel, General, TIMERS, Tim};
use rigless::time::{EventId, VirtualNanos};

type Inner = Tim<General>;
type Register = <Inner as Device>::Register;

/// Time over which a move's edges are spread, ns: within half of the shortest control period, after which the tick reads them.
const SPREAD_NS: u64 = 80_000;
/// Two edges are never closer, ns.
const CLOSEST_NS: u64 = 150;

/// The timer and what its encoder still has to do.
#[derive(Debug)]
pub struct EncoderTimer {
    timer: Inner,
    /// Where the encoder is, counts.
    position: i64,
    /// Directions of the edges to come.
    pending: VecDeque<i64>,
    every_ns: u64,
    next: Option<EventId>,
    /// Edges that are left when the index comes, and whether it is there.
    index: Option<usize>,
    at_index: bool,
    /// Levels that the timer's inputs are to take, each at an instant (ns), and the event of the next.
    played: VecDeque<(u64, Channel, Level)>,
    playing: Option<EventId>,
}

impl EncoderTimer {
    /// The encoder on the `nth` of [`TIMERS`], at 0.
    pub fn new(nth: usize) -> Self {
        Self {
            timer: Inner::new(TIMERS[nth]),
            position: 0,
            pending: VecDeque::new(),
            every_ns: 0,
            next: None,
            index: None,
            at_index: false,
            played: VecDeque::new(),
            playing: None,
        }
    }

    /// A channel's input takes a level at an instant (ns), or as soon after as the one before it does.
    pub fn play(&mut self, at: u64, channel: u8, level: Level, context: &mut DeviceContext<'_>) {
        let at = self.played.back().map_or(at, |(before, ..)| at.max(*before));
        self.played.push_back((at, Channel::new(channel).expect("a channel of the timer"), level));
        if self.playing.is_none() {
            self.playing = Some(context.schedule(VirtualNanos(at.max(context.now().0))));
        }
    }

    fn played(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        while let Some((_, channel, level)) = self.played.pop_front_if(|(at, ..)| *at <= context.now().0) {
            self.timer.drive_input(channel, level, registers, context);
        }
        self.playing = self.played.front().map(|(at, ..)| context.schedule(VirtualNanos(*at)));
    }

    /// Where the encoder will be once all its edges are out, counts.
    pub fn target(&self) -> i64 {
        self.position + self.pending.iter().sum::<i64>()
    }

    /// Turns the encoder to `counts`, starting now.
    pub fn turn(&mut self, counts: i64, context: &mut DeviceContext<'_>) {
        self.turn_within(counts, SPREAD_NS, context);
    }

    /// [`EncoderTimer::turn`] within another time, ns.
    pub fn turn_within(&mut self, counts: i64, spread_ns: u64, context: &mut DeviceContext<'_>) {
        let remaining = counts - self.target();
        if remaining == 0 {
            return;
        }
        self.pending.extend(std::iter::repeat_n(remaining.signum(), remaining.unsigned_abs() as usize));
        self.every_ns = (spread_ns / self.pending.len() as u64).max(CLOSEST_NS);
        if self.next.is_none() {
            self.schedule(context);
        }
    }

    /// On the way the counter's 16 bits pass this index, if any.
    pub fn pass(&mut self, index: Option<u16>) {
        self.index =
            index.map(|index| usize::from((self.target() as u16).wrapping_sub(index).cast_signed().unsigned_abs()));
    }

    fn schedule(&mut self, context: &mut DeviceContext<'_>) {
        self.next = Some(context.schedule(VirtualNanos(context.now().0 + self.every_ns)));
    }

    /// After a reset, of the chip or of the timer alone, which dropped our events: the encoder is where it was going.
    fn settle(&mut self) {
        self.position = self.target();
        self.pending.clear();
        self.next = None;
        self.played.clear();
        self.playing = None;
    }

    fn levels(position: i64) -> [Level; 2] {
        let level = |high| if high { Level::High } else { Level::Low };
        let phase = position.rem_euclid(4);
        [level(phase == 1 || phase == 2), level(phase >= 2)]
    }

    fn edge(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let Some(step) = self.pending.pop_front() else { return };
        let before = Self::levels(self.position);
        self.position += step;
        // Channel 3 is where the index goes; it is there for one count.
        let at_index = self.index.take_if(|left| self.pending.len() <= *left).is_some();
        if at_index != core::mem::replace(&mut self.at_index, at_index) {
            let (third, level) =
                (Channel::new(3).expect("four channels"), if at_index { Level::High } else { Level::Low });
            self.timer.drive_input(third, level, registers, context);
        }
        for (nth, (before, now)) in (1..).zip(before.into_iter().zip(Self::levels(self.position))) {
            if before != now {
                let channel = Channel::new(nth).expect("timers have channels 1 and 2");
                self.timer.drive_input(channel, now, registers, context);
            }
        }
    }
}

/// All the timer's own, but for our events.
impl Device for EncoderTimer {
    type Register = Register;

    fn layout(&self) -> &'static [RegisterSpec] {
        Device::layout(&self.timer)
    }
    fn read(&mut self, r: Register, f: &mut RegisterFile, c: &mut DeviceContext<'_>) -> Option<u64> {
        Device::read(&mut self.timer, r, f, c)
    }
    fn peek(&self, r: Register, f: &RegisterFile, now: VirtualNanos) -> Option<u64> {
        Device::peek(&self.timer, r, f, now)
    }
    fn write(&mut self, r: Register, v: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        Device::write(&mut self.timer, r, v, f, c);
    }
    fn on_event(&mut self, event: EventId, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        if self.next == Some(event) {
            self.next = None;
            self.edge(f, c);
            if !self.pending.is_empty() {
                self.schedule(c);
            }
        } else if self.playing == Some(event) {
            self.played(f, c);
        } else {
            Device::on_event(&mut self.timer, event, f, c);
        }
    }
    fn on_request(&mut self, change: RequestChange, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        Device::on_request(&mut self.timer, change, f, c);
    }
    fn on_interrupt(&mut self, change: InterruptChange, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        Device::on_interrupt(&mut self.timer, change, f, c);
    }
    fn on_clock_input(&mut self, input: usize, hz: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        Device::on_clock_input(&mut self.timer, input, hz, f, c);
    }
    fn on_access(&mut self, token: u64, value: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        Device::on_access(&mut self.timer, token, value, f, c);
    }
    fn reset(&mut self) {
        Device::reset(&mut self.timer);
        self.settle();
    }
    fn reset_line(&mut self, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        Device::reset_line(&mut self.timer, f, c);
        self.settle();
    }
}
