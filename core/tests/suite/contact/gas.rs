//! Many bodies, many impacts in every step, against solutions that know nothing of impacts.

use cohold_core::contact::impact::{Body, Wall, advance};
use cohold_core::num::Scalar;

use super::setup::{Random, body, energy, mass, momentum};

/// Where a point that goes to and fro between 0 and `length` is.
fn to_and_fro(x: f64, length: f64) -> f64 {
    let x = x.rem_euclid(2.0 * length);
    if x > length { 2.0 * length - x } else { x }
}

/// Equal masses on a line swap velocities when they meet, as if they went through each other: at any time the places are
/// those of points that do, in order. Up to dozens of impacts in a step.
#[test]
fn equal_masses_on_a_line_are_ghosts_that_pass() {
    const COUNT: usize = 5;
    let (radius, length) = (0.001, 0.04);
    let free = length - 2.0 * radius * COUNT as f64;
    let walls = [Wall { normal: [1.0], offset: 0.0 }, Wall { normal: [-1.0], offset: -length }];
    let mut random = Random(6);
    let mut impacts = 0;
    for _ in 0..200 {
        let mut ghosts: [(f64, f64); COUNT] =
            core::array::from_fn(|_| (free * random.unit(), random.between(-30.0, 30.0)));
        ghosts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let place = |at: usize, ghost: f64| ghost + (2 * at + 1) as f64 * radius;
        let mut at = 0;
        let mut bodies = ghosts.map(|(x, v)| {
            at += 1;
            body::<f64, 1>([place(at - 1, x)], [v], radius, 0.05)
        });
        for tick in 1..=100 {
            let account = advance(&mut bodies, &walls, 1.0, 1e-3);
            assert_eq!(account.stood_s, 0.0);
            impacts += account.impacts;
            let mut places = ghosts.map(|(x, v)| to_and_fro(x + v * 1e-3 * f64::from(tick), free));
            places.sort_by(f64::total_cmp);
            for (at, (body, ghost)) in bodies.iter().zip(places).enumerate() {
                let wrong = body.axes[0].position - place(at, ghost);
                assert!(wrong.abs() < 1e-11, "body {at} at tick {tick} is wrong by {wrong}");
            }
        }
    }
    assert!(impacts > 100_000, "{impacts}");
}

/// What energy may walk by in `impacts` roundings of this size.
fn walk(half_unit: f64, impacts: u32) -> f64 {
    2.0 * half_unit * f64::from(impacts).sqrt()
}

/// Half a unit in the last place, relative.
const SINGLE: f64 = f32::EPSILON as f64 / 2.0;
const DOUBLE: f64 = f64::EPSILON / 2.0;

/// Galperin (2003): a mass 100ⁿ times as heavy drives a small one against a wall; their impacts count the digits of π.
fn count_digits<S: Scalar>(counts: &[u32], half_unit: f64) {
    for (n, &digits) in (0..).zip(counts) {
        let mut bodies = [body::<S, 1>([1e-3], [0.0], 1e-4, 1.0), body([2e-3], [-1.0], 1e-4, 100_f64.powi(n))];
        let wall = [Wall { normal: [S::ONE], offset: S::ZERO }];
        let (mut impacts, before) = (0, energy(&bodies));
        for _ in 0..1000 {
            impacts += advance(&mut bodies, &wall, S::ONE, S::from_f64(1e-3)).impacts;
        }
        assert_eq!(impacts, digits, "100^{n} in {}", S::NAME);
        assert!((energy(&bodies) / before - 1.0).abs() <= walk(half_unit, impacts), "100^{n} in {}", S::NAME);
    }
}

#[test]
fn impacts_count_the_digits_of_pi() {
    count_digits::<f64>(&[3, 31, 314, 3141, 31415], DOUBLE);
    count_digits::<f32>(&[3, 31, 314], SINGLE);
}

/// A gas in a box, a million impacts in a row: energy after n of them walks by 2·√n half units in the last place at most,
/// and every body's momentum is what it was and the impulses that it took. The shares of a pair of masses are rounded
/// alike at every impact; were they two rounded numbers, energy would not walk but drift, to 7·√n and more by then.
fn box_of_gas<S: Scalar>(seed: u64, half_unit: f64) {
    const COUNT: usize = 6;
    let mut random = Random(seed);
    let mut at = 0.0;
    let mut bodies: [Body<S, 2>; COUNT] = core::array::from_fn(|_| {
        at += 0.015;
        body([at, 0.05], [random.between(-5.0, 5.0), random.between(-5.0, 5.0)], 0.006, random.scale(0.05, 0.5))
    });
    let wall = |x: f64, y: f64, offset: f64| Wall { normal: [x, y].map(S::from_f64), offset: S::from_f64(offset) };
    let walls = [wall(1.0, 0.0, 0.0), wall(-1.0, 0.0, -0.1), wall(0.0, 1.0, 0.0), wall(0.0, -1.0, -0.1)];
    let start = bodies;
    let (mut steps, mut impacts, mut passed) = (0, 0, [[0.0; 2]; COUNT]);
    while impacts < 1_000_000 {
        let account = advance(&mut bodies, &walls, S::ONE, S::from_f64(1e-2));
        assert_eq!(account.stood_s, S::ZERO);
        (steps, impacts) = (steps + 1, impacts + account.impacts);
        for (sum, impulse) in passed.iter_mut().flatten().zip(account.impulses.into_iter().flatten()) {
            *sum += impulse.to_f64();
        }
        for (at, body) in bodies.iter().enumerate() {
            let [x, y] = body.axes.map(|axis| axis.position.to_f64());
            assert!((0.0059..0.0941).contains(&x) && (0.0059..0.0941).contains(&y), "body {at} left the box");
            for other in &bodies[at + 1..] {
                let [ox, oy] = other.axes.map(|axis| axis.position.to_f64());
                assert!((x - ox).hypot(y - oy) > 0.01199, "two bodies overlap");
            }
        }
        let wrong = energy(&bodies) / energy(&start) - 1.0;
        assert!(wrong.abs() <= walk(half_unit, impacts), "seed {seed}, {}: {wrong} after {impacts}", S::NAME);
    }
    for ((body, was), passed) in bodies.iter().zip(&start).zip(passed) {
        for ((now, then), passed) in body.axes.iter().zip(&was.axes).zip(passed) {
            let gained = mass(body) * (now.velocity.to_f64() - then.velocity.to_f64());
            let wrong = (gained - passed).abs() / momentum(&start, 0).1;
            assert!(wrong <= walk(half_unit, impacts), "seed {seed}, {}: {wrong}", S::NAME);
        }
    }
    assert!(impacts > 4 * steps, "several in a step: {impacts} in {steps}");
}

#[test]
fn a_million_impacts_in_a_row_walk_and_do_not_drift() {
    for seed in 7..10 {
        box_of_gas::<f64>(seed, DOUBLE);
        box_of_gas::<f32>(seed, SINGLE);
    }
}
