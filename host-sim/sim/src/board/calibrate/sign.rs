//! The sign of a motor: the check before arming, on a board that may still have it wrong.
//!
//! The encoder's own sign comes first ([`super::counts`]): it says which way the axis points. The motor's follows from it.

use super::Found;
use super::board::{Board, say, settings};

/// Checks joint `number` and gives `motor.reversed` as it should be.
///
/// # Errors
/// It did not move, something else moved it, or the board refuses.
pub fn calibrate(board: &mut dyn Board, number: u32) -> Result<Vec<Found>, String> {
    let reversed = settings(board)?.motor.reversed;
    say(board, &format!("check {number}"))?;
    let mut answer = String::new();
    // A check takes 0.4 s at the most.
    for _ in 0..20 {
        board.ticks(0.05)?;
        answer = say(board, "probed")?;
        if !answer.contains(" running") {
            break;
        }
    }
    if answer.contains("; agree: ") {
        Ok(vec![Found::flag("motor.reversed", reversed)])
    } else if answer.contains("; disagree: ") {
        Ok(vec![Found::flag("motor.reversed", !reversed)])
    } else {
        Err(answer.split_once("; ").map_or(answer.clone(), |(_, verdict)| verdict.to_owned()))
    }
}
