//! What a board's records say to the list of tests/rig, wherever they come from.

use cohold_core::device::encoder::Counts;
use cohold_core::names::MotorDrive;
use cohold_core::safety::Mode;
use cohold_rig::run::Came;
use firmware_parts::record::Record;

use crate::twin::replay_alone;

/// What the converter read for both currents, in codes from the middle.
pub(super) fn codes(records: &[Record]) -> [Vec<i16>; 2] {
    let stages = records.iter().filter_map(Record::stage);
    let codes = stages.map(|stage| stage.motors.map(|flow| flow.last)).collect::<Vec<_>>();
    [0, 1].map(|input| codes.iter().map(|codes| codes[input]).collect())
}

/// Adds what came.
pub(super) fn came(records: &[Record], came: &mut Came) {
    for record in records {
        let tick = record.tick();
        came.ticks += 1;
        came.unarmed += u64::from(record.mode() != Mode::Armed);
        if let Some(before) = came.last.replace(tick) {
            came.restarts += u64::from(tick <= before);
            came.missed += u64::from(tick.saturating_sub(before).saturating_sub(1));
        }
    }
}

/// The counters of both encoders in the last record.
pub(super) fn counts(records: &[Record]) -> Result<[u16; 2], String> {
    let last = records.last().ok_or("the board streams no ticks")?;
    Ok(last.counts().map(|Counts(counts)| counts))
}

/// Of the records since a board of default settings, but with amplifiers and at this rate, was armed last: how many are what the simulator makes of their inputs, of
/// how many.
pub(super) fn same(records: &[Record], per_ms: u32) -> [u64; 2] {
    let armed = |record: &Record| record.mode() == Mode::Armed;
    let end = records.iter().rposition(armed).map_or(0, |last| last + 1);
    let begin = records[..end].iter().rposition(|record| !armed(record)).map_or(0, |last| last + 1);
    let mut settings = firmware_parts::kept::defaults();
    settings.motor.drive = MotorDrive::Amplifier;
    settings.timing.control_period_s = 1e-3 / f64::from(per_ms);
    [replay_alone(&settings, &records[begin..end]).ticks, (end - begin) as u64]
}
