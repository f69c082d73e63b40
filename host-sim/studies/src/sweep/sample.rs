//! Points spread over ranges, for a sweep of more keys than a grid can hold.
//!
//! | design | points |
//! |---|---|
//! | [`Design::LatinHypercube`] | of N points every key has one in each of N equal parts of its range, anywhere in it (McKay et al. 1979) |
//! | [`Design::Sobol`] | Sobol's sequence, moved by one random shift of the bits of each key; evenest where N is a power of two |
//!
//! **Where a point lies** depends on the seed and its index, for a Latin hypercube on N as well, and on nothing else: more points of
//! Sobol's sequence leave those that are there where they are. In a range a point lies at equal distances, at equal ratios, or on a
//! whole number; a list gives each of its values the same share.
//!
//! **Source** of the direction numbers: S. Joe and F. Y. Kuo, *Constructing Sobol sequences with better two-dimensional
//! projections*, SIAM J. Sci. Comput. 30, 2635–2654 (2008), the first [`MOST_KEYS`] dimensions of their table `new-joe-kuo-6.21201`.

use std::str::FromStr;

use cohold_sim::rng::Rng;

use super::axis::{MOST, ends, form};
use crate::Error;

/// Most keys of a sample.
pub const MOST_KEYS: usize = 21;

cohold_sim::choices! {
    /// How points are spread.
    Design {
        "latin-hypercube" => LatinHypercube, "One point in each of N parts of every range.";
        "sobol" => Sobol, "Points of Sobol's sequence, shifted by the seed.";
    }
}

/// A key and what its values are drawn from.
///
/// | written | values |
/// |---|---|
/// | `KEY=A..B` | numbers from A up to B |
/// | `KEY=A..B:log` | the same, equal ratios alike; A and B above 0 |
/// | `KEY=A..B:whole` | whole numbers from A to B, both included |
/// | `KEY=X,Y,Z` | these: numbers, `true` and `false`, names |
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Name of the key, `table.key`.
    pub key: String,
    /// As it was written.
    pub(super) text: String,
    over: Over,
}

#[derive(Clone, Debug, PartialEq)]
enum Over {
    Linear(f64, f64),
    Ratios(f64, f64),
    Whole(f64, f64),
    Listed(Vec<String>),
}

impl Spread {
    /// The value at this share of the range, 0 up to 1, as a scene file writes it.
    pub fn value(&self, share: f64) -> String {
        match &self.over {
            Over::Linear(first, last) => format!("{:?}", first + (last - first) * share),
            // libm: the same bits on every machine.
            Over::Ratios(first, last) => format!("{:?}", first * libm::pow(last / first, share)),
            Over::Whole(first, last) => format!("{}", first + ((last - first + 1.0) * share).floor()),
            Over::Listed(values) => values[(values.len() as f64 * share) as usize].clone(),
        }
    }

    /// The values of a list; none of a range.
    pub(super) fn listed(&self) -> &[String] {
        match &self.over {
            Over::Listed(values) => values,
            _ => &[],
        }
    }
}

impl FromStr for Spread {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let wrong = || form("A..B, A..B:log, A..B:whole");
        let (key, values) = text.split_once('=').ok_or_else(wrong)?;
        let (key, values) = (key.trim().to_owned(), values.trim());
        let over = match values.split_once("..") {
            Some((first, rest)) => {
                let (last, kind) = rest.split_once(':').map_or((rest, ""), |(last, kind)| (last, kind.trim()));
                let (first, last) = ends(first, last).ok_or_else(wrong)?;
                match kind {
                    _ if first >= last => return Err("a range goes from a number to a larger one".into()),
                    "" => Over::Linear(first, last),
                    "log" if first <= 0.0 => return Err("equal ratios need ends above 0".into()),
                    "log" => Over::Ratios(first, last),
                    "whole" if first.fract() == 0.0 && last.fract() == 0.0 => Over::Whole(first, last),
                    "whole" => return Err("whole numbers need ends that are whole numbers".into()),
                    _ => return Err(wrong().into()),
                }
            }
            None => Over::Listed(values.split(',').map(|value| value.trim().to_owned()).collect()),
        };
        let spread = Self { key, text: text.trim().to_owned(), over };
        let empty = spread.key.is_empty() || spread.listed().iter().any(String::is_empty);
        if empty { Err(wrong().into()) } else { Ok(spread) }
    }
}

/// Points over the ranges of several keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// How they are spread.
    pub design: Design,
    /// Number of points to spread.
    pub points: usize,
    /// Seed of the shift, or of the Latin hypercube.
    pub seed: u32,
    /// Keys and the ranges over which they are spread.
    pub spreads: Vec<Spread>,
    /// Of a Latin hypercube, key by key: which part of the range each point lies in.
    parts: Vec<Vec<u32>>,
}

impl Sample {
    /// A sample of so many points.
    ///
    /// # Errors
    /// More points or keys than the design can spread.
    pub fn new(design: Design, points: usize, seed: u32, spreads: Vec<Spread>) -> Result<Self, Error> {
        if !(1..=MOST).contains(&points) {
            return Err(format!("a sample has 1 to {MOST} points").into());
        }
        if spreads.len() > MOST_KEYS {
            return Err(format!("{} keys are more than a sample can spread: {MOST_KEYS}", spreads.len()).into());
        }
        let parts = |key: usize| {
            let mut random = stream(seed, key);
            let mut parts: Vec<u32> = (0..points as u32).collect();
            // Fisher and Yates.
            (1..points).rev().for_each(|at| parts.swap(at, random.below(at as u64 + 1) as usize));
            parts
        };
        let parts = match design {
            Design::LatinHypercube => (0..spreads.len()).map(parts).collect(),
            Design::Sobol => Vec::new(),
        };
        Ok(Self { design, points, seed, spreads, parts })
    }

    /// Where point `index` lies in the range of key number `key`, both from 0: a share of it, from 0 up to 1.
    pub fn place(&self, key: usize, index: usize) -> f64 {
        match self.design {
            Design::LatinHypercube => {
                // A stream of its own for each point, after those of the keys.
                let within = stream(self.seed, MOST_KEYS + key + MOST_KEYS * index).unit();
                ((f64::from(self.parts[key][index]) + within) / self.points as f64).min(BELOW_1)
            }
            Design::Sobol => {
                let shift = stream(self.seed, key).below(1 << 32) as u32;
                f64::from(sobol(key, index as u32) ^ shift) * (-32.0_f64).exp2()
            }
        }
    }

    /// The value of key number `key` at point `index`, as a scene file writes it.
    pub fn value(&self, key: usize, index: usize) -> String {
        self.spreads[key].value(self.place(key, index))
    }
}

/// The largest number below 1.
const BELOW_1: f64 = 1.0 - f64::EPSILON / 2.0;

/// The random numbers of this seed and number.
fn stream(seed: u32, number: usize) -> Rng {
    Rng::new((u64::from(seed) << 32) ^ (number as u64))
}

/// A dimension of Sobol's sequence after the first: its primitive polynomial over 0 and 1 (degree, and the coefficients between the
/// first and the last as bits), and as many odd numbers m to begin with.
type Dimension = (u32, u32, &'static [u32]);

#[rustfmt::skip]
const DIMENSIONS: [Dimension; MOST_KEYS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
    (5, 14, &[1, 3, 5, 5, 31]),
    (6, 1, &[1, 3, 3, 9, 7, 49]),
    (6, 13, &[1, 1, 1, 15, 21, 21]),
    (6, 16, &[1, 3, 1, 13, 27, 49]),
    (6, 19, &[1, 1, 1, 15, 7, 5]),
    (6, 22, &[1, 3, 1, 15, 13, 25]),
    (6, 25, &[1, 1, 5, 5, 19, 61]),
    (7, 1, &[1, 3, 7, 11, 23, 15, 103]),
    (7, 4, &[1, 3, 7, 13, 13, 15, 69]),
];

/// The direction numbers of a dimension, from 0: m_k·2^(32 − k), where 2^(k − 1) ≤ index < 2^k needs the first k of them.
const DIRECTIONS: [[u32; 32]; MOST_KEYS] = {
    let mut all = [[0; 32]; MOST_KEYS];
    let mut at = 0;
    while at < MOST_KEYS {
        let mut k = 0;
        while k < 32 {
            all[at][k] = if at == 0 {
                1 << (31 - k)
            } else {
                let (degree, between, first) = DIMENSIONS[at - 1];
                let degree = degree as usize;
                if k < degree {
                    first[k] << (31 - k)
                } else {
                    let before = all[at][k - degree];
                    let mut number = before ^ (before >> degree);
                    let mut back = 1;
                    while back < degree {
                        if between >> (degree - 1 - back) & 1 == 1 {
                            number ^= all[at][k - back];
                        }
                        back += 1;
                    }
                    number
                }
            };
            k += 1;
        }
        at += 1;
    }
    all
};

/// Point `index` of Sobol's sequence in a dimension from 0, in units of 2⁻³², in the order of Antonov and Saleev (Gray code).
fn sobol(dimension: usize, index: u32) -> u32 {
    let gray = index ^ (index >> 1);
    let directions = DIRECTIONS[dimension].iter().enumerate();
    directions.filter(|(bit, _)| gray >> bit & 1 == 1).fold(0, |sum, (_, direction)| sum ^ direction)
}

#[cfg(test)]
#[path = "../../tests/inside/sweep_sample.rs"]
mod tests;
