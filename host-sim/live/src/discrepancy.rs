//! How far two copies of the object truly are from each other while both live: what the other end says about its copy, laid beside
//! one's own at the same instant.
//!
//! Telemetry says where the other copy was after the tick before, and the seal around it when it was sealed, by the other end's
//! clock. The common clock ([`Watched`]) turns that into a time of one's own, for which one's own positions are kept. What comes out
//! is wrong by no more than the copy moves within the clock's error, which is reported with it. Nothing of this goes back into the control.
//!
//! A board tells what its newest tick saw, which is up to a period older than it is taken for here: a millisecond times the speed.

use std::collections::VecDeque;

use cohold_protocol::wire::Telemetry;

use crate::recording::common_clock::Watched;

/// How long one's own positions are kept, s: longer than telemetry is on its way.
const KEPT_S: f64 = 3.0;

/// A distance of two copies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrepancy {
    /// |x_o1 − x_o2|, m.
    pub distance_m: f64,
    /// By how much the clock's error may make that wrong, m.
    pub error_m: f64,
}

/// Where a copy was.
#[derive(Clone, Copy, Debug)]
struct Place {
    at_s: f64,
    position_m: f64,
}

/// One's own copy, of late.
#[derive(Clone, Debug, Default)]
pub struct PositionHistory(VecDeque<Place>);

impl PositionHistory {
    /// Where it is now.
    pub fn is_at(&mut self, at_s: f64, position_m: f64) {
        self.0.push_back(Place { at_s, position_m });
        while self.0.front().is_some_and(|first| first.at_s < at_s - KEPT_S) {
            self.0.pop_front();
        }
    }

    /// The newest time of which it is known where it was, s.
    pub fn newest_s(&self) -> Option<f64> {
        self.0.back().map(|place| place.at_s)
    }

    /// By how much a straight line between the two places around this time may miss its course, m: an eighth of the second
    /// difference, as of a parabola.
    pub fn bent_m(&self, at_s: f64) -> f64 {
        let after = self.0.partition_point(|place| place.at_s < at_s);
        let place = |at: Option<usize>| at.and_then(|at| self.0.get(at)).map(|place| place.position_m);
        let [first, second, third] = [2, 1, 0].map(|back| place(after.checked_sub(back)));
        let bent =
            first.zip(second).zip(third).map(|((first, second), third)| (first - 2.0 * second + third).abs() / 8.0);
        bent.unwrap_or(0.0)
    }

    /// By how much it is elsewhere within so long before and after this time, m: on, as fast as it was last, after what is kept.
    pub fn strays_m(&self, at_s: f64, by_s: f64) -> f64 {
        let (Some((here_m, _)), Some(last)) = (self.was_at(at_s), self.0.back()) else { return 0.0 };
        let (from_s, to_s) = (at_s - by_s, at_s + by_s);
        let speed = self.was_at(last.at_s).map_or(0.0, |(_, speed)| speed);
        let beyond_m = last.position_m + speed * (to_s - last.at_s).max(0.0);
        let first = self.0.partition_point(|place| place.at_s < from_s);
        let inside = self.0.iter().skip(first).take_while(|place| place.at_s <= to_s).map(|place| place.position_m);
        let ends = [from_s, to_s].into_iter().filter_map(|end_s| self.was_at(end_s)).map(|(position_m, _)| position_m);
        let beyond = (to_s > last.at_s).then_some(beyond_m);
        inside.chain(ends).chain(beyond).map(|position_m| (position_m - here_m).abs()).fold(0.0, f64::max)
    }

    /// Nothing is known of it any more.
    pub fn forget(&mut self) {
        self.0.clear();
    }

    /// Where it was, and how fast; none of a time that is not kept.
    pub fn was_at(&self, at_s: f64) -> Option<(f64, f64)> {
        let after = self.0.partition_point(|place| place.at_s < at_s);
        let (before, after) = (self.0.get(after.checked_sub(1)?)?, self.0.get(after)?);
        let speed = (after.position_m - before.position_m) / (after.at_s - before.at_s);
        Some((before.position_m + speed * (at_s - before.at_s), speed))
    }

    /// How far the other copy is, by telemetry that was sealed at this time of the other clock.
    pub fn discrepancy(&self, said: &Telemetry, sealed_us: u64, period_s: f64, clock: &Watched) -> Option<Discrepancy> {
        let relation = clock.relation.as_ref()?;
        // Both copies move only while both are armed.
        let armed = said.mode == 1;
        let at_s = relation.own_s(sealed_us as f64 * 1e-6 - period_s);
        let (position_m, _) = self.was_at(at_s).filter(|_| armed)?;
        let distance_m = (position_m - f64::from(said.object_position)).abs();
        Some(Discrepancy { distance_m, error_m: self.strays_m(at_s, relation.error_s(at_s)) })
    }
}

/// Recent positions of the copies of several peers, as each reports its own now and then.
#[derive(Clone, Debug)]
pub struct Copies {
    lines: Vec<PositionHistory>,
    /// By how much the clock of each may be wrong, s.
    errors_s: Vec<f64>,
    /// The instant that was looked at last, s.
    looked_s: f64,
}

impl Copies {
    /// For so many lines, on none of which a peer has reported anything yet.
    pub fn new(lines: usize) -> Self {
        Self { lines: vec![PositionHistory::default(); lines], errors_s: vec![0.0; lines], looked_s: f64::NEG_INFINITY }
    }

    /// What the peer on a line says, in a datagram that was sealed at this time of its clock. Gives how far the copies are apart at
    /// the newest instant of which all have reported, between two tellings each; those who have not reported for 3 s
    /// are left out.
    pub fn observe(
        &mut self,
        line: usize,
        said: &Telemetry,
        sealed_us: u64,
        period_s: f64,
        clock: &Watched,
    ) -> Option<Discrepancy> {
        let relation = clock.relation.as_ref()?;
        if said.mode != 1 {
            self.lines[line].forget();
            return None;
        }
        let at_s = relation.own_s(sealed_us as f64 * 1e-6 - period_s);
        if self.lines[line].newest_s().is_none_or(|newest_s| at_s > newest_s) {
            self.lines[line].is_at(at_s, said.object_position.into());
        }
        self.errors_s[line] = relation.error_s(at_s);
        let newest = self.lines.iter().filter_map(PositionHistory::newest_s);
        let latest_s = newest.clone().fold(f64::NEG_INFINITY, f64::max);
        let known_s = newest.filter(|newest_s| *newest_s > latest_s - KEPT_S).fold(f64::INFINITY, f64::min);
        if known_s <= self.looked_s {
            return None;
        }
        let places = self.lines.iter().zip(&self.errors_s);
        let places: Vec<_> = places
            .filter_map(|(own, error_s)| {
                let (position_m, _) = own.was_at(known_s)?;
                Some((position_m, own.strays_m(known_s, *error_s) + own.bent_m(known_s)))
            })
            .collect();
        if places.len() < 2 {
            return None;
        }
        self.looked_s = known_s;
        let (least, most) =
            places.iter().fold((f64::MAX, f64::MIN), |(least, most), (at, _)| (least.min(*at), most.max(*at)));
        // Two of them are the farthest apart, each of which may be wrong.
        let [first_m, second_m] = places.iter().fold([0.0_f64; 2], |[first_m, second_m], (_, error_m)| {
            [first_m.max(*error_m), second_m.max(error_m.min(first_m))]
        });
        Some(Discrepancy { distance_m: most - least, error_m: first_m + second_m })
    }
}

/// What distances come to, over a second or a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum {
    count: u64,
    squares: f64,
    distances: f64,
    largest_m: f64,
    largest_error_m: f64,
}

impl Sum {
    /// Takes in one distance of the copies and its error.
    pub fn add(&mut self, discrepancy: Discrepancy) {
        self.count += 1;
        self.squares += discrepancy.distance_m * discrepancy.distance_m;
        self.distances += discrepancy.distance_m;
        self.largest_m = self.largest_m.max(discrepancy.distance_m);
        self.largest_error_m = self.largest_error_m.max(discrepancy.error_m);
    }

    fn of(&self, value: f64) -> Option<f64> {
        (self.count > 0).then_some(value)
    }

    /// Root of the mean square, m.
    pub fn rms_m(&self) -> Option<f64> {
        self.of((self.squares / self.count as f64).sqrt())
    }

    /// Mean distance of the copies, m.
    pub fn mean_m(&self) -> Option<f64> {
        self.of(self.distances / self.count as f64)
    }

    /// Largest distance of the copies, m.
    pub fn largest_m(&self) -> Option<f64> {
        self.of(self.largest_m)
    }

    /// Largest error that the clocks may cause, m.
    pub fn error_m(&self) -> Option<f64> {
        self.of(self.largest_error_m)
    }
}

#[cfg(test)]
#[path = "../tests/inside/discrepancy.rs"]
mod tests;
