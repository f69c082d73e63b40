//! Telemetry: what the ticks did, to the operator who asked for it: a decimated stream, so many ticks in a row, or those before a fault.
//!
//! After every tick the bell takes its records: they go to a reel, whether anybody asked or not ([`firmware_parts::recorder`]),
//! and those that were asked for to the task.
//!
//! A record ([`firmware_parts::record`]) is a sample on the operator's link ([`crate::port`]), oldest first. One that finds no
//! room is lost; whoever misses it sees it by the ticks' numbers. Events go to defmt, from tasks only.

use core::mem::MaybeUninit;

use cohold_core::safety::Mode;
use cohold_protocol::wire::Sample;
use firmware_parts::exchange::{Consumer, Producer, Reader, Writer};
use firmware_parts::image::SHARED;
use firmware_parts::record::{self, PERIODS_IN_ONE, Period, Record};
use firmware_parts::{recorder::Reel, signals::Signals};

use crate::board::{current, pace};
use crate::tick;

const _: () = assert!(record::BYTES <= Sample::MAX_PAYLOAD);

/// Records to go when there is no end to them.
const ENDLESS: u32 = u32::MAX;

/// Records that may wait for the task: of every tick at 1 kHz 64 ms with one shared axis and 42 ms with three, at 4 kHz a quarter of that.
pub(crate) const RECORDS: usize = if SHARED == 1 { 64 } else { 128 };

/// What the bell does with records.
pub(crate) struct Recorder {
    pub(crate) from: Consumer<'static, Record, { tick::RECORDS }>,
    pub(crate) reels: Writer<'static, &'static mut Reel>,
    pub(crate) to: Producer<'static, Record, RECORDS>,
    pub(crate) signals: &'static Signals,
    /// The tick at hand is to be told; ticks until the next that is.
    pub(crate) asked: bool,
    pub(crate) until: u32,
    /// The motors were on, or a probe moved them, at the end of the tick before.
    pub(crate) on: bool,
}

static mut RECORDER: MaybeUninit<Recorder> = MaybeUninit::uninit();

/// Hands the bell its side; call once, before the first tick.
pub(crate) fn prepare(recorder: Recorder) {
    // SAFETY: the interrupt that uses RECORDER is not enabled yet, and no other task prepares it.
    unsafe {
        let place = &raw mut RECORDER;
        (*place).write(recorder)
    };
}

/// UART8 is not used as such; its interrupt is the bell.
#[unsafe(no_mangle)]
extern "C" fn UART8() {
    pace::after_tick();
    // SAFETY: `prepare` ran before the bell could ring, and nothing but the bell touches RECORDER.
    let this = unsafe {
        let place = &raw mut RECORDER;
        (*place).assume_init_mut()
    };
    while let Some(record) = this.from.take() {
        this.see(&record);
    }
}

impl Recorder {
    fn see(&mut self, record: &Record) {
        let (first, last) = (record.axis() == 0, usize::from(record.axis()) == SHARED - 1);
        let over = last && self.on && matches!(record.mode(), Mode::Faulted(_));
        if last {
            self.on = matches!(record.mode(), Mode::Armed | Mode::Probing);
        }
        let mut next = 0;
        self.reels.fill(|reel| {
            reel.write(record);
            next = if over { reel.stand() } else { 0 };
            over
        });
        if over {
            self.reels.fill(|reel| {
                reel.begin(next);
                false
            });
        }
        let every = self.signals.record_every.get();
        if first {
            self.asked = every > 0 && self.until == 0;
            self.until = if self.asked { every - 1 } else { self.until.saturating_sub(1).min(every) };
        }
        if self.asked {
            // Without room it is lost, as above.
            let _ = self.to.put(|place| *place = *record);
        }
    }
}

pub(crate) struct Telemetry {
    records: Consumer<'static, Record, RECORDS>,
    reels: Reader<'static, &'static mut Reel>,
    signals: &'static Signals,
    /// How many are still to go; [`ENDLESS`] unless a number was asked for.
    left: u32,
    /// Of the records only those from the first on that has such a flag; 0 is all of them.
    at: u8,
    /// Records of the reel and PWM periods that were told, of so many.
    told: [(usize, usize); 2],
}

impl Telemetry {
    /// Of these records, none until asked for.
    pub(crate) fn new(
        records: Consumer<'static, Record, RECORDS>,
        reels: Reader<'static, &'static mut Reel>,
        signals: &'static Signals,
    ) -> Self {
        Self { records, reels, signals, left: 0, at: 0, told: [(0, 0); 2] }
    }

    /// Every `every`-th tick from now on; 0 ends it.
    pub(crate) fn stream(&mut self, every: u32) {
        self.left = if every > 0 { ENDLESS } else { 0 };
        (self.at, self.told) = (0, [(0, 0); 2]);
        self.signals.record_every.set(every);
    }

    /// The next `ticks` ticks, every one, from the first on that has the flag `at`.
    pub(crate) fn capture(&mut self, ticks: u32, at: u8) {
        self.stream(u32::from(ticks > 0));
        self.left = ticks.saturating_mul(SHARED as u32);
        self.at = at;
    }

    /// The ticks before the last fault, and the last PWM periods; gives how many of either.
    pub(crate) fn blackbox(&mut self) -> (usize, usize) {
        self.stream(0);
        self.reels.fetch();
        let records = self.reels.get().count();
        let periods = if records > 0 { current::TOLD as usize } else { 0 };
        self.told = [(0, records), (0, periods)];
        (records / SHARED, periods)
    }

    pub(crate) fn is_on(&self) -> bool {
        self.left > 0 || self.told.iter().any(|(told, of)| told < of)
    }

    /// The next record, if there is one and somebody wants it.
    pub(crate) fn next(&mut self) -> Option<Sample> {
        if self.left == 0 {
            while self.records.take().is_some() {}
            return self.kept();
        }
        let record = self.records.take()?;
        if self.at > 0 && record.flags() & self.at == 0 {
            return None;
        }
        self.at = 0;
        if self.left != ENDLESS {
            self.left -= 1;
            if self.left == 0 {
                self.stream(0);
            }
        }
        sample(&record)
    }

    /// What was kept of the last fault: records first, then PWM periods.
    fn kept(&mut self) -> Option<Sample> {
        let [records, periods] = &mut self.told;
        if records.0 < records.1 {
            records.0 += 1;
            return self.reels.get().get(records.0 - 1).and_then(sample);
        }
        if periods.0 >= periods.1 {
            return None;
        }
        let first = current::runs().wrapping_sub((periods.1 - periods.0) as u32).wrapping_add(1);
        periods.0 += PERIODS_IN_ONE;
        let mut payload = [0; 4 + PERIODS_IN_ONE * Period::BYTES];
        let (number, rest) = payload.split_first_chunk_mut()?;
        *number = first.to_le_bytes();
        for (nth, place) in (0..).zip(rest.as_chunks_mut().0) {
            *place = current::period(first.wrapping_add(nth)).bytes();
        }
        Sample::new(record::PERIODS, &payload).ok()
    }
}

fn sample(record: &Record) -> Option<Sample> {
    Sample::new(record::CODE + u16::from(record.axis()), &record.bytes()).ok()
}
