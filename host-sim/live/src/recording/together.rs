//! Two recordings as one, on the first one's clock: what both ends recorded, and the true discrepancy beside it.
//!
//! Programs that show recordings order rows by the time at which they were recorded: that of the second end's rows is what the first
//! end's clock showed. Times inside its rows stay those of its own clock.

use std::path::Path;

use super::file::{Recording, Rows};
use super::mcap::{Channel, LOG};
use super::merge::{Merged, columns, on_the_first_clock};
use super::origin::Origin;
use super::recorder::{Ended, Recorder};
use crate::Error;

/// Topic of the table of every instant.
const BOTH: &str = "/both/ticks";

/// Writes both, and what [`super::merge::merge`] made of them, to a file that is not there yet.
///
/// # Errors
/// The clocks cannot be brought together, or the file exists or cannot be written.
pub fn write<'a>(
    path: &Path,
    [one, two]: [&'a Recording; 2],
    hub: Option<&Recording>,
    merged: &Merged,
) -> Result<Ended, Error> {
    let on_the_first = on_the_first_clock(one, two, hub)?;
    let of = |recording: &'a Recording| recording.channels.iter().filter(|rows| rows.row != LOG);
    let rows = || of(one).chain(of(two));
    let mut channels: Vec<Channel> = rows().map(Rows::channel).collect();
    let instants = channels.len();
    channels.push(Channel::new(BOTH, "Instant", columns(merged.axes)));
    // When each was recorded, ns of the first clock; then its channel and its row.
    let since = |recording: &Recording, unix_ns: u64| unix_ns as i64 - recording.origin.start_unix_ns as i64;
    let second = |unix_ns: u64| (1e9 * on_the_first(1e-9 * since(two, unix_ns) as f64)).round() as i64;
    let mut order: Vec<(i64, usize, usize)> = Vec::new();
    let at_ns = |own: bool, unix_ns: u64| if own { since(one, unix_ns) } else { second(unix_ns) };
    for (channel, rows) in rows().enumerate() {
        let own = channel < of(one).count();
        order.extend(rows.times_ns.iter().enumerate().map(|(row, unix_ns)| (at_ns(own, *unix_ns), channel, row)));
    }
    let times_s = merged.table.column("time_s").unwrap_or_default();
    order.extend(times_s.iter().enumerate().map(|(row, time_s)| ((1e9 * time_s).round() as i64, instants, row)));
    order.sort_unstable();
    // What the second recorded before the first one's clock began.
    let before_ns = order.first().map_or(0, |first| first.0.min(0).unsigned_abs());
    let origin = Origin {
        who: format!("{} and {}", merged.ends[0], merged.ends[1]),
        start_unix_ns: one.origin.start_unix_ns.saturating_sub(before_ns),
        start_clock_ns: one.origin.start_clock_ns.saturating_sub(before_ns),
        ..one.origin.clone()
    };
    let recorder = Recorder::create(path, &origin, channels)?;
    let all: Vec<&Rows> = rows().collect();
    let table: Vec<&[f64]> = columns(merged.axes).filter_map(|(name, _)| merged.table.column(&name)).collect();
    for (at_ns, channel, row) in order {
        let values: Vec<f64> = match all.get(channel) {
            Some(rows) => rows.values(row).collect(),
            None => table.iter().map(|column| column[row]).collect(),
        };
        recorder.put_all(channel as u16, at_ns.saturating_add_unsigned(before_ns) as u64, &values);
    }
    for (recording, own) in [(one, true), (two, false)] {
        for (unix_ns, line) in recording.log() {
            let at_ns = at_ns(own, unix_ns).saturating_add_unsigned(before_ns);
            recorder.log_line(at_ns.max(0) as u64, line.clone());
        }
    }
    Ok(recorder.finish())
}
