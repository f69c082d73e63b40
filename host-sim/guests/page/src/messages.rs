//! What a window says, read: the question that it asks once a frame, and the orders that act without the judge. The table is in
//! [`super::web`].

use cohold_core::names::Choice as _;

use super::boards_line::Line;
use super::environment::Command;
use super::mailbox::Pointed;
use super::partner::Model;

/// Farthest that a pointer is believed, m.
pub(super) const FARTHEST_M: f32 = 0.2;
/// What a pointer says that holds nothing.
pub(super) const LET_GO: Pointed = Pointed { at: None, restarts: 0 };

/// The tick that a window wants next, and what its pointer says.
pub(super) fn question(bytes: [u8; 20]) -> (u32, Pointed) {
    let [from, along, across, up, restarts] =
        [0, 4, 8, 12, 16].map(|at| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    let at = [along, across, up].map(f32::from_le_bytes);
    let at = at.iter().all(|at| at.is_finite()).then(|| at.map(|at| at.clamp(-FARTHEST_M, FARTHEST_M)));
    (u32::from_le_bytes(from), Pointed { at, restarts: u32::from_le_bytes(restarts) })
}

/// What acts at the next tick; none, and it is an order for the judge.
pub(super) fn command(line: &str) -> Option<Command> {
    match line {
        "stop" => Some(Command::Stop),
        "start" => Some(Command::Start),
        "cut" => Some(Command::Cut(true)),
        "join" => Some(Command::Cut(false)),
        _ => {
            let partner = line.strip_prefix("partner ").and_then(Model::from_name).map(Command::Partner);
            partner.or_else(|| board(line))
        }
    }
}

/// A line to a board: `board NUMBER LINE`.
fn board(line: &str) -> Option<Command> {
    let (number, line) = line.strip_prefix("board ")?.split_once(' ')?;
    Some(Command::Board(number.parse().ok()?, Line::from_text(line)?))
}
