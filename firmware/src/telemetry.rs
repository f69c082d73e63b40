//! Telemetry: what the ticks did, to the operator who asked for it: a decimated stream, or so many ticks in a row.
//!
//! A record ([`firmware_parts::record`]) is a sample on the operator's link ([`crate::port`]), oldest first. One that finds no
//! room is lost; whoever misses it sees it by the ticks' numbers. Events go to defmt, from tasks only.

use firmware_parts::image::SHARED;
use firmware_parts::record::{self, Record};
use firmware_parts::{exchange::Consumer, signals::Signals};
use haptic_protocol::wire::Sample;

use crate::tick::RECORDS;

const _: () = assert!(record::BYTES <= Sample::MAX_PAYLOAD);

/// Records to go when there is no end to them.
const ENDLESS: u32 = u32::MAX;

pub(crate) struct Telemetry {
    records: Consumer<'static, Record, RECORDS>,
    signals: &'static Signals,
    /// How many are still to go; [`ENDLESS`] unless a number was asked for.
    left: u32,
}

impl Telemetry {
    /// Of these records, none until asked for.
    pub(crate) fn new(records: Consumer<'static, Record, RECORDS>, signals: &'static Signals) -> Self {
        Self { records, signals, left: 0 }
    }

    /// Every `every`-th tick from now on; 0 ends it.
    pub(crate) fn stream(&mut self, every: u32) {
        self.left = if every > 0 { ENDLESS } else { 0 };
        self.signals.record_every.set(every);
    }

    /// The next `ticks` ticks, every one.
    pub(crate) fn capture(&mut self, ticks: u32) {
        self.left = ticks.saturating_mul(SHARED as u32);
        self.signals.record_every.set(u32::from(ticks > 0));
    }

    pub(crate) fn is_on(&self) -> bool {
        self.left > 0
    }

    /// The next record, if there is one and somebody wants it.
    pub(crate) fn next(&mut self) -> Option<Sample> {
        if self.left == 0 {
            while self.records.take().is_some() {}
            return None;
        }
        let record = self.records.take()?;
        if self.left != ENDLESS {
            self.left -= 1;
            if self.left == 0 {
                self.stream(0);
            }
        }
        Sample::new(record::CODE + u16::from(record.axis()), &record.bytes()).ok()
    }
}
