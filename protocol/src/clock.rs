//! Clock: how far the other peer's clock is from ours, how fast it runs away, and how long the way is.
//!
//! A probe and its reply give four times: t1 sent, t2 received there, t3 answered there, t4 back here. Round trip
//! (t4 − t1) − (t3 − t2); offset ((t2 − t1) + (t3 − t4))/2, wrong by half of what the two ways differ. Round trip and
//! jitter are smoothed (RFC 6298). Delay only ever adds, so the offset is taken from the fastest round trip of each 2 s
//! (NTP's clock filter, RFC 5905 §10); offset and drift then follow the least-squares line through the last 32 of those.
//!
//! **Units**: µs and ppm. **Limits**: a lasting difference between the two ways cannot be seen by anyone; drift is known
//! after 8 s and its error falls with the 1.5th power of time until the line is full, after 64 s (tests show how far).
//! Whatever times come in, the estimates are finite; a sample that no clocks could give is refused.

/// How long samples are gathered of which the fastest counts, µs.
const BLOCK_US: u64 = 2_000_000;
/// How many fastest ones the drift is taken from.
const LINE: usize = 32;
/// How many of them it needs.
const LEAST: usize = 4;
/// The longest round trip that is believed, µs.
const LONGEST_US: i64 = 10_000_000;
/// The largest drift that is believed, ppm: two quartzes of 100 ppm each. Who delays what is sent can feign any.
const MOST_PPM: f64 = 200.0;

/// A sample that is not believed: the times do not follow each other, or lie too far apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("four times that no two clocks could give")]
pub struct Implausible;

/// One offset, seen at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Point {
    at_us: u64,
    offset_us: i64,
}

/// The other peer's clock as seen from here.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    round_trip_us: Option<f32>,
    jitter_us: f32,
    fastest: Option<(i64, Point)>,
    block_began_us: u64,
    line: [Point; LINE],
    points: usize,
    offset: Option<Point>,
    drift: f64,
    newest: Option<[u64; 4]>,
}

impl Clock {
    /// Takes in one probe and its reply: sent (t1), received there (t2), answered there (t3), back here (t4), µs.
    /// Gives the round trip, µs.
    ///
    /// # Errors
    /// Times that contradict each other, or lie too far apart.
    pub fn sample(&mut self, t1: u64, t2: u64, t3: u64, t4: u64) -> Result<u32, Implausible> {
        let away = difference(t4, t1).ok_or(Implausible)?;
        let there = difference(t3, t2).ok_or(Implausible)?;
        let round_trip = away.checked_sub(there).ok_or(Implausible)?;
        if there < 0 || round_trip < 0 || away > LONGEST_US {
            return Err(Implausible);
        }
        let (forth, back) = (difference(t2, t1).ok_or(Implausible)?, difference(t3, t4).ok_or(Implausible)?);
        // Halves first: the sum of two offsets may not fit.
        let offset_us = (forth / 2).saturating_add(back / 2).saturating_add((forth % 2 + back % 2) / 2);
        self.smooth(round_trip as f32);
        self.newest = Some([t1, t2, t3, t4]);
        let point = Point { at_us: t4, offset_us };
        if let Some((_, fastest)) = self.fastest
            && t4.saturating_sub(self.block_began_us) >= BLOCK_US
        {
            self.close_block(fastest);
        }
        if self.fastest.is_none() {
            self.block_began_us = t4;
        }
        if self.fastest.is_none_or(|(fastest, _)| round_trip <= fastest) {
            self.fastest = Some((round_trip, point));
            if self.points == 0 {
                self.offset = Some(point);
            }
        }
        Ok(u32::try_from(round_trip).unwrap_or(u32::MAX))
    }

    /// RFC 6298 §2: α = 1/8, β = 1/4.
    fn smooth(&mut self, sample: f32) {
        let Some(smoothed) = &mut self.round_trip_us else {
            (self.round_trip_us, self.jitter_us) = (Some(sample), sample / 2.0);
            return;
        };
        let error = sample - *smoothed;
        self.jitter_us += (error.abs() - self.jitter_us) / 4.0;
        *smoothed += error / 8.0;
    }

    fn close_block(&mut self, point: Point) {
        self.fastest = None;
        self.line.rotate_left(1);
        let [.., last] = &mut self.line;
        *last = point;
        self.points = (self.points + 1).min(LINE);
        self.offset = Some(point);
        if self.points >= LEAST
            && let Some((slope, above)) = self.fit(point)
        {
            self.drift = slope;
            self.offset = Some(Point { offset_us: point.offset_us.saturating_add(above as i64), ..point });
        }
    }

    /// The line through the points: its slope, and how far above `origin` it passes there. Relative to `origin`, so that
    /// nothing is large; none if the slope is not one that a clock could have.
    fn fit(&self, origin: Point) -> Option<(f64, f64)> {
        let points = || {
            self.line.iter().skip(LINE - self.points).map(|point| {
                let before = origin.at_us.saturating_sub(point.at_us) as f64;
                (-before, point.offset_us.saturating_sub(origin.offset_us) as f64)
            })
        };
        let count = self.points as f64;
        let (mean_x, mean_y) = points().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
        let (xx, xy) = points()
            .fold((0.0, 0.0), |(xx, xy), (x, y)| (xx + (x - mean_x) * (x - mean_x), xy + (x - mean_x) * (y - mean_y)));
        let slope = xy / xx;
        (slope * 1e6 <= MOST_PPM && slope * 1e6 >= -MOST_PPM).then_some((slope, mean_y - slope * mean_x))
    }

    /// The four times of the newest sample that was believed, t1 to t4, µs: for who keeps them all.
    pub fn newest(&self) -> Option<[u64; 4]> {
        self.newest
    }

    /// Smoothed round trip, µs.
    pub fn round_trip_us(&self) -> Option<u32> {
        self.round_trip_us.map(|us| us as u32)
    }

    /// Mean deviation of the round trip, µs.
    pub fn jitter_us(&self) -> u32 {
        self.jitter_us as u32
    }

    /// The other clock minus ours at `now`, µs, carried on from the last 2 s by the drift.
    pub fn offset_us(&self, now: u64) -> Option<i64> {
        self.offset.map(|point| {
            let since = now.saturating_sub(point.at_us) as f64;
            point.offset_us.saturating_add((since * self.drift) as i64)
        })
    }

    /// How much faster the other clock runs than ours, ppm; 0 until it is known.
    pub fn drift_ppm(&self) -> f32 {
        (self.drift * 1e6) as f32
    }

    /// How long to wait for an answer before asking again, µs: round trip and four times its jitter, from `least`
    /// to 500 ms; 100 ms while nothing is known.
    pub fn timeout_us(&self, least: u64) -> u64 {
        let wait = self.round_trip_us.map_or(100_000, |us| (us + 4.0 * self.jitter_us) as u64);
        wait.max(least).min(500_000)
    }
}

/// `later − earlier`, if it fits with room to spare.
fn difference(later: u64, earlier: u64) -> Option<i64> {
    i64::try_from(i128::from(later) - i128::from(earlier)).ok()
}
