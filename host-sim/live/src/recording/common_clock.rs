//! A common clock: how far another clock is from one's own, how fast it runs away, and how well that is known.
//!
//! **Two-way time transfer.** A probe is sent at t1 and comes at t2 of the other clock; its answer leaves at t3 of the other clock and
//! comes at t4. The offset (other less own) is ((t2 − t1) + (t3 − t4))/2, at (t1 + t4)/2, and lies within half of the round trip
//! r = (t4 − t1) − (t3 − t2) of the truth whatever the network did.
//!
//! **Estimator.** Offset and drift are those of a straight line through all exchanges by least squares with the weights
//! (q/(q + e/2))⁴, where e is how much longer the exchange took than the quickest one and q = 5 µs: an exchange that was
//! held up counts for next to nothing, as in a filter by the smallest round trip, and no window has to be chosen for it.
//!
//! **Error.** Nobody can see by how much the two ways differ: up to half of the smallest round trip. To that comes what is left of
//! chance, twice the standard error of the line, in which an exchange is off by its residual and by q + e/2. Clocks are taken to
//! run evenly: over more than some minutes a quartz that warms up does not, so a live end looks back 60 s.
//! Over less than a second no drift can be measured: it is 0 then, within 100 ppm, as quartzes are.

/// Stamps are of whole microseconds, and some go by between reading the clock and sending, s.
const RESOLUTION_S: f64 = 5e-6;
/// How far a live end looks back, s.
const WINDOW_S: f64 = 60.0;
/// Least time between two exchanges that a live end keeps, s; of those between, the quickest is kept.
const APART_S: f64 = 0.05;
/// Least time over which a drift is measured, s.
const SHORTEST_S: f64 = 1.0;
/// How far the rates of two quartzes differ at the most.
const QUARTZ: f64 = 1e-4;

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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relation {
    /// Where the line is best known, s of one's own clock.
    middle_s: f64,
    /// Offset there, s: other less own.
    offset_s: f64,
    /// How much faster the other clock runs.
    pub drift: f64,
    /// The smallest round trip, s.
    pub round_trip_s: f64,
    /// Variances of offset and drift, and their covariance.
    spread: [f64; 3],
}

impl Relation {
    /// Two ends of the same clock, of which one began so much later, s.
    pub fn same_clock(offset_s: f64) -> Self {
        Self { middle_s: 0.0, offset_s, drift: 0.0, round_trip_s: 0.0, spread: [0.0; 3] }
    }

    /// From exchanges; none from none.
    pub fn of(exchanges: &[Exchange]) -> Option<Self> {
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
        let drift = if known { sum(&|one| x(one) * y(one)) / xx } else { 0.0 };
        let square = |one: &Exchange| {
            let (left, own) = (y(one) - drift * x(one), own_error(one));
            weight(one) * (left * left + own * own)
        };
        let spread = match known {
            true => [
                sum(&square) / (all * all),
                sum(&|one| square(one) * x(one)) / (all * xx),
                sum(&|one| square(one) * x(one) * x(one)) / (xx * xx),
            ],
            // Twice this is what is said.
            false => [sum(&square) / (all * all), 0.0, 0.25 * QUARTZ * QUARTZ],
        };
        Some(Self { middle_s: from_s + middle, offset_s: base_s + offset, drift, round_trip_s, spread })
    }

    /// The other clock less one's own, when one's own shows this, s.
    pub fn offset_s(&self, own_s: f64) -> f64 {
        self.offset_s + self.drift * (own_s - self.middle_s)
    }

    /// By how much that may be wrong, s.
    pub fn error_s(&self, own_s: f64) -> f64 {
        let (since, [offset, both, drift]) = (own_s - self.middle_s, self.spread);
        let variance = offset + 2.0 * both * since + drift * since * since;
        0.5 * self.round_trip_s + 2.0 * variance.max(0.0).sqrt()
    }

    /// By how much the drift may be wrong.
    pub fn drift_error(&self) -> f64 {
        2.0 * self.spread[2].max(0.0).sqrt()
    }

    /// What one's own clock shows when the other shows this, s.
    pub fn own_s(&self, other_s: f64) -> f64 {
        // other = own + offset + drift·(own − middle)
        (other_s - self.offset_s + self.drift * self.middle_s) / (1.0 + self.drift)
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
