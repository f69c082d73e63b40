//! The search between points, on costs whose least is known.

use super::*;

/// A try, and where its gains lie: what they are where nothing is set.
#[derive(Clone, Debug, PartialEq)]
struct Place {
    number: usize,
    gains: String,
    at: [f64; 2],
}

/// Own values: far from the best ones.
const OWN: [f64; 2] = [150.0, 40.0];
/// Where the cost is least, and what it is there.
const BEST: [f64; 2] = [7000.0, 3.0];

impl Tried for Place {
    fn gains(&self) -> &str {
        &self.gains
    }

    /// A bowl over ratios; beyond a bound of the first gain nothing may be taken.
    fn cost(&self, bound: f64) -> f64 {
        let far: f64 = self.at.iter().zip(BEST).map(|(at, best)| (at / best).ln().powi(2)).sum();
        if self.at[0] > bound { 1e6 * self.at[0] } else { far }
    }
}

fn searched(budget: usize, bounds: &[f64]) -> Vec<Place> {
    let gains = [("k", [1e2, 1e5], false), ("b", [1.0, 50.0], true)];
    let gains = gains.map(|(key, ends, whole)| Gain { key: key.to_owned(), ends, whole });
    let search = Around { gains: &gains, own: &OWN, bounds, budget, seed: 3 };
    let attempt = |number: usize, gains: String| {
        let of =
            |key: &str| gains.split(' ').find_map(|setting| setting.strip_prefix(key)?.strip_prefix('=')?.parse().ok());
        let at = [of("k").unwrap_or(OWN[0]), of("b").unwrap_or(OWN[1])];
        Ok(Place { number, gains, at })
    };
    search.search(&attempt).expect("tries")
}

/// The least is where it is known to be, nearer than spread points alone come, and within a bound that leaves it out at the bound.
#[test]
fn the_least_is_found_within_each_bound() {
    let bounds = [2000.0, 1e9];
    let tried = searched(240, &bounds);
    let cost = |tried: &[Place]| best(tried, 1e9).expect("a best").cost(1e9);
    let [bound, free] = bounds.map(|bound| best(&tried, bound).expect("a best").at);
    assert!((free[0] / BEST[0] - 1.0).abs() < 0.05 && free[1] == BEST[1], "{free:?}");
    assert!((1800.0..=2000.0).contains(&bound[0]) && bound[1] == BEST[1], "{bound:?}");
    assert!(cost(&tried) < 0.1 * cost(&tried[..120]), "{} of {}", cost(&tried), cost(&tried[..120]));
}

/// Any budget is spent to the last try, the first of which sets nothing, and all others everything, within the ends.
#[test]
fn a_budget_is_spent_and_begins_as_it_is() {
    for budget in [1, 2, 3, 7, 24] {
        let tried = searched(budget, &[1e9]);
        assert!(tried.iter().map(|one| one.number).eq(0..budget), "{budget}");
        assert_eq!((tried[0].gains.as_str(), tried[0].at), ("", OWN));
        for one in &tried[1..] {
            let [k, b] = one.at;
            assert!(one.gains.contains("k=") && (1e2..=1e5).contains(&k) && (1.0..=50.0).contains(&b), "{one:?}");
            assert_eq!(b.fract(), 0.0, "a whole number");
        }
    }
}

#[test]
fn threads_change_nothing() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
        pool.install(|| searched(60, &[2000.0, 1e9]))
    };
    assert_eq!(on(1), on(2));
}
