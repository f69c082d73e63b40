//! Instructions, counted: the reviewed file `instructions.txt` beside this one.
//!
//! The counts come from `cargo bench --package host-sim --bench choices`, which replays every choice under valgrind's
//! callgrind: exact, the same on every run of the same binary. `-- --check` compares, `-- --bless` rewrites.
//!
//! Unit: instructions of [`ARCHITECTURE`] per call (loading the parameters, storing the state and the call itself
//! included) or, for `tick/…`, per tick of a whole peer, an eighth of its exchange included. A processor that computes f64
//! or products of 64 bits in software counts otherwise; the order of choices in one number type carries over, the prices
//! of number types do not.

use std::collections::BTreeMap;
use std::sync::OnceLock;

/// What the instructions are instructions of.
pub const ARCHITECTURE: &str = "x86-64";
/// Number types, in the order of the columns.
pub const SCALARS: [&str; 3] = ["f32", "f64", "i32f32"];

/// The file as it is reviewed.
pub const REVIEWED: &str = include_str!("instructions.txt");

/// A case that was not counted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "host-sim/src/accuracy/instructions.txt has no count of {case} in {scalar}: \
     `cargo bench --package host-sim --bench choices -- --bless` counts"
)]
pub struct Uncounted {
    /// Which one.
    pub case: String,
    /// In which number type.
    pub scalar: String,
}

/// Counts of every case, in the order of [`SCALARS`].
pub fn parse(text: &str) -> BTreeMap<&str, [u64; 3]> {
    let row = |line| {
        let mut words = str::split_whitespace(line);
        let case = words.next()?;
        let counts: Vec<u64> = words.map_while(|word| word.parse().ok()).collect();
        Some((case, counts.try_into().ok()?))
    };
    text.lines().filter(|line| !line.starts_with('#')).filter_map(row).collect()
}

/// Instructions of one case in one number type.
///
/// # Errors
/// The case is not in the reviewed file.
pub fn count(case: &str, scalar: &str) -> Result<u64, Uncounted> {
    static COUNTS: OnceLock<BTreeMap<&str, [u64; 3]>> = OnceLock::new();
    let counts = COUNTS.get_or_init(|| parse(REVIEWED));
    let column = SCALARS.iter().position(|known| *known == scalar);
    let found = counts.get(case).zip(column).map(|(counts, column)| counts[column]);
    found.ok_or_else(|| Uncounted { case: case.to_owned(), scalar: scalar.to_owned() })
}
