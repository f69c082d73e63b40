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
pub const KEPT_S: f64 = 3.0;

/// How far two copies are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrepancy {
    /// Position of the other copy minus that of one's own, m; of a hub's copies the distance of the two farthest.
    pub offset_m: f64,
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
        let offset_m = f64::from(said.object_position) - position_m;
        Some(Discrepancy { offset_m, error_m: self.strays_m(at_s, relation.error_s(at_s)) })
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
        let distance_m = discrepancy.offset_m.abs();
        self.count += 1;
        self.squares += distance_m * distance_m;
        self.distances += distance_m;
        self.largest_m = self.largest_m.max(distance_m);
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
