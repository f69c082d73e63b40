//! True discrepancy of two recordings: where both copies were at the same instants of a common clock, and what the clock's error
//! makes of it.
//!
//! **Whose clock.** Ticks of a peer are timed by the clock of the process that ran it, which is the recording's. Ticks of a board are
//! timed by the board: its tick counter, which runs evenly from when it was started; when that was on the board's clock, the seals
//! of its records tell, of which the quickest was sealed right after its tick. How the board's clock goes beside the operator's, the
//! exchanges between the two tell ([`Relation`]).
//!
//! **From one recording to the other** lead the exchanges of a session that both were ends of; without one, the steady clock of a
//! machine on which both were recorded, whose error is 0. A chain of clocks is as wrong as its links together.
//!
//! **At one instant**: for every tick of the first, the second's copy at that time, on the straight line between two ticks; or the
//! copy of one tick, where the clock cannot tell that it was another instant.

use std::collections::BTreeSet;

use haptic_report::Columns;
use haptic_sim::quantities::{self, Named};
use serde::Serialize;

use super::common_clock::{Exchange, Relation};
use super::file::Recording;
use super::origin::Origin;
use crate::Error;

/// A way from tick to tick that is so many times longer than usual is a gap: nothing is laid into it.
const GAP: f64 = 3.5;
/// More ticks back than a record can come late: the board has started anew.
const LATE_TICKS: f64 = 1000.0;
/// Two that are closer than this are one instant, s: what is left of a time that was added up.
const INSTANT_S: f64 = 1e-9;
/// What is armed, in a column of modes.
const ARMED: f64 = 1.0;

/// Columns of the table of every instant.
pub const COLUMNS: [Named; 5] = [
    ("time_s", "since the clock of the first recording began"),
    ("object_1_m", "position of the copy of the object in the first recording"),
    ("object_2_m", "position of the copy of the object in the second recording, at this instant"),
    quantities::TRUE_DISCREPANCY,
    ("clock_error_m", "what the clock's error may have made of it: speed of the copies times that"),
];

/// A copy at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    at_s: f64,
    position_m: f64,
    speed: f64,
}

/// One end as it was recorded.
#[derive(Debug)]
struct Side<'a> {
    origin: &'a Origin,
    /// The copy while it was armed, in order of time.
    places: Vec<Place>,
    /// The longest way between two of them that is no gap, s.
    longest_s: f64,
    /// How the clock that timed them goes beside the recording's; none where it is that one.
    board: Option<Relation>,
    /// Exchanges with the other end, and in which session each was.
    exchanges: Vec<(f64, Exchange)>,
}

/// What there is to say of two recordings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Merged {
    /// Names of the two ends that recorded.
    pub ends: [String; 2],
    /// Instants at which both copies are known and both peers were armed.
    pub instants: usize,
    /// From the first of them to the last, s.
    pub seconds: f64,
    /// Mean of |x_o1 − x_o2| over the last half, mm; root of the mean square and largest over all.
    pub true_discrepancy_mm: f64,
    /// Root of the mean square.
    pub rms_true_discrepancy_mm: f64,
    /// Largest true discrepancy, mm.
    pub largest_true_discrepancy_mm: f64,
    /// What the clock's error makes of it, speed of the copies times that: root of the mean square, and largest, mm.
    pub rms_clock_error_mm: f64,
    /// Largest discrepancy that the clock's error may make, mm.
    pub largest_clock_error_mm: f64,
    /// By how much the common clock may be wrong, at the most, µs.
    pub clock_error_us: f64,
    /// The second clock less the first, in the middle, µs, and how much faster it runs, ppm.
    pub clock_offset_us: f64,
    /// How much faster it runs.
    pub clock_drift_ppm: f64,
    /// How the two clocks were brought together.
    pub clock_by: String,
    /// The clocks' offset by the clock of the machine that both ran on, less this one, µs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub same_machine_less_this_us: Option<f64>,
    /// Every instant as a row.
    #[serde(skip)]
    pub table: Columns,
}

fn wrong(origin: &Origin, what: &str) -> String {
    format!("the recording of {} {what}", if origin.who.is_empty() { "nobody" } else { &origin.who })
}

impl<'a> Side<'a> {
    fn of(recording: &'a Recording) -> Result<Self, Error> {
        let origin = &recording.origin;
        let channel = |leaf: &str| recording.channels.iter().find(|rows| rows.topic.ends_with(leaf));
        let rows = channel("/ticks").ok_or_else(|| wrong(origin, "has no ticks of a peer or a board"))?;
        let column = |name: &str| rows.column(name).ok_or_else(|| wrong(origin, &format!("has no column {name}")));
        let (times, modes) = (column("time_s")?, column("mode")?);
        let (positions, speeds) = (column("object_m")?, column("object_m_per_s")?);
        let mut exchanges = Vec::new();
        if let Some(rows) = channel("/exchanges") {
            let get = |name: &str, at: usize| rows.column(name).map_or(f64::NAN, |values| values[at]);
            let one = |at: usize| {
                let times_s = ["sent_s", "there_s", "answered_s", "back_s"].map(|name| get(name, at));
                (get("session", at), Exchange { times_s })
            };
            exchanges = (0..rows.len()).map(one).collect();
        }
        let (mut starts, mut board) = (vec![0.0; times.len()], None);
        if let Some(sealed) = rows.column("sealed_s") {
            starts = starts_of(times, sealed, column("tick")?);
            let all: Vec<_> = exchanges.iter().map(|(_, exchange)| *exchange).collect();
            board = Some(Relation::of(&all).ok_or_else(|| wrong(origin, "has no exchange with the board's clock"))?);
        }
        let place = |at: usize| Place { at_s: starts[at] + times[at], position_m: positions[at], speed: speeds[at] };
        let mut places: Vec<_> = (0..times.len()).filter(|at| modes[*at] == ARMED).map(place).collect();
        places.sort_by(|one, other| one.at_s.total_cmp(&other.at_s));
        let mut intervals_s: Vec<f64> = places.windows(2).map(|two| two[1].at_s - two[0].at_s).collect();
        intervals_s.sort_by(f64::total_cmp);
        let longest_s = GAP * intervals_s.get(intervals_s.len() / 2).copied().unwrap_or(0.0);
        Ok(Self { origin, places, longest_s, board, exchanges })
    }

    /// What the recording's clock showed when the one that timed its ticks showed this, and by how much that may be wrong, s.
    fn recorded(&self, at_s: f64) -> (f64, f64) {
        self.board.as_ref().map_or((at_s, 0.0), |board| {
            let own_s = board.own_s(at_s);
            (own_s, board.error_s(own_s))
        })
    }

    /// The other way round.
    fn timed(&self, recorded_s: f64) -> (f64, f64) {
        self.board
            .as_ref()
            .map_or((recorded_s, 0.0), |board| (recorded_s + board.offset_s(recorded_s), board.error_s(recorded_s)))
    }

    /// Where the copy was, and how fast it was at the most in the time that this may be; none in a gap.
    fn was_at(&self, at_s: f64, error_s: f64) -> Option<(f64, f64)> {
        let after = self.places.partition_point(|place| place.at_s < at_s);
        let before = after.checked_sub(1).and_then(|before| self.places.get(before));
        let after = self.places.get(after);
        let away = |place: &&Place| (place.at_s - at_s).abs();
        let near = [before, after].into_iter().flatten().min_by(|one, other| away(one).total_cmp(&away(other)))?;
        if away(&near) <= error_s.max(INSTANT_S) {
            return Some((near.position_m, self.fastest(at_s, error_s).max(near.speed.abs())));
        }
        let (before, after) = (before?, after?);
        let way_s = after.at_s - before.at_s;
        if way_s > self.longest_s {
            return None;
        }
        let share = (at_s - before.at_s) / way_s;
        let between = |of: fn(&Place) -> f64| of(before) + share * (of(after) - of(before));
        let fastest = self.fastest(at_s, error_s).max(between(|place| place.speed).abs());
        Some((between(|place| place.position_m), fastest))
    }

    /// How fast the copy was at the most within so long before and after a time, m/s.
    fn fastest(&self, at_s: f64, by_s: f64) -> f64 {
        let from = self.places.partition_point(|place| place.at_s < at_s - by_s);
        let inside = self.places.iter().skip(from).take_while(|place| place.at_s <= at_s + by_s);
        inside.map(|place| place.speed.abs()).fold(0.0, f64::max)
    }
}

/// When, by the board's clock, its tick 0 was, for every record: the least time from a tick to its seal is taken for none.
fn starts_of(times: &[f64], sealed: &[f64], ticks: &[f64]) -> Vec<f64> {
    let mut starts = vec![0.0; times.len()];
    let mut from = 0;
    while from < times.len() {
        let anew = ticks[from..].windows(2).position(|two| two[0] - two[1] > LATE_TICKS);
        let to = anew.map_or(times.len(), |at| from + at + 1);
        let least = (from..to).map(|at| sealed[at] - times[at]).fold(f64::INFINITY, f64::min);
        starts[from..to].fill(least);
        from = to;
    }
    starts
}

/// How the second recording's clock goes beside the first's, and how that is known.
fn relate(one: &Side<'_>, two: &Side<'_>) -> Result<(Relation, String, Option<f64>), Error> {
    let begin = |side: &Side<'_>| side.origin.start_clock_ns as f64 * 1e-9;
    let same = !one.origin.clock.is_empty() && one.origin.clock == two.origin.clock;
    let same = same.then(|| Relation::same_clock(begin(one) - begin(two)));
    let peers = one.board.is_none() && two.board.is_none();
    let sessions = |side: &Side<'_>| side.exchanges.iter().map(|(own, _)| own.to_bits()).collect::<BTreeSet<u64>>();
    let both: BTreeSet<u64> = sessions(one).intersection(&sessions(two)).copied().collect();
    let is_of_both = |session: &f64| peers && !session.is_nan() && both.contains(&session.to_bits());
    let of = |side: &Side<'_>| -> Vec<Exchange> {
        side.exchanges.iter().filter(|(session, _)| is_of_both(session)).map(|(_, exchange)| *exchange).collect()
    };
    let of_both: Vec<_> = of(one).into_iter().chain(of(two).into_iter().map(Exchange::turned)).collect();
    if let Some(relation) = Relation::of(&of_both) {
        let at_s = one.places.get(one.places.len() / 2).map_or(0.0, |place| place.at_s);
        let beside = same.map(|same| 1e6 * (same.offset_s(at_s) - relation.offset_s(at_s)));
        return Ok((relation, format!("{} exchanges between the two", of_both.len()), beside));
    }
    let by =
        if peers { "the clock of the machine that both ran on" } else { "each board's exchanges with one machine" };
    same.map(|same| (same, by.to_owned(), None)).ok_or_else(|| {
        "the two have no clock in common: they were in no session with each other, and were recorded on two machines".into()
    })
}

/// True discrepancy of two recordings.
///
/// # Errors
/// The recordings lack what is needed to bring their clocks together, or do not overlap.
pub fn merge(one: &Recording, two: &Recording) -> Result<Merged, Error> {
    let ([one, two], names) = ([Side::of(one)?, Side::of(two)?], [one, two].map(|side| side.origin.who.clone()));
    let (relation, clock_by, same_machine_less_this_us) = relate(&one, &two)?;
    let mut sum = Sum::default();
    for place in &one.places {
        let (own_s, first) = one.recorded(place.at_s);
        let (other_s, last) = two.timed(own_s + relation.offset_s(own_s));
        let error_s = first + relation.error_s(own_s) + last;
        if let Some((position_m, speed)) = two.was_at(other_s, error_s) {
            sum.see(own_s, [place.position_m, position_m], error_s, speed.abs().max(place.speed.abs()));
        }
    }
    let middle = one.places.get(one.places.len() / 2).map_or(0.0, |place| place.at_s);
    let other_s = |at_s: f64| {
        let own_s = one.recorded(at_s).0;
        two.timed(own_s + relation.offset_s(own_s)).0
    };
    let drift = other_s(middle + 1.0) - other_s(middle) - 1.0;
    let merged = sum.merged(names, clock_by)?;
    let clock_offset_us = 1e6 * (other_s(middle) - middle);
    Ok(Merged { clock_offset_us, clock_drift_ppm: 1e6 * drift, same_machine_less_this_us, ..merged })
}

/// True discrepancy of a recording that holds both ends, on one clock.
///
/// # Errors
/// The recording lacks one of the two ends.
pub fn both(recording: &Recording) -> Result<Merged, Error> {
    let origin = &recording.origin;
    let rows = recording.channels.iter().find(|rows| rows.topic == "/both/ticks");
    let rows = rows.ok_or_else(|| wrong(origin, "holds one end only: name the other end's recording as well"))?;
    let column = |name: &str| rows.column(name);
    let (Some(times), Some(first), Some(second)) = (column("time_s"), column("object_1_m"), column("object_2_m"))
    else {
        return Err(wrong(origin, "has no two copies of an object").into());
    };
    let mut sum = Sum::default();
    times.iter().zip(first).zip(second).for_each(|((at_s, one), two)| sum.see(*at_s, [*one, *two], 0.0, 0.0));
    sum.merged([origin.who.clone(), origin.who.clone()], "one clock".to_owned())
}

/// Instants, one after the other.
#[derive(Default)]
struct Sum {
    rows: Vec<[f64; COLUMNS.len()]>,
    clock_error_s: f64,
}

impl Sum {
    fn see(&mut self, at_s: f64, [one, two]: [f64; 2], error_s: f64, speed: f64) {
        self.rows.push([at_s, one, two, (one - two).abs(), error_s * speed]);
        self.clock_error_s = self.clock_error_s.max(error_s);
    }

    fn merged(self, ends: [String; 2], clock_by: String) -> Result<Merged, Error> {
        let (Some(first), Some(last)) = (self.rows.first(), self.rows.last()) else {
            return Err(
                format!("{} and {} have no instant in common at which both were armed", ends[0], ends[1]).into()
            );
        };
        let count = self.rows.len();
        let rms =
            |column: usize| (self.rows.iter().map(|row| row[column] * row[column]).sum::<f64>() / count as f64).sqrt();
        let largest = |column: usize| self.rows.iter().map(|row| row[column]).fold(0.0, f64::max);
        let half = &self.rows[count / 2..];
        let mut table = Columns::named(COLUMNS);
        self.rows.iter().for_each(|row| table.push_row(row));
        Ok(Merged {
            ends,
            instants: count,
            seconds: last[0] - first[0],
            true_discrepancy_mm: 1e3 * half.iter().map(|row| row[3]).sum::<f64>() / half.len() as f64,
            rms_true_discrepancy_mm: 1e3 * rms(3),
            largest_true_discrepancy_mm: 1e3 * largest(3),
            rms_clock_error_mm: 1e3 * rms(4),
            largest_clock_error_mm: 1e3 * largest(4),
            clock_error_us: 1e6 * self.clock_error_s,
            clock_offset_us: 0.0,
            clock_drift_ppm: 0.0,
            clock_by,
            same_machine_less_this_us: None,
            table,
        })
    }
}

#[cfg(test)]
#[path = "../../tests/inside/recording_merge.rs"]
mod tests;
