//! A copy along a shared axis, as a recording has it: where it was at any time while it was armed, and what of it is no motion.

use super::file::Rows;
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
/// How far a copy may be from where its speed takes it in a tick, m: what it may have drifted while its line stood.
const DRIFT_M: f64 = 1e-3;

/// A copy at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) at_s: f64,
    position_m: f64,
    speed: f64,
}

/// A copy along a shared axis while it was armed, in order of time.
#[derive(Debug)]
pub(super) struct Course {
    pub(super) places: Vec<Place>,
    /// The longest way between two of them that is no gap, s.
    longest_s: f64,
    /// Rows that are no motion.
    pub(super) left_out: usize,
}

impl Course {
    /// From the rows of an axis, of which each began so late.
    pub(super) fn of(rows: &Rows, starts: &[f64], origin: &Origin) -> Result<Self, Error> {
        let column = |name: &str| rows.column(name).ok_or_else(|| wrong(origin, &format!("has no column {name}")));
        let (times, modes) = (column("time_s")?, column("mode")?);
        let (positions, speeds) = (column("object_m")?, column("object_m_per_s")?);
        let place = |at: usize| Place { at_s: starts[at] + times[at], position_m: positions[at], speed: speeds[at] };
        let mut armed: Vec<_> = (0..times.len()).filter(|at| modes[*at] == ARMED).map(place).collect();
        armed.sort_by(|one, other| one.at_s.total_cmp(&other.at_s));
        let mut intervals_s: Vec<f64> = armed.windows(2).map(|two| two[1].at_s - two[0].at_s).collect();
        intervals_s.sort_by(f64::total_cmp);
        let longest_s = GAP * intervals_s.get(intervals_s.len() / 2).copied().unwrap_or(0.0);
        let is_motion = |at: &usize| {
            let before = at.checked_sub(1).map(|before| &armed[before]);
            armed[*at].is_finite() && before.is_none_or(|before| before.may_come_to(&armed[*at], longest_s))
        };
        let places: Vec<_> = (0..armed.len()).filter(is_motion).map(|at| armed[at]).collect();
        Ok(Self { left_out: armed.len() - places.len(), places, longest_s })
    }

    /// Where the copy was, and how fast it was at the most in the time that this may be; none in a gap.
    pub(super) fn was_at(&self, at_s: f64, error_s: f64) -> Option<(f64, f64)> {
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
        let inside = self.places[from..].iter().take_while(|place| place.at_s <= at_s + by_s);
        inside.map(|place| place.speed.abs()).fold(0.0, f64::max)
    }
}

impl Place {
    fn is_finite(&self) -> bool {
        [self.at_s, self.position_m, self.speed].iter().all(|number| number.is_finite())
    }

    /// Whether a copy may come from here to there in a tick: twice as far as the larger of its speeds takes it, and some drift. After a
    /// gap it may be anywhere.
    fn may_come_to(&self, there: &Self, longest_s: f64) -> bool {
        let way_s = there.at_s - self.at_s;
        let furthest_m = 2.0 * way_s * self.speed.abs().max(there.speed.abs()) + DRIFT_M;
        way_s > longest_s || !self.is_finite() || (there.position_m - self.position_m).abs() <= furthest_m
    }
}

/// When, by the board's clock, its tick 0 was, for every record: the least time from a tick to its seal is taken for none.
pub(super) fn starts_of(times: &[f64], sealed: &[f64], ticks: &[f64]) -> Vec<f64> {
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

pub(super) fn wrong(origin: &Origin, what: &str) -> String {
    format!("the recording of {} {what}", if origin.who.is_empty() { "nobody" } else { &origin.who })
}
