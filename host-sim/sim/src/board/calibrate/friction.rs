//! Friction of a joint: viscous and dry, in newtons at the hand. Needs scale, sign and motor constant, in this order.

use super::board::Board;
use super::{Estimate, Found, motion};

/// Moves joint `number` and gives its friction.
///
/// # Errors
/// What is wrong, in one line.
pub fn calibrate(board: &mut dyn Board, number: u32) -> Result<Vec<Found>, String> {
    let (motion, joint, settings) = motion::identify(board, number)?;
    let newton = motion::newton_per_duty(&settings, &joint);
    // A friction below zero is none, as far as the data go.
    let at_least_none = |estimate: Estimate| Estimate { value: estimate.value.max(0.0), ..estimate };
    for (name, estimate) in [("viscous", motion.damping), ("dry", motion.dry)] {
        if estimate.value < -3.0 * estimate.within {
            return Err(format!("{name} friction comes out at {}: something else pushes", estimate.times(newton)));
        }
    }
    Ok(vec![
        Found::number("device.damping_n_s_per_m", at_least_none(motion.damping.times(newton)), "N·s/m"),
        Found::number("plant.coulomb_n", at_least_none(motion.dry.times(newton)), "N"),
    ])
}
