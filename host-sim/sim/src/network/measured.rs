//! [`Measured`]: what round trips between two ends say of each direction.

use super::clocks::{Clocks, Trip};

/// One copy of a packet that arrives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// Time on top of the constant delay, ns.
    pub delay_ns: u64,
    /// Whether its bits differ from those sent.
    pub corrupt: bool,
}

/// What became of a round trip.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoundTrip {
    /// Lost there; lost back.
    pub(super) lost: [bool; 2],
    /// There and back, ns, by two clocks; may be below 0.
    pub(super) delay_ns: Option<[i64; 2]>,
}

/// What a measurement found beside what became of packets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// Half of the quickest round trip, ns.
    pub constant_ns: u64,
    /// How often one of its two clocks was set.
    pub clock_steps: usize,
    /// By how much the other clock was faster, ppm.
    pub clock_drift_ppm: f64,
}

/// What a measurement says.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    /// Of each direction, what became of a packet in each interval.
    pub(super) packets: [Vec<Vec<Arrival>>; 2],
    /// The interval, ns.
    pub(super) every_ns: u64,
    pub(super) found: Found,
}

/// Longest delay that is taken, ns: 10,000 s.
const LONGEST_NS: u64 = 10_000_000_000_000;

impl Measured {
    /// From a round trip an interval (ns). A delay is less the least of its direction. The delay of a direction of which nothing is known is as
    /// it was the round trip before.
    ///
    /// # Errors
    /// The number of the first round trip that is not possible, and why not; no number, if none came back.
    pub(super) fn of(every_ns: u64, trips: &[RoundTrip]) -> Result<Self, (Option<usize>, &'static str)> {
        let timed = |(at, trip): (usize, &RoundTrip)| {
            let at_ns = (at as u64).saturating_mul(every_ns).cast_signed();
            trip.delay_ns.map(|[there_ns, back_ns]| Trip { at_ns, there_ns, back_ns })
        };
        let timed: Vec<Trip> = trips.iter().enumerate().filter_map(timed).collect();
        let clocks = Clocks::of(&timed).ok_or((None, "no round trip came back"))?;
        let mut delays = clocks.delays_ns.iter();
        let mut packets = [Vec::new(), Vec::new()];
        let mut last_ns = [0_u64; 2];
        for (at, trip) in trips.iter().enumerate() {
            if trip.delay_ns.is_some() {
                last_ns = delays.next().copied().unwrap_or_default();
            } else if trip.lost == [false; 2] {
                return Err((Some(at), "it is not lost and has no delay"));
            }
            if last_ns.iter().any(|delay| *delay > LONGEST_NS) {
                return Err((Some(at), "a delay is longer than 10000 s"));
            }
            for ((half, lost), delay_ns) in packets.iter_mut().zip(trip.lost).zip(last_ns) {
                half.push(if lost { Vec::new() } else { vec![Arrival { delay_ns, corrupt: false }] });
            }
        }
        let constant_ns = (clocks.quickest_ns / 2).max(0).unsigned_abs();
        let found = Found { constant_ns, clock_steps: clocks.steps, clock_drift_ppm: clocks.drift_ppm };
        Ok(Self { packets, every_ns, found })
    }
}
