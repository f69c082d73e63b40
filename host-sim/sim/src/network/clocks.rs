//! [`Clocks`]: by how much the two clocks of a measurement differ, whatever steps and drifts.
//!
//! Two clocks that differ by θ make one way of a round trip longer by θ and the other one shorter. Half the difference of the two ways is
//! therefore θ and a constant, to within half of what the round trip took longer than the quickest one, wherever its packets were held up.
//! θ is drawn as straight lines, each as long as no round trip contradicts it: a line that ends is a step of a clock, a slope is a drift.
//! A flat line is taken where one is possible, else the middle of all slopes that are.
//!
//! The quickest round trip may itself have been held up. Each bound is therefore wider by the median of what the quickest round trips of
//! 16 parts of the measurement took longer than the quickest of all.

/// Parts of a measurement whose quickest round trips are compared.
const PARTS: usize = 16;
/// Error of a time stamp, ns.
const STAMP_NS: f64 = 50_000.0;
/// How much faster or slower a clock may run than the other: the most by which Linux slews one.
const FASTEST: f64 = 5e-4;

/// A round trip, by two clocks.
#[derive(Clone, Copy, Debug)]
pub struct Trip {
    /// When it began, ns.
    pub at_ns: i64,
    /// There, ns: θ is in it.
    pub there_ns: i64,
    /// Back, ns: less θ.
    pub back_ns: i64,
}

/// How the clock at the other end differs from one's own, and what it leaves of round trips.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clocks {
    /// Each round trip there and back without what clocks do to it, less the least of its direction, ns.
    pub delays_ns: Vec<[u64; 2]>,
    /// How often one of the two was set.
    pub steps: usize,
    /// By how much it was faster while neither was set, over the longest such time, ppm.
    pub drift_ppm: f64,
    /// The quickest round trip, ns.
    pub quickest_ns: i64,
}

/// Possible lines, a convex polygon of (slope, ns at the line's beginning).
type Lines = Vec<[f64; 2]>;

impl Clocks {
    /// From round trips in order; none from none.
    pub fn of(trips: &[Trip]) -> Option<Self> {
        let round = |trip: &Trip| trip.there_ns.saturating_add(trip.back_ns);
        let apart = |trip: &Trip| i128::from(trip.there_ns) - i128::from(trip.back_ns);
        let first = trips.first()?;
        let quickest_of = |some: &[Trip]| some.iter().map(round).min();
        let mut parts: Vec<i64> = trips.chunks(trips.len().div_ceil(PARTS)).filter_map(quickest_of).collect();
        parts.sort_unstable();
        let quickest_ns = parts[0];
        let longer = |than_quickest: i64| than_quickest.saturating_sub(quickest_ns) as f64;
        let slack = STAMP_NS + longer(parts[parts.len() / 2]);
        let middle = |trip: &Trip| 0.5 * (apart(trip) - apart(first)) as f64;
        let (mut found, mut longest, mut from) = (Self { quickest_ns, ..Self::default() }, 0.0, 0);
        let mut straight: Vec<[i64; 2]> = Vec::with_capacity(trips.len());
        while from < trips.len() {
            let since = |trip: &Trip| trip.at_ns.saturating_sub(trips[from].at_ns) as f64;
            let mut lines = Lines::new();
            let mut agrees = |trip: &&Trip| {
                let (at, wide) = (since(trip), 0.5 * longer(round(trip)) + slack);
                let [low, high] = [middle(trip) - wide, middle(trip) + wide];
                let left = if lines.is_empty() {
                    vec![[-FASTEST, low], [FASTEST, low], [FASTEST, high], [-FASTEST, high]]
                } else {
                    let below = cut(&lines, |[slope, offset]| slope * at + offset - high);
                    cut(&below, |[slope, offset]| low - slope * at - offset)
                };
                let some = !left.is_empty();
                if some {
                    lines = left;
                }
                some
            };
            let until = from + trips[from..].iter().take_while(&mut agrees).count();
            let [slope, offset] = likeliest(&lines);
            straight.extend(trips[from..until].iter().map(|trip| {
                let ahead = (slope * since(trip) + offset).round() as i64;
                [trip.there_ns.saturating_sub(ahead), trip.back_ns.saturating_add(ahead)]
            }));
            if since(&trips[until - 1]) >= longest {
                (longest, found.drift_ppm) = (since(&trips[until - 1]), 1e6 * slope);
            }
            found.steps += usize::from(until < trips.len());
            from = until;
        }
        let least = [0, 1].map(|way| straight.iter().map(|delays| delays[way]).min().unwrap_or(0));
        let more = |delays: &[i64; 2]| [0, 1].map(|way| delays[way].saturating_sub(least[way]).unsigned_abs());
        found.delays_ns = straight.iter().map(more).collect();
        Some(found)
    }
}

/// What is left of a convex polygon where `beyond` is at most 0.
fn cut(lines: &[[f64; 2]], beyond: impl Fn([f64; 2]) -> f64) -> Lines {
    let mut left = Lines::with_capacity(lines.len() + 1);
    for (one, other) in lines.iter().zip(lines.iter().cycle().skip(1)) {
        let [here, there] = [*one, *other].map(&beyond);
        if here <= 0.0 {
            left.push(*one);
        }
        if here * there < 0.0 {
            left.push(between(*one, *other, here / (here - there)));
        }
    }
    left
}

fn between(one: [f64; 2], other: [f64; 2], share: f64) -> [f64; 2] {
    [0, 1].map(|at| one[at] + share * (other[at] - one[at]))
}

/// The middle of the flat lines, or of those with the least and the largest slope.
fn likeliest(lines: &[[f64; 2]]) -> [f64; 2] {
    let edges = lines.iter().zip(lines.iter().cycle().skip(1));
    let flat: Lines = edges
        .filter(|(one, other)| one[0] * other[0] < 0.0)
        .map(|(one, other)| between(*one, *other, one[0] / (one[0] - other[0])))
        .collect();
    let of = if flat.is_empty() { lines } else { &flat };
    let order = |one: &&[f64; 2], other: &&[f64; 2]| one[0].total_cmp(&other[0]).then(one[1].total_cmp(&other[1]));
    let ends = of.iter().min_by(order).zip(of.iter().max_by(order));
    ends.map_or([0.0; 2], |(least, most)| between(*least, *most, 0.5))
}
