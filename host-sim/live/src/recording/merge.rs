//! True discrepancy of two recordings: where both copies were at the same instants of a common clock, and what the clock's error
//! makes of it.
//!
//! **Whose clock.** Ticks of a peer are timed by the clock of the process that ran it, which is the recording's. Ticks of a board are
//! timed by the board: its tick counter, which runs evenly from when it was started; when that was on the board's clock, the seals
//! of its records tell, of which the quickest was sealed right after its tick. How the board's clock goes beside the operator's, the
//! exchanges between the two tell ([`Relation`]).
//!
//! **From one recording to the other** lead the exchanges of a session that both were ends of; or those of both with a hub, if its
//! recording is there; of two boards, the steady clock of a machine on which both were recorded, whose error is 0. A chain of
//! clocks is as wrong as its links together. Peers that were in no session with each other are not compared.
//!
//! **At one instant**: for every tick of the first, the second's copy at that time, on the straight line between two ticks; or the
//! copy of one tick, where the clock cannot tell that it was another instant. Along several shared axes the discrepancy is the distance
//! in the plane or in space, at instants at which both copies are known along all of them.
//!
//! **Physics.** A row whose numbers are not finite, or whose copy is further from where it was a tick before than its speed could take
//! it, is no motion: it is left out, and counted.

use std::collections::BTreeSet;

use cohold_report::Columns;
use cohold_sim::quantities::{self, Named};
use cohold_sim::run::AXIS_NAMES;
use serde::Serialize;

use super::common_clock::{Exchange, Relation};
use super::course::{Course, starts_of, wrong};
use super::file::{Recording, Rows};
use super::origin::Origin;
use super::ticks::name_of;
use crate::Error;

/// Columns of the table of every instant.
pub const COLUMNS: [Named; 5] = [
    ("time_s", "since the clock of the first recording began"),
    ("object_1_m", "position of the copy of the object in the first recording"),
    ("object_2_m", "position of the copy of the object in the second recording, at this instant"),
    quantities::TRUE_DISCREPANCY,
    ("clock_error_m", "what the clock's error may have made of it: speed of the copies times that"),
];

/// [`COLUMNS`] of copies that are shared along so many axes: positions along the further ones follow.
pub fn columns(axes: usize) -> impl Iterator<Item = (String, &'static str)> {
    let further = AXIS_NAMES.into_iter().take(axes).skip(1).flat_map(|axis| {
        let meanings = ["the first copy along this further axis", "the second copy along it, at this instant"];
        [1, 2].map(|end| (format!("object_{end}_{axis}_m"), meanings[end - 1]))
    });
    COLUMNS.into_iter().map(|(name, meaning)| (name.to_owned(), meaning)).chain(further)
}

/// One end as it was recorded.
#[derive(Debug)]
struct Side<'a> {
    origin: &'a Origin,
    /// What the topics of its channels begin with: `/peer_1`.
    end: &'a str,
    /// The copy along each shared axis.
    axes: Vec<Course>,
    /// How the clock that timed them goes beside the recording's; none where it is that one.
    board: Option<Relation>,
    /// Exchanges with the other end, and in which session each was.
    exchanges: Vec<(f64, Exchange)>,
}

/// What there is to say of two recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Merged {
    /// Names of the two ends that recorded.
    pub ends: [String; 2],
    /// Number of shared axes.
    pub axes: usize,
    /// Rows of either end that are no motion, and were left out.
    pub left_out: [usize; 2],
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

/// The exchanges of a recording, and in which session each was.
fn exchanges_of(recording: &Recording) -> Vec<(f64, Exchange)> {
    let Some(rows) = recording.channels.iter().find(|rows| rows.topic.ends_with("/exchanges")) else {
        return Vec::new();
    };
    let get = |name: &str, at: usize| rows.column(name).map_or(f64::NAN, |values| values[at]);
    let one = |at: usize| {
        let times_s = ["sent_s", "there_s", "answered_s", "back_s"].map(|name| get(name, at));
        (get("session", at), Exchange { times_s })
    };
    (0..rows.len()).map(one).collect()
}

impl<'a> Side<'a> {
    fn of(recording: &'a Recording) -> Result<Self, Error> {
        let origin = &recording.origin;
        let topics = || recording.channels.iter().map(|rows| rows.topic.as_str());
        if topics().any(|topic| topic.starts_with("/both/")) {
            let why = "holds both ends already, on one clock: `cohold recording merge` takes it alone";
            return Err(wrong(origin, why).into());
        }
        // What a page shows beside its peer is drawn, not measured.
        let ends = topics().filter(|topic| *topic != "/page/ticks").filter_map(|topic| topic.strip_suffix("/ticks"));
        let end = ends.min().ok_or_else(|| wrong(origin, "has no ticks of a peer or a board"))?;
        let axis = |axis: usize| {
            let topic = format!("{end}/{}", name_of(axis));
            recording.channels.iter().find(|rows| rows.topic == topic)
        };
        let exchanges = exchanges_of(recording);
        let (mut axes, mut board) = (Vec::new(), None);
        for rows in (0..AXIS_NAMES.len()).map_while(axis) {
            let column = |name: &str| rows.column(name).ok_or_else(|| wrong(origin, &format!("has no column {name}")));
            let mut starts = vec![0.0; rows.len()];
            if let Some(sealed) = rows.column("sealed_s") {
                starts = starts_of(column("time_s")?, sealed, column("tick")?);
                let all: Vec<_> = exchanges.iter().map(|(_, exchange)| *exchange).collect();
                let known = Relation::of(&all).ok_or_else(|| wrong(origin, "has no exchange with the board's clock"));
                board = Some(known?);
            }
            axes.push(Course::of(rows, &starts, origin)?);
        }
        Ok(Self { origin, end, axes, board, exchanges })
    }

    fn left_out(&self) -> usize {
        self.axes.iter().map(|course| course.left_out).sum()
    }

    /// A time in the middle of what was armed, s.
    fn middle_s(&self) -> f64 {
        let places = self.axes.first().map_or(&[][..], |course| &course.places);
        places.get(places.len() / 2).map_or(0.0, |place| place.at_s)
    }
}

/// How one leads from a time of the first end to the same instant at the second.
#[derive(Clone, Debug)]
struct Clocks {
    /// Clock of what timed the first end's ticks, if it is not its recording's.
    first: Option<Relation>,
    /// From the first recording to the second, over a hub's if need be.
    between: Vec<Relation>,
    second: Option<Relation>,
    /// How that is known, in words.
    by: String,
    /// The offset by the clock of the machine that both ran on, less this one, µs.
    same_machine_less_this_us: Option<f64>,
}

impl Clocks {
    fn of(one: &Side<'_>, two: &Side<'_>, hub: Option<&Recording>) -> Result<Self, Error> {
        let begin = |side: &Side<'_>| side.origin.start_clock_ns as f64 * 1e-9;
        let same = !one.origin.clock.is_empty() && one.origin.clock == two.origin.clock;
        let same = same.then(|| Relation::same_clock(begin(one) - begin(two)));
        let found = |between: Vec<Relation>, by: String, same_machine_less_this_us| {
            Ok(Self { first: one.board.clone(), between, second: two.board.clone(), by, same_machine_less_this_us })
        };
        if one.board.is_some() || two.board.is_some() {
            let why = "the two have no clock in common: they were recorded on two machines";
            return found(vec![same.ok_or(why)?], "each board's exchanges with one machine".to_owned(), None);
        }
        let (between, count) = match hub.map(exchanges_of) {
            None => related(&one.exchanges, &two.exchanges).map(|(relation, count)| (vec![relation], count)).ok_or(
                "the two were in no session with each other; of two peers of a hub, name its recording with --hub",
            )?,
            Some(hub) => {
                let with = |side: &Side<'_>, found: Option<(Relation, usize)>| {
                    found.ok_or_else(|| wrong(side.origin, "is of no session with that hub"))
                };
                let (there, first) = with(one, related(&one.exchanges, &hub))?;
                let (back, second) = with(two, related(&hub, &two.exchanges))?;
                (vec![there, back], first + second)
            }
        };
        let at_s = one.middle_s();
        let by = format!("{count} exchanges between the two{}", if hub.is_some() { " and their hub" } else { "" });
        let over = between.iter().fold(at_s, |at_s, relation| at_s + relation.offset_s(at_s)) - at_s;
        found(between, by, same.map(|same| 1e6 * (same.offset_s(at_s) - over)))
    }

    /// The same instant at the second end, and by how much that may be wrong, s.
    fn across(&self, at_s: f64) -> (f64, f64) {
        // What the recording's clock showed when the one that timed the ticks showed this.
        let own = self.first.as_ref().map(|board| board.own_s(at_s));
        let begin =
            own.map_or((at_s, 0.0), |own_s| (own_s, self.first.as_ref().map_or(0.0, |board| board.error_s(own_s))));
        let step = |(at_s, error_s): (f64, f64), relation: &Relation| {
            (at_s + relation.offset_s(at_s), error_s + relation.error_s(at_s))
        };
        self.between.iter().chain(&self.second).fold(begin, step)
    }
}

/// How the second clock goes beside the first, by the exchanges of sessions that both were ends of; and how many these are.
fn related(one: &[(f64, Exchange)], two: &[(f64, Exchange)]) -> Option<(Relation, usize)> {
    let sessions = |of: &[(f64, Exchange)]| of.iter().map(|(own, _)| own.to_bits()).collect::<BTreeSet<u64>>();
    let both: BTreeSet<u64> = sessions(one).intersection(&sessions(two)).copied().collect();
    let of_both = |of: &[(f64, Exchange)]| -> Vec<Exchange> {
        let is_of_both = |session: f64| !session.is_nan() && both.contains(&session.to_bits());
        of.iter().filter(|(session, _)| is_of_both(*session)).map(|(_, exchange)| *exchange).collect()
    };
    let all: Vec<_> = of_both(one).into_iter().chain(of_both(two).into_iter().map(Exchange::turned)).collect();
    Relation::of(&all).map(|relation| (relation, all.len()))
}

/// Both ends, which are two, and of one kind of object.
fn ends<'a>(one: &'a Recording, two: &'a Recording) -> Result<[Side<'a>; 2], Error> {
    let [one, two] = [Side::of(one)?, Side::of(two)?];
    if one.end == two.end {
        let end = one.end.trim_start_matches('/').replace('_', " ");
        return Err(format!("both are recordings of {end}: one of each end is needed").into());
    }
    let [first, second] = [&one, &two].map(|side| side.axes.len());
    if first != second {
        let [one, two] = [&one, &two].map(|side| wrong(side.origin, ""));
        return Err(format!("{one}shares {first} axes, and {two}{second}: both must share the same").into());
    }
    Ok([one, two])
}

/// True discrepancy of two recordings; of two peers of a hub, with the hub's.
///
/// # Errors
/// They are of one end, or lack what is needed to bring their clocks together, or do not overlap.
pub fn merge(one: &Recording, two: &Recording, hub: Option<&Recording>) -> Result<Merged, Error> {
    let names = [one, two].map(|side| side.origin.who.clone());
    let [one, two] = ends(one, two)?;
    let clocks = Clocks::of(&one, &two, hub)?;
    let mut sum = Sum::new(one.axes.len());
    for place in one.axes.first().map_or(&[][..], |course| &course.places) {
        let (other_s, error_s) = clocks.across(place.at_s);
        let along = |(here, there): (&Course, &Course)| {
            let [(one_m, own), (two_m, other)] = [here.was_at(place.at_s, 0.0)?, there.was_at(other_s, error_s)?];
            Some(([one_m, two_m], own.max(other)))
        };
        let all: Option<Vec<_>> = one.axes.iter().zip(&two.axes).map(along).collect();
        let Some((copies, speeds)): Option<(Vec<_>, Vec<_>)> = all.map(|all| all.into_iter().unzip()) else { continue };
        let own_s = clocks.first.as_ref().map_or(place.at_s, |board| board.own_s(place.at_s));
        sum.see(own_s, &copies, error_s, distance(&speeds));
    }
    let middle = one.middle_s();
    let [before, after] = [middle, middle + 1.0].map(|at_s| clocks.across(at_s).0);
    let merged = sum.merged(names, clocks.by)?;
    Ok(Merged {
        left_out: [one.left_out(), two.left_out()],
        clock_offset_us: 1e6 * (before - middle),
        clock_drift_ppm: 1e6 * (after - before - 1.0),
        same_machine_less_this_us: clocks.same_machine_less_this_us,
        ..merged
    })
}

/// From a time of the second recording's clock to the first's, s.
///
/// # Errors
/// As [`merge`].
pub fn on_the_first_clock(
    one: &Recording,
    two: &Recording,
    hub: Option<&Recording>,
) -> Result<impl Fn(f64) -> f64 + use<>, Error> {
    let [one, two] = ends(one, two)?;
    let Clocks { between, .. } = Clocks::of(&one, &two, hub)?;
    Ok(move |at_s: f64| between.iter().rev().fold(at_s, |at_s, relation| relation.own_s(at_s)))
}

/// Length of a vector.
fn distance(along: &[f64]) -> f64 {
    match along {
        [one] => one.abs(),
        several => several.iter().map(|one| one * one).sum::<f64>().sqrt(),
    }
}

/// True discrepancy of a recording that holds both ends, on one clock.
///
/// # Errors
/// The recording lacks one of the two ends.
pub fn both(recording: &Recording) -> Result<Merged, Error> {
    let origin = &recording.origin;
    let called = |topic: &str| recording.channels.iter().find(|rows| rows.topic == topic);
    // A page has a channel for an object on a line, in a plane and in space.
    let shown = ["/both/ticks", "/both/plane", "/both/space"].into_iter().filter_map(called);
    let rows = shown.max_by_key(|rows| rows.len());
    let rows = rows.ok_or_else(|| wrong(origin, "holds one end only: name the other end's recording as well"))?;
    let copies = |rows: &Rows, suffix: &str| {
        let [one, two] = [1, 2].map(|end| rows.column(&format!("object_{end}{suffix}_m")).map(<[f64]>::to_vec));
        Some((rows.column("time_s")?.to_vec(), [one?, two?]))
    };
    let first = copies(rows, "").ok_or_else(|| wrong(origin, "has no two copies of an object"))?;
    let further = AXIS_NAMES.iter().enumerate().skip(1).map_while(|(axis, name)| {
        copies(rows, &format!("_{name}")).or_else(|| copies(called(&format!("/both/{}", name_of(axis)))?, ""))
    });
    let axes: Vec<_> = std::iter::once(first).chain(further).collect();
    let mut sum = Sum::new(axes.len());
    for at_s in &axes[0].0 {
        // An instant whose row was lost along an axis is none.
        let along = |(times, [one, two]): &(Vec<f64>, [Vec<f64>; 2])| {
            let at = times.binary_search_by(|time_s| time_s.total_cmp(at_s)).ok()?;
            Some([one[at], two[at]]).filter(|copies| copies.iter().all(|copy| copy.is_finite()))
        };
        if let Some(copies) = axes.iter().map(along).collect::<Option<Vec<_>>>() {
            sum.see(*at_s, &copies, 0.0, 0.0);
        }
    }
    sum.merged([origin.who.clone(), origin.who.clone()], "one clock".to_owned())
}

/// Instants, one after the other.
struct Sum {
    rows: Vec<Vec<f64>>,
    axes: usize,
    clock_error_s: f64,
}

impl Sum {
    fn new(axes: usize) -> Self {
        Self { rows: Vec::new(), axes, clock_error_s: 0.0 }
    }

    /// Takes where both copies are along each axis.
    fn see(&mut self, at_s: f64, copies: &[[f64; 2]], error_s: f64, speed: f64) {
        let apart: Vec<f64> = copies.iter().map(|[one, two]| one - two).collect();
        let mut row = vec![at_s, copies[0][0], copies[0][1], distance(&apart), error_s * speed];
        row.extend(copies[1..].as_flattened());
        self.rows.push(row);
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
        let mut table = Columns::named(columns(self.axes));
        self.rows.iter().for_each(|row| table.push_row(row));
        Ok(Merged {
            ends,
            axes: self.axes,
            instants: count,
            seconds: last[0] - first[0],
            true_discrepancy_mm: 1e3 * half.iter().map(|row| row[3]).sum::<f64>() / half.len() as f64,
            rms_true_discrepancy_mm: 1e3 * rms(3),
            largest_true_discrepancy_mm: 1e3 * largest(3),
            rms_clock_error_mm: 1e3 * rms(4),
            largest_clock_error_mm: 1e3 * largest(4),
            clock_error_us: 1e6 * self.clock_error_s,
            clock_by,
            table,
            ..Merged::default()
        })
    }
}

#[cfg(test)]
#[path = "../../tests/inside/recording_merge.rs"]
mod tests;
