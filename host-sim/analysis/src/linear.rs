//! Whether a scene's law is linear, so that its matrix says all of it.
//!
//! A peer of the linear scene is driven from two states drawn at random, from their sum and from the second one turned round. What comes
//! out must add up, to rounding, at every draw. What only shows at some size (a dead band around rest) does not show here: states are
//! small ([`super::lifted::driven`]); it shows in what is felt at two speeds.

use cohold_sim::scene::Scene;

use super::lifted::driven::{counts, driven, keeps_silent, seats};
use crate::error::Error;

/// Pairs of states that are tried.
const DRAWS: u32 = 8;

/// How far sums may be off, relative to the largest number among them.
const ROUNDING: f64 = 1e-9;

/// Whether either peer of the scene, its contact, network and motors made linear, answers to a sum with the sum of its answers.
///
/// # Errors
/// Settings that no peer accepts.
pub fn is_linear(scene: &Scene) -> Result<bool, Error> {
    adds_up(&scene.linear(), DRAWS)
}

/// Whether a matrix says all that a linear scene does: its law is linear, learns nothing, and sends a packet in each period. Those that count ticks
/// are linear.
pub(crate) fn matrix_says_all(linear: &Scene) -> Result<bool, Error> {
    Ok(!keeps_silent(linear) && !linear.law().learns && (counts(linear) || adds_up(linear, 1)?))
}

/// [`is_linear`] of a linear scene, by so many pairs of states.
fn adds_up(linear: &Scene, draws: u32) -> Result<bool, Error> {
    // It settles once: that takes a self-timed line a thousand ticks.
    let Some(mut seat) = seats(linear, 0, 0)?.pop() else { return Ok(true) };
    let sizes = seat.sizes();
    // Numbers in [-1, 1) from a linear congruential generator: any will do.
    let mut seed = 1_u32;
    let mut draw = || {
        sizes.map(|size| -> Vec<f64> {
            let next = |_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(seed) / f64::from(1_u32 << 31) - 1.0
            };
            (0..size).map(next).collect()
        })
    };
    for _ in 0..draws {
        let (first, second) = (draw(), draw());
        let [one, other] = [&first, &second].map(|[local, packet]| driven(&mut *seat, local, packet));
        let [sum, difference] = [1.0, -1.0].map(|sign: f64| {
            let sum = |at: usize| -> Vec<f64> {
                first[at].iter().zip(&second[at]).map(|(one, other)| one + sign * other).collect()
            };
            driven(&mut *seat, &sum(0), &sum(1))
        });
        let scale = one.iter().chain(&other).fold(0.0_f64, |most, number| most.max(number.abs()));
        let adds = |at: usize, sign: f64, got: &[f64]| (one[at] + sign * other[at] - got[at]).abs() <= ROUNDING * scale;
        // What is not finite is no sum.
        if !(0..one.len()).all(|at| adds(at, 1.0, &sum) && adds(at, -1.0, &difference)) {
            return Ok(false);
        }
    }
    Ok(true)
}
