//! A common clock: how far another clock is from one's own, how fast it runs away, and how well that is known.
//!
//! **Two-way time transfer.** A probe is sent at t1 and comes at t2 of the other clock; its answer leaves at t3 of the other clock and
//! comes at t4. The offset (other less own) is ((t2 − t1) + (t3 − t4))/2, at (t1 + t4)/2, and lies within half of the round trip
//! r = (t4 − t1) − (t3 − t2) of the truth whatever the network did.
//!
//! **Estimator.** Offset and drift are those of a straight line through all exchanges by least squares with the weights
//! (q/(q + e/2))⁴, where e is how much longer the exchange took than the quickest one and q = 5 µs: an exchange that was
//! held up counts for next to nothing, as in a filter by the smallest round trip, and no window has to be chosen for it. Where those
//! that count lie within a second, as where one early exchange was quicker than all that follow, they tell no drift: it is in the
//! middle of what all exchanges leave.
//!
//! **Error.** Nothing arrives before it was sent. So an exchange leaves the offset between t3 − t4 and t2 − t1, whoever delays what, and
//! however unlike the two ways are; at another time, between these and what the drift may have made of them since. The offset is
//! within what all exchanges leave together, and the error is how far that reaches: it has the round trip and the time since in it.
//! Which drifts are possible is found in the same way, from each two exchanges. Clocks are taken to run evenly over a look back of 60 s;
//! where exchanges say that they did not, they are taken to be anywhere within 200 ppm at any time. What needs more than that
//! is no clock, and there is no relation.

/// No clock shows more, s: thirty thousand years.
const LONGEST_S: f64 = 1e12;
/// Stamps are of whole microseconds, and some go by between reading the clock and sending, s.
const RESOLUTION_S: f64 = 5e-6;
/// How far a live end looks back, s.
const WINDOW_S: f64 = 60.0;
/// Least time between two exchanges that a live end keeps, s; of those between, the quickest is kept.
const APART_S: f64 = 0.05;
/// Least time over which a drift is measured, s.
const SHORTEST_S: f64 = 1.0;
/// How far the rates of two clocks differ at the most: two quartzes of 100 ppm each.
const QUARTZ: f64 = 2e-4;
/// Parts of the time looked at, from each of which the quickest exchange bounds the drift.
const PARTS: usize = 16;

/// One question and its answer: t1 and t4 of one's own clock, t2 and t3 of the other, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    /// The times t1 to t4, s.
    pub times_s: [f64; 4],
}

impl Exchange {
    /// From times in µs.
    pub fn of_us(times: [u64; 4]) -> Self {
        Self { times_s: times.map(|us| us as f64 * 1e-6) }
    }

    /// As the other end sees it: own and other clock changed round, and so question and answer.
    #[must_use]
    pub fn turned(self) -> Self {
        let [t1, t2, t3, t4] = self.times_s;
        // What left here at t1 and came there at t2 is an answer to what left there at t3 and came here at t4.
        Self { times_s: [t3, t4, t1, t2] }
    }

    fn round_trip_s(&self) -> f64 {
        let [t1, t2, t3, t4] = self.times_s;
        (t4 - t1) - (t3 - t2)
    }

    fn offset_s(&self) -> f64 {
        let [t1, t2, t3, t4] = self.times_s;
        0.5 * ((t2 - t1) + (t3 - t4))
    }

    fn at_s(&self) -> f64 {
        0.5 * (self.times_s[0] + self.times_s[3])
    }
}

/// How another clock goes, as seen from one's own.
#[derive(Clone, Debug, PartialEq)]
pub struct Relation {
    /// Where the line is best known, s of one's own clock.
    middle_s: f64,
    /// Offset there, s: other less own.
    offset_s: f64,
    /// How much faster the other clock runs.
    pub drift: f64,
    /// The smallest round trip, s.
    pub round_trip_s: f64,
    bounds: Bounds,
}

/// The least and the largest offset that exchanges leave, s.
#[derive(Clone, Debug, Default, PartialEq)]
struct Bounds {
    /// Least and largest drift.
    drifts: [f64; 2],
    /// When the exchanges were, s, in order.
    at_s: Vec<f64>,
    /// What those up to each leave, and those from each on, carried to time 0 by the drift that bounds.
    past: Vec<[f64; 2]>,
    future: Vec<[f64; 2]>,
}

/// What a single exchange leaves: when, s, and the least and the largest offset, s.
type Bound = (f64, [f64; 2]);

/// What both leave.
fn meet(one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    [one[0].max(other[0]), one[1].min(other[1])]
}

impl Bounds {
    /// What is left by exchanges in order, if something is: with a drift that is the same all the time, else with any.
    fn of(exchanges: &[Exchange]) -> Option<Self> {
        let every: Vec<Bound> = exchanges
            .iter()
            .map(|exchange| {
                let [t1, t2, t3, t4] = exchange.times_s;
                let slack_s = RESOLUTION_S + 0.5 * QUARTZ * (t4 - t1);
                (exchange.at_s(), [t3 - t4 - slack_s, t2 - t1 + slack_s])
            })
            .collect();
        let any = [-QUARTZ, QUARTZ];
        let even = even_drifts(&every).map(|drifts| meet(drifts, any)).filter(|[least, most]| least <= most);
        even.into_iter().chain([any]).find_map(|drifts| Self::with(drifts, &every))
    }

    fn with(drifts: [f64; 2], every: &[Bound]) -> Option<Self> {
        let [least, most] = drifts;
        let nothing = [f64::NEG_INFINITY, f64::INFINITY];
        let carried = |slopes: [f64; 2]| {
            move |left: &mut [f64; 2], (at, [low, high]): &Bound| {
                *left = meet(*left, [low - slopes[0] * at, high - slopes[1] * at]);
                Some(*left)
            }
        };
        let past = every.iter().scan(nothing, carried([least, most])).collect();
        let mut future: Vec<_> = every.iter().rev().scan(nothing, carried([most, least])).collect();
        future.reverse();
        let bounds = Self { drifts, at_s: every.iter().map(|(at, _)| *at).collect(), past, future };
        let possible = |(at, _): &Bound| matches!(bounds.at(*at), Some([low, high]) if low <= high);
        every.iter().all(possible).then_some(bounds)
    }

    /// The least and the largest offset at a time; none where there is no exchange.
    fn at(&self, own_s: f64) -> Option<[f64; 2]> {
        let next = self.at_s.partition_point(|at| *at <= own_s);
        let [least, most] = self.drifts;
        let before = next.checked_sub(1).and_then(|last| self.past.get(last));
        let before = before.map(|[low, high]| [low + least * own_s, high + most * own_s]);
        let after = self.future.get(next).map(|[low, high]| [low + most * own_s, high + least * own_s]);
        before.into_iter().chain(after).reduce(meet)
    }
}

/// The least and the largest drift of clocks that run evenly, by each two of the quickest exchanges.
fn even_drifts(every: &[Bound]) -> Option<[f64; 2]> {
    let wide = |(_, [low, high]): &Bound| high - low;
    let quickest = |part: &[Bound]| part.iter().copied().min_by(|one, other| wide(one).total_cmp(&wide(other)));
    let few: Vec<Bound> = every.chunks(every.len().div_ceil(PARTS).max(1)).filter_map(quickest).collect();
    let pairs = few.iter().enumerate().flat_map(|(at, one)| few[at + 1..].iter().map(move |other| (one, other)));
    pairs
        .filter(|((one, _), (other, _))| other > one)
        .map(|((one, before), (other, after))| {
            [(after[0] - before[1]) / (other - one), (after[1] - before[0]) / (other - one)]
        })
        .reduce(meet)
}

impl Relation {
    /// Two ends of the same clock, of which one began so much later, s.
    pub fn same_clock(offset_s: f64) -> Self {
        Self { middle_s: 0.0, offset_s, drift: 0.0, round_trip_s: 0.0, bounds: Bounds::default() }
    }

    /// From exchanges; none from none, and none of what no two clocks could give.
    pub fn of(exchanges: &[Exchange]) -> Option<Self> {
        // A file may say anything.
        let are_times = |exchange: &Exchange| exchange.times_s.iter().all(|time_s| time_s.abs() <= LONGEST_S);
        if !exchanges.iter().all(are_times) {
            return None;
        }
        let mut ordered = exchanges.to_vec();
        ordered.sort_by(|one, other| one.at_s().total_cmp(&other.at_s()));
        let exchanges = ordered;
        let bounds = Bounds::of(&exchanges)?;
        let round_trip_s = exchanges.iter().map(Exchange::round_trip_s).reduce(f64::min)?.max(0.0);
        let own_error = |exchange: &Exchange| RESOLUTION_S + 0.5 * (exchange.round_trip_s() - round_trip_s).max(0.0);
        let weight = |exchange: &Exchange| (RESOLUTION_S / own_error(exchange)).powi(4);
        let sum = |of: &dyn Fn(&Exchange) -> f64| exchanges.iter().map(|one| weight(one) * of(one)).sum::<f64>();
        let all = sum(&|_| 1.0);
        // From the first of them, so that nothing is large.
        let (from_s, base_s) = exchanges.first().map(|first| (first.at_s(), first.offset_s()))?;
        let middle = sum(&|one| one.at_s() - from_s) / all;
        let offset = sum(&|one| one.offset_s() - base_s) / all;
        let x = |one: &Exchange| one.at_s() - from_s - middle;
        let y = |one: &Exchange| one.offset_s() - base_s - offset;
        let xx = sum(&|one| x(one) * x(one));
        // The time that those which count lie apart.
        let known = (12.0 * xx / all).sqrt() >= SHORTEST_S;
        let [least, most] = bounds.drifts;
        let drift = if known { sum(&|one| x(one) * y(one)) / xx } else { 0.5 * (least + most) };
        let drift = drift.max(least).min(most);
        Some(Self { middle_s: from_s + middle, offset_s: base_s + offset, drift, round_trip_s, bounds })
    }

    /// The other clock less one's own, when one's own shows this, s.
    pub fn offset_s(&self, own_s: f64) -> f64 {
        let offset_s = self.offset_s + self.drift * (own_s - self.middle_s);
        self.bounds.at(own_s).map_or(offset_s, |[low, high]| offset_s.max(low.min(high)).min(high))
    }

    /// By how much that may be wrong, s.
    pub fn error_s(&self, own_s: f64) -> f64 {
        let offset_s = self.offset_s(own_s);
        self.bounds.at(own_s).map_or(0.0, |[low, high]| (high - offset_s).max(offset_s - low))
    }

    /// By how much the drift may be wrong.
    pub fn drift_error(&self) -> f64 {
        let [least, most] = self.bounds.drifts;
        (most - self.drift).max(self.drift - least)
    }

    /// What one's own clock shows when the other shows this, s.
    pub fn own_s(&self, other_s: f64) -> f64 {
        // The offset changes by less than a thousandth of the time: each look brings it so much nearer.
        let guess_s = other_s - self.offset_s;
        (0..6).fold(guess_s, |own_s, _| other_s - self.offset_s(own_s))
    }
}

/// The clock of another end while it runs.
#[derive(Clone, Debug, Default)]
pub struct Watched {
    kept: std::collections::VecDeque<Exchange>,
    newest: Option<[u64; 4]>,
    /// How it goes, as of the last look.
    pub relation: Option<Relation>,
}

impl Watched {
    /// Takes the newest exchange that a link knows, µs; gives it if it is one more.
    pub fn see(&mut self, newest: Option<[u64; 4]>) -> Option<Exchange> {
        if newest == self.newest {
            return None;
        }
        self.newest = newest;
        let exchange = Exchange::of_us(newest?);
        let near = self.kept.back().is_some_and(|last| exchange.at_s() < last.at_s() + APART_S);
        if !near {
            self.kept.push_back(exchange);
        } else if let Some(last) = self.kept.back_mut()
            && exchange.round_trip_s() < last.round_trip_s()
        {
            last.times_s = exchange.times_s;
        }
        while self.kept.front().is_some_and(|first| first.at_s() < exchange.at_s() - WINDOW_S) {
            self.kept.pop_front();
        }
        Some(exchange)
    }

    /// Another life of the other end has another clock.
    pub fn forget(&mut self) {
        self.kept.clear();
        self.relation = None;
    }

    /// Looks at what has come.
    pub fn look(&mut self) {
        self.relation = Relation::of(self.kept.make_contiguous());
    }
}

#[cfg(test)]
#[path = "../../tests/inside/recording_common_clock.rs"]
mod tests;
