//! The log: what happens on this board, in words. A line goes to defmt, and to the operator, who hears it among the answers ([`crate::port`]).

use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, channel::Channel};
use embassy_time::Instant;

/// The words of a line.
pub(crate) type Words = heapless::String<88>;
/// Lines that wait until an operator is there, each with the time; of more than fit the oldest are gone.
pub(crate) static LINES: Channel<CriticalSectionRawMutex, (Instant, Words), 8> = Channel::new();

/// Puts a line behind those that wait. The supervisor's stack has no room for what writes numbers, the tick's interrupt must say nothing.
#[inline(never)]
pub(crate) fn put(words: &str) {
    if LINES.is_full() {
        let _ = LINES.try_receive();
    }
    let _ = LINES.try_send((Instant::now(), Words::try_from(words).unwrap_or_default()));
}

/// Says a line, as defmt's macro of this name does; a value stands for each `{}`. What does not fit is cut.
macro_rules! log {
    ($level:ident, $words:literal) => {{
        defmt::$level!($words);
        $crate::log::put($words);
    }};
    ($level:ident, $words:literal, $($value:expr),+) => {{
        defmt::$level!($words, $($value),+);
        let mut line = $crate::log::Words::new();
        let _ = core::fmt::Write::write_fmt(&mut line, format_args!($words, $($value),+));
        $crate::log::put(&line);
    }};
}
pub(crate) use log;
