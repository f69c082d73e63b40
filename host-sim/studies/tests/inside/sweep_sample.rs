//! Samples against what was published of them and against closed forms.

use super::*;

/// A sample of numbers from 0 to 1 in so many keys.
fn sample(design: Design, points: usize, keys: usize, seed: u32) -> Sample {
    let spread = |key| format!("table.key_{key}=0..1").parse().expect("a range");
    Sample::new(design, points, seed, (0..keys).map(spread).collect()).expect("a sample")
}

/// Every point of a sample.
fn points(sample: &Sample) -> Vec<Vec<f64>> {
    let keys = sample.spreads.len();
    (0..sample.points).map(|index| (0..keys).map(|key| sample.place(key, index)).collect()).collect()
}

/// The square of the L2 star discrepancy (Warnock 1972).
fn discrepancy(points: &[Vec<f64>]) -> f64 {
    let (count, keys) = (points.len() as f64, points[0].len() as i32);
    let alone: f64 = points.iter().map(|point| point.iter().map(|x| 1.0 - x * x).product::<f64>()).sum();
    let pair = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| 1.0 - a.max(*b)).product::<f64>();
    let pairs: f64 = points.iter().map(|a| points.iter().map(|b| pair(a, b)).sum::<f64>()).sum();
    3.0_f64.powi(-keys) - 2.0_f64.powi(1 - keys) / count * alone + pairs / (count * count)
}

/// Of independent random points: (2⁻ᵈ − 3⁻ᵈ)/N on average.
fn of_random_points(count: usize, keys: i32) -> f64 {
    (2.0_f64.powi(-keys) - 3.0_f64.powi(-keys)) / count as f64
}

/// The ten points that Joe and Kuo print for three dimensions.
#[test]
fn the_first_points_are_those_that_were_published() {
    let published = [
        [0.0, 0.0, 0.0],
        [0.5, 0.5, 0.5],
        [0.75, 0.25, 0.25],
        [0.25, 0.75, 0.75],
        [0.375, 0.375, 0.625],
        [0.875, 0.875, 0.125],
        [0.625, 0.125, 0.875],
        [0.125, 0.625, 0.375],
        [0.1875, 0.3125, 0.9375],
        [0.6875, 0.8125, 0.4375],
    ];
    for (index, point) in (0..).zip(published) {
        let got = [0, 1, 2].map(|key| f64::from(sobol(key, index)) * (-32.0_f64).exp2());
        assert_eq!(got, point, "point {index}");
    }
}

/// The table: every polynomial primitive and used once, every first number odd and below 2ᵏ, and all dimensions together with
/// Sobol's property A (the first bits of the first 21 direction numbers are independent), as Joe and Kuo made them.
#[test]
fn the_direction_numbers_are_ones() {
    let mut seen = std::collections::BTreeSet::new();
    for (degree, between, first) in DIMENSIONS {
        let polynomial = 1 << degree | between << 1 | 1;
        assert!(seen.insert(polynomial), "{polynomial:b} is there twice");
        let (mut power, mut order) = (1_u32, 0);
        loop {
            power <<= 1;
            power ^= if power >> degree == 1 { polynomial } else { 0 };
            order += 1;
            if power == 1 {
                break;
            }
        }
        assert_eq!(order, (1 << degree) - 1, "{polynomial:b} is not primitive");
        assert_eq!(first.len(), degree as usize);
        for (k, number) in first.iter().enumerate() {
            assert!(number % 2 == 1 && *number < 2 << k, "{first:?}");
        }
    }
    let mut rows: Vec<u32> =
        DIRECTIONS.iter().map(|numbers| (0..MOST_KEYS).map(|k| (numbers[k] >> 31) << k).sum()).collect();
    for bit in 0..MOST_KEYS {
        let pivot = (bit..MOST_KEYS).find(|row| rows[*row] >> bit & 1 == 1).expect("independent rows");
        rows.swap(bit, pivot);
        for row in bit + 1..MOST_KEYS {
            rows[row] ^= if rows[row] >> bit & 1 == 1 { rows[bit] } else { 0 };
        }
    }
}

/// One point in each of N parts of the range of every key.
#[test]
fn a_latin_hypercube_has_one_point_in_each_stratum() {
    for (count, seed) in [(1, 1), (7, 1), (1000, 2)] {
        let points = points(&sample(Design::LatinHypercube, count, 5, seed));
        for key in 0..5 {
            let mut parts: Vec<usize> = points.iter().map(|point| (point[key] * count as f64) as usize).collect();
            parts.sort_unstable();
            assert!(parts.into_iter().eq(0..count), "{count} points, key {key}");
        }
    }
    // And the keys are mixed: the correlation of two random orders of 1000 is 0 ± 1/√999.
    let points = points(&sample(Design::LatinHypercube, 1000, 2, 3));
    let product: f64 = points.iter().map(|point| (point[0] - 0.5) * (point[1] - 0.5)).sum();
    assert!((12.0 * product / 1000.0).abs() < 4.0 / 999.0_f64.sqrt(), "{product}");
}

/// The first 2ᵐ points have one in each of 2ᵐ parts of every key, and, in the first two keys, in each box of 2⁻ʲ by 2ʲ⁻ᵐ; the random shift
/// of the bits keeps that.
#[test]
fn sobols_points_are_a_net() {
    let sample = sample(Design::Sobol, 256, MOST_KEYS, 5);
    let points = points(&sample);
    for key in 0..MOST_KEYS {
        let mut parts: Vec<usize> = points.iter().map(|point| (point[key] * 256.0) as usize).collect();
        parts.sort_unstable();
        assert!(parts.into_iter().eq(0..256), "key {key}");
    }
    for wide in 0..=8 {
        let (columns, rows) = (1 << wide, 256 >> wide);
        let box_of = |point: &Vec<f64>| (point[0] * columns as f64) as usize * rows + (point[1] * rows as f64) as usize;
        let mut boxes: Vec<usize> = points.iter().map(box_of).collect();
        boxes.sort_unstable();
        assert!(boxes.into_iter().eq(0..256), "boxes of 1/{columns} by 1/{rows}");
    }
}

/// Sobol's points are far evener than random ones, a Latin hypercube's a little; and the formula is right: one point in the
/// middle of one key leaves ∫(⟦x > ½⟧ − x)² dx = 1/12.
#[test]
fn discrepancies() {
    assert!((discrepancy(&[vec![0.5]]) - 1.0 / 12.0).abs() < 1e-15);
    for seed in 1..=5 {
        let of = |design, keys| discrepancy(&points(&sample(design, 512, keys as usize, seed)));
        for keys in [2, 5] {
            let random = of_random_points(512, keys);
            let (sobol, latin) = (of(Design::Sobol, keys), of(Design::LatinHypercube, keys));
            assert!(sobol < random / if keys == 2 { 50.0 } else { 5.0 }, "{sobol} against {random}, {keys} keys");
            assert!(latin < random, "{latin} against {random}, {keys} keys");
        }
    }
}

/// Neither other points nor other keys move a point; another seed does.
#[test]
fn a_place_depends_on_seed_and_index() {
    let (few, many) = (sample(Design::Sobol, 10, 3, 7), sample(Design::Sobol, 1000, 5, 7));
    let (latin, more) = (sample(Design::LatinHypercube, 10, 3, 7), sample(Design::LatinHypercube, 10, 5, 7));
    for (key, index) in (0..3).flat_map(|key| (0..10).map(move |index| (key, index))) {
        assert_eq!(few.place(key, index), many.place(key, index));
        assert_eq!(latin.place(key, index), more.place(key, index));
    }
    for design in [Design::Sobol, Design::LatinHypercube] {
        let mut first: Vec<f64> = (0..100).map(|seed| sample(design, 10, 1, seed).place(0, 0)).collect();
        first.sort_by(f64::total_cmp);
        first.dedup();
        assert_eq!(first.len(), 100);
    }
}

/// Ranges at equal distances, at equal ratios, of whole numbers, and lists.
#[test]
fn values_of_ranges_and_lists() {
    let value = |text: &str, share| text.parse::<Spread>().expect("it is written so").value(share);
    assert_eq!(
        ["0.0", "2.5", "7.5"],
        [0.0, 0.25, 0.75].map(|share| value("a.b=0..10", share)).each_ref().map(String::as_str)
    );
    assert_eq!(value("a.b=1..10000:log", 0.5), "100.0");
    assert_eq!([0.0, 0.24, 0.25, 0.99].map(|share| value("a.b=2..5:whole", share)), ["2", "2", "3", "5"]);
    assert_eq!([0.0, 0.34, BELOW_1].map(|share| value("a.b=x,y,z", share)), ["x", "y", "z"]);
    for (wrong, says) in [
        ("a.b", "write it as TABLE.KEY=A..B, TABLE.KEY=A..B:log, TABLE.KEY=A..B:whole or TABLE.KEY=X,Y,Z"),
        ("a.b=1..2:3", "write it as"),
        ("a.b=0..2:log", "above 0"),
        ("a.b=2..1", "to a larger one"),
        ("a.b=0..1.5:whole", "whole numbers"),
        ("=1..2", "write it as"),
        ("a.b=1,,2", "write it as"),
    ] {
        let error = wrong.parse::<Spread>().expect_err(wrong).to_string();
        assert!(error.contains(says), "{wrong}: {error}");
    }
}
