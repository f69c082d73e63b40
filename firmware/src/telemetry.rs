//! Telemetry: what the ticks did, to the operator who asked for it: a decimated stream, or so many ticks in a row.
//!
//! A record ([`firmware_parts::record`]) is a sample on the operator's link ([`crate::port`]), oldest first. Whoever misses one
//! sees it by the ticks' numbers. Events go to defmt, from tasks only.

use core::sync::atomic::{AtomicU32, Ordering};

use firmware_parts::exchange::Consumer;
use firmware_parts::record::{self, Record};
use haptic_protocol::wire::Sample;

use crate::tick::{RECORD_EVERY, RECORDS};

const _: () = assert!(record::BYTES <= Sample::MAX_PAYLOAD);

/// How many records are still to go; [`ENDLESS`] until told otherwise.
static LEFT: AtomicU32 = AtomicU32::new(0);
const ENDLESS: u32 = u32::MAX;

/// Every `every`-th tick from now on; 0 ends it.
pub(crate) fn stream(every: u32) {
    LEFT.store(if every > 0 { ENDLESS } else { 0 }, Ordering::Relaxed);
    RECORD_EVERY.store(every, Ordering::Relaxed);
}

/// The next `ticks` ticks, every one.
pub(crate) fn capture(ticks: u32) {
    LEFT.store(ticks, Ordering::Relaxed);
    RECORD_EVERY.store(u32::from(ticks > 0), Ordering::Relaxed);
}

/// The records that wait to be sent.
pub(crate) struct Telemetry {
    records: Consumer<'static, Record, RECORDS>,
}

impl Telemetry {
    /// Of these records.
    pub(crate) fn new(records: Consumer<'static, Record, RECORDS>) -> Self {
        Self { records }
    }

    /// Whether somebody wants any.
    pub(crate) fn is_on(&self) -> bool {
        LEFT.load(Ordering::Relaxed) > 0
    }

    /// The next record, if there is one and somebody wants it.
    pub(crate) fn next(&mut self) -> Option<Sample> {
        let left = LEFT.load(Ordering::Relaxed);
        if left == 0 {
            while self.records.take().is_some() {}
            return None;
        }
        let record = self.records.take()?;
        if left != ENDLESS {
            LEFT.store(left - 1, Ordering::Relaxed);
            if left == 1 {
                stream(0);
            }
        }
        Sample::new(record::CODE, &record.bytes()).ok()
    }
}
