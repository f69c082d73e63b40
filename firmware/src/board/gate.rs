//! The amplifiers' gate: the order in which amplifiers are enabled and disabled, and what shows at every start that the gate works.
//!
//! An amplifier takes half of the period for no current, and a line that is low for all of its current backwards. The timer's outputs are
//! low whenever they are off, so that an amplifier may be enabled only while they are on: the gate, an AND of PF3 and PE14, sees to that
//! in hardware ([`super::bridges`]). Its output comes back on PD15. At every start, before an amplifier is enabled for the first time, each
//! input is seen to keep the gate shut by itself, while all commands stand at no current: so a gate that is missing, or wired to one of
//! the two alone, enables amplifiers that are asked for nothing, and ends there.
//!
//! | tick | commands | PF3 | PE14 | PD15, a tick later |
//! |---|---|---|---|---|
//! | at rest | low | low | low | low |
//! | 1 | no current | low | high | low: PF3 keeps it shut |
//! | 2 | no current | low | low | low |
//! | 3 | no current | high | low | low: PE14 keeps it shut |
//! | 4 | as wanted | high | high | high |
//!
//! Anything else is [`cohold_core::safety::Fault::EnableGate`], motors off in that tick. So it is when PD15 is still high after a break,
//! which has taken PE14 and left PF3.
//!
//! When amplifiers are disabled by the program, commands stay at no current for [`LETS_GO`] more ([`shut`]): so long they have to let go.
//! A break cannot wait: it takes the commands in the same instant as PE14. An amplifier that is slower to let go than it is to follow
//! must take a line that does not change for no current; docs/guides/board/assembly.md asks for one of the two.

use cohold_core::device::motor::Duty;
use firmware_parts::image::JOINTS;
use firmware_parts::rate::Ms;

use super::{bridges, legs};

/// From disabling amplifiers to taking their commands.
pub(crate) const LETS_GO: Ms = Ms(1);
/// The tick in which all was seen; in those after it there is nothing left to try.
pub(crate) const SEEN: u32 = 5;

/// One tick of the table, by its number; 0: not to be enabled. False: the gate is not what it should be, and nothing is enabled.
pub(crate) fn step(tick: u32, duties: [Duty; JOINTS]) -> bool {
    let works = legs::gate_passes() == (tick == SEEN);
    put(if works { tick } else { 0 }, duties);
    works
}

/// Disabled; commands stand at no current until the outputs are turned off.
#[inline(always)]
pub(crate) fn shut() {
    put(0, [Duty::OFF; JOINTS]);
}

/// What the table says of this tick. PF3 acts at once, the others with the next period, which no tick is shorter than.
#[inline(never)]
#[unsafe(link_section = ".itcm.gate")]
fn put(tick: u32, duties: [Duty; JOINTS]) {
    bridges::enable(tick >= 3);
    legs::gate(tick == 1 || tick >= 4);
    legs::amplify(if tick >= 4 { duties } else { [Duty::OFF; JOINTS] });
}
