//! Clocks whose offset, drift and network are known.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::{Exchange, Relation, Watched};

/// Two clocks and the ways between them.
#[derive(Clone, Copy, Debug)]
struct Truth {
    offset_s: f64,
    drift: f64,
    /// Least delay there and back, s.
    least_s: [f64; 2],
    /// Mean of what comes on top, exponential, s.
    jitter_s: f64,
    seconds: f64,
}

const LAN: Truth = Truth { offset_s: -86_400.25, drift: 4e-5, least_s: [120e-6; 2], jitter_s: 300e-6, seconds: 60.0 };

impl Truth {
    /// Offset at a time of one's own clock, s.
    fn at(&self, own_s: f64) -> f64 {
        self.offset_s + self.drift * own_s
    }

    /// An exchange each 64 ms, all stamps in whole microseconds.
    fn exchanges(&self, seed: u64) -> Vec<Exchange> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut late = |least_s: f64| {
            let unit = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
            least_s - self.jitter_s * (1.0 - unit).ln()
        };
        let us = |s: f64| (1e6 * s).floor() * 1e-6;
        let one = |at: usize| {
            let t1 = 5.0 + 0.064 * at as f64;
            let came = t1 + late(self.least_s[0]);
            let left = came + 0.0007;
            let t4 = left + late(self.least_s[1]);
            let other = |own_s: f64| own_s + self.at(own_s);
            Exchange { times_s: [us(t1), us(other(came)), us(other(left)), us(t4)] }
        };
        (0..(self.seconds / 0.064) as usize).map(one).collect()
    }
}

/// How far a relation is off at the beginning, the middle and the end, and how far it says that it may be.
fn off(truth: &Truth, relation: &Relation) -> [(f64, f64); 3] {
    [5.0, 5.0 + 0.5 * truth.seconds, 5.0 + truth.seconds]
        .map(|at| ((relation.offset_s(at) - truth.at(at)).abs(), relation.error_s(at)))
}

#[test]
fn on_a_lan_it_is_far_below_a_tenth_of_a_millisecond() {
    for seed in 0..50 {
        let relation = Relation::of(&LAN.exchanges(seed)).expect("exchanges");
        for (off_s, error_s) in off(&LAN, &relation) {
            assert!(off_s < 40e-6 && off_s < error_s, "{seed}: off by {off_s} s, said {error_s} s");
            assert!((120e-6..250e-6).contains(&error_s), "half of the round trip of 240 µs and some: {error_s} s");
        }
        let drift_off = (relation.drift - LAN.drift).abs();
        assert!(drift_off < relation.drift_error() && relation.drift_error() < 15e-6, "{seed}: {relation:?}");
    }
}

/// Ways that differ: half of the difference is there, is not seen, and is within what was said.
#[test]
fn what_nobody_can_see_is_within_the_error() {
    let truth = Truth { least_s: [100e-6, 700e-6], ..LAN };
    for seed in 0..50 {
        let relation = Relation::of(&truth.exchanges(seed)).expect("exchanges");
        for (off_s, error_s) in off(&truth, &relation) {
            assert!((260e-6..340e-6).contains(&off_s) && off_s < error_s, "{seed}: {off_s} s, said {error_s} s");
        }
    }
}

/// Bad networks, short runs, large drifts: never more wrong than it says.
#[test]
fn it_is_never_more_wrong_than_it_says() {
    for (drift, jitter_s, seconds, least_s) in [
        (0.0, 0.0, 10.0, [10e-6; 2]),
        (-1.9e-4, 0.02, 60.0, [0.03, 0.03]),
        (1e-4, 0.2, 20.0, [0.001, 0.004]),
        (9e-5, 0.001, 0.7, [200e-6; 2]),
        (5e-5, 0.003, 600.0, [50e-6, 20e-6]),
    ] {
        let truth = Truth { drift, jitter_s, seconds, least_s, ..LAN };
        for seed in 0..50 {
            let exchanges = truth.exchanges(seed);
            let relation = Relation::of(&exchanges).expect("exchanges");
            for (off_s, error_s) in off(&truth, &relation) {
                assert!(off_s < error_s, "{truth:?} {seed}: off by {off_s} s, said {error_s} s");
            }
            // There and back again, and from the other side, it is the same.
            let at = 5.0 + 0.3 * seconds;
            assert!((relation.own_s(at + relation.offset_s(at)) - at).abs() < 1e-9);
            let turned: Vec<_> = exchanges.iter().map(|exchange| exchange.turned()).collect();
            let back = Relation::of(&turned).expect("exchanges");
            let both = back.offset_s(at + relation.offset_s(at)) + relation.offset_s(at);
            assert!(both.abs() < 2e-6 + 0.1 * relation.error_s(at), "{both} s");
        }
    }
}

/// While it runs, from the last minute alone: the clock changes its rate, and a minute later it is known again.
#[test]
fn a_clock_that_changes_its_rate_is_followed() {
    let slow = Truth { seconds: 240.0, ..LAN };
    let fast = Truth { drift: -2e-5, offset_s: LAN.offset_s + 6e-5 * 125.0, ..slow };
    let before = slow.exchanges(7).into_iter().filter(|one| one.times_s[0] < 125.0);
    let after = fast.exchanges(8).into_iter().filter(|one| one.times_s[0] >= 125.0);
    let mut watched = Watched::default();
    for exchange in before.chain(after) {
        watched.see(Some(exchange.times_s.map(|s| (1e6 * (s + 100_000.0)).round() as u64)));
    }
    watched.look();
    let relation = watched.relation.expect("exchanges");
    assert!((relation.drift - fast.drift).abs() < 2e-6, "{relation:?}");
}

/// One early exchange that is quicker than all that follow tells the offset then; the drift is told by those that follow.
#[test]
fn one_quick_exchange_does_not_decide_the_drift() {
    let quick = Truth { seconds: 0.07, jitter_s: 1e-6, ..LAN };
    let slow = Truth { seconds: 300.0, least_s: [0.02; 2], jitter_s: 0.001, ..LAN };
    for seed in 0..50 {
        let exchanges: Vec<_> = quick.exchanges(seed).into_iter().chain(slow.exchanges(seed).split_off(2)).collect();
        let relation = Relation::of(&exchanges).expect("exchanges");
        for (off_s, error_s) in off(&slow, &relation) {
            assert!(off_s < 1e-3 && off_s < error_s, "{seed}: off by {off_s} s, said {error_s} s");
        }
    }
}

#[test]
fn nothing_is_known_of_nothing() {
    assert_eq!(Relation::of(&[]), None);
    let mut watched = Watched::default();
    watched.look();
    assert_eq!((watched.see(None), watched.relation), (None, None));
    // One alone is within half of its round trip and what two quartzes may do until then.
    let one = Exchange::of_us([1_000_000, 5_000_100, 5_000_200, 1_000_400]);
    let relation = Relation::of(&[one]).expect("an exchange");
    assert!((relation.offset_s(1.0002) - 3.999_95).abs() < 1e-9 && relation.drift == 0.0);
    assert!((150e-6..170e-6).contains(&relation.error_s(1.0002)) && relation.error_s(11.0) > 1e-3, "{relation:?}");
}

/// What an onlooker makes of the delays, s there and back, at a time, s; none where the exchange is lost.
type Delays<'a> = &'a mut dyn FnMut(f64) -> Option<[f64; 2]>;

/// Exchanges each 64 ms for so long, s, between clocks of this offset and drift, with an onlooker on both ways.
fn attacked(truth: &Truth, delays: Delays<'_>) -> Vec<Exchange> {
    let one = |at: usize| {
        let t1 = 5.0 + 0.064 * at as f64;
        let [there, back] = delays(t1 - 5.0)?;
        let (came, left) = (t1 + there, t1 + there + 0.0007);
        let other = |own_s: f64| own_s + truth.at(own_s);
        Some(Exchange { times_s: [t1, other(came), other(left), left + back] })
    };
    (0..(truth.seconds / 0.064) as usize).filter_map(one).collect()
}

/// Nowhere, and up to a minute after the last exchange, is a relation more wrong than it says.
fn holds(truth: &Truth, exchanges: &[Exchange], what: &dyn std::fmt::Debug) {
    let Some(relation) = Relation::of(exchanges) else {
        assert!(exchanges.is_empty(), "{what:?}: clocks that run evenly have a relation");
        return;
    };
    assert!((relation.drift - truth.drift).abs() <= relation.drift_error() + 1e-12, "{what:?}: {}", relation.drift);
    for at in 0..120 {
        let own_s = 3.0 + at as f64 * (truth.seconds + 60.0) / 120.0;
        let (off_s, error_s) = ((relation.offset_s(own_s) - truth.at(own_s)).abs(), relation.error_s(own_s));
        assert!(off_s <= error_s, "{what:?}: at {own_s} s off by {off_s} s, said {error_s} s");
        let back_s = (relation.own_s(own_s + truth.at(own_s)) - own_s).abs();
        assert!(back_s <= 1.001 * error_s, "{what:?}: at {own_s} s back by {back_s} s, said {error_s} s");
    }
}

/// The difference of the ways slides by 20 ms in 5 s while the round trip stays as it is, and then nothing comes any more.
#[test]
fn a_slid_difference_of_the_ways_is_within_the_error() {
    let truth = Truth { drift: 3e-6, seconds: 30.0, ..LAN };
    for (from_s, to_s) in [(0.0, 5.0), (10.0, 15.0)] {
        for sign in [1.0, -1.0] {
            let mut slid = |at_s: f64| {
                let part = ((at_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0);
                (at_s < to_s).then_some([0.0102 + sign * 0.01 * part, 0.0102 - sign * 0.01 * part])
            };
            holds(&truth, &attacked(&truth, &mut slid), &(from_s, to_s, sign));
        }
    }
}

/// An onlooker who chooses each delay, and which exchanges are lost: at random, in stretches of which each has its aim.
#[test]
fn the_error_holds_whoever_chooses_every_delay() {
    for seed in 0..2_000 {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut unit = move || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let truth = Truth {
            offset_s: 1e4 * (unit() - 0.5),
            drift: 4e-4 * (unit() - 0.5),
            seconds: 0.2 + 59.0 * unit() * unit(),
            ..LAN
        };
        let (mut until_s, mut aim, mut from) = (0.0, [[0.0; 2]; 2], 0.0);
        let mut lost = 0.0;
        let mut chosen = |at_s: f64| {
            if at_s >= until_s {
                from = at_s;
                until_s = at_s + 0.1 + 8.0 * unit();
                aim[0] = aim[1];
                let most = [1e-4, 1e-2, 0.2][(3.0 * unit()) as usize];
                aim[1] = [most * unit(), most * unit()];
                lost = if unit() < 0.3 { 1.0 } else { 0.2 * unit() };
            }
            let part = (at_s - from) / (until_s - from);
            let jitter_s = if unit() < 0.5 { 0.0 } else { 0.01 * unit() };
            let delays = [0, 1].map(|way| aim[0][way] + part * (aim[1][way] - aim[0][way]) + jitter_s * unit());
            (unit() >= lost).then_some(delays)
        };
        holds(&truth, &attacked(&truth, &mut chosen), &(seed, truth));
    }
}

/// Nobody's clock runs away by more than 200 ppm: there is no relation, instead of one that is wrong.
#[test]
fn a_drift_that_no_clock_has_is_refused() {
    for drift in [4e-3, -4e-3, 3e-4] {
        let truth = Truth { drift, ..LAN };
        assert_eq!(Relation::of(&truth.exchanges(1)), None, "{drift}");
    }
}
