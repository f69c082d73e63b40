//! Which choices nobody beats: the Pareto front of error against instructions.
//!
//! A choice is beaten where another one is no worse in both and clearly better in one. "Clearly" is what the numbers can
//! carry: errors closer than [`SAME_ERROR`] and counts closer than [`SAME_COUNT`] are equal, so that f64 is not on a front
//! for a hundredth of a per cent. Being beaten this way has no circles (log error / log 1.01 + log count / log 1.02 falls
//! along it), so a front is never empty.

/// Errors within this factor of each other are the same.
pub const SAME_ERROR: f64 = 1.01;
/// Instruction counts within this factor of each other are the same: the tolerance to which they are reviewed.
pub const SAME_COUNT: f64 = 1.02;

/// For every (error, instructions) whether it is on the front. What has no error to speak of (NaN) is not.
pub fn front(points: &[(f64, f64)]) -> Vec<bool> {
    points.iter().map(|point| !point.0.is_nan() && !points.iter().any(|other| beats(*other, *point))).collect()
}

/// Whether `a` is no worse than `b` in error and instructions, and clearly better in one.
fn beats(a: (f64, f64), b: (f64, f64)) -> bool {
    let no_worse = a.0 <= b.0 * SAME_ERROR && a.1 <= b.1 * SAME_COUNT;
    no_worse && (a.0 * SAME_ERROR < b.0 || a.1 * SAME_COUNT < b.1)
}
