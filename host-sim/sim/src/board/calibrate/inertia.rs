//! Moving mass of a joint, in kilograms at the hand, and by how much force follows duty. Needs scale, sign and motor constant.

use super::board::Board;
use super::{Estimate, Found, motion};

/// Moves joint `number` and gives its mass and delay.
///
/// # Errors
/// What is wrong, in one line.
pub fn calibrate(board: &mut dyn Board, number: u32) -> Result<Vec<Found>, String> {
    let (motion, joint, settings) = motion::identify(board, number)?;
    let newton = motion::newton_per_duty(&settings, &joint);
    let delay = motion.delay_s.times(1.0 / joint.period_s);
    if delay.value > 1.0 + delay.within {
        return Err(format!("force follows duty by {delay} control periods, more than the 1 that a scene can have"));
    }
    Ok(vec![
        Found::number("device.mass_kg", motion.mass.times(newton), "kg"),
        Found::number("device.force_delay_ticks", Estimate { value: delay.value.clamp(0.0, 1.0), ..delay }, "ticks"),
    ])
}
