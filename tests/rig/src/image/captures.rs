//! TIM2, which runs for ever at 240 MHz and keeps when edges came.
//!
//! | channel | keeps |
//! |---|---|
//! | 1 | PE9 of the board falls |
//! | 2 | PE9 rises; or the bridges' fault line falls, while that is measured |
//! | 3 | PE14 of the board falls |
//! | 4 | the stop's line falls |

use cortex_m::peripheral::NVIC;
use stm32_metapac::{Interrupt, TIM2};

use cohold_rig::order::Line;

/// Flags of channels 1 to 4 in SR.
const FIRST: u32 = 1 << 1;
const SECOND: u32 = 1 << 2;
const THIRD: u32 = 1 << 3;
const FOURTH: u32 = 1 << 4;
/// CCER: all four channels on, all but the second at falling edges; and the second at falling ones as well.
const EDGES: u32 = 0x1111 | 0x2202;
const ALL_FALLING: u32 = 0x3333;
/// CCMR1: the first channel sees its own input, and the second that one too, or its own.
const BOTH_FIRST: u32 = 1 | 2 << 8;
const EACH_ITS_OWN: u32 = 1 | 1 << 8;

/// Starts counting.
pub(crate) fn start() {
    TIM2.arr().write_value(u32::MAX);
    TIM2.ccmr_input(0).write(|w| w.0 = BOTH_FIRST);
    TIM2.ccmr_input(1).write(|w| w.0 = EACH_ITS_OWN);
    TIM2.ccer().write(|w| w.0 = EDGES);
    // A pulse's end wakes the processor, and its beginning.
    TIM2.dier().write(|w| w.0 = FIRST | SECOND);
    TIM2.cr1().write(|w| w.set_cen(true));
    // SAFETY: interrupts are masked: this one wakes, and is never taken.
    unsafe { NVIC::unmask(Interrupt::TIM2) };
}

/// The count now.
pub(crate) fn now() -> u32 {
    TIM2.cnt().read()
}

/// When PE9 fell, once.
pub(crate) fn fall() -> Option<u32> {
    (TIM2.sr().read().0 & FIRST != 0).then(|| {
        TIM2.sr().write(|w| w.0 = !FIRST);
        TIM2.ccr(0).read()
    })
}

/// When PE9 fell and rose, once for each low pulse.
pub(crate) fn pulse() -> Option<[u32; 2]> {
    (TIM2.sr().read().0 & SECOND != 0).then(|| {
        let edges = [TIM2.ccr(0).read(), TIM2.ccr(1).read()];
        TIM2.sr().write(|w| w.0 = !SECOND);
        edges
    })
}

/// From here on PE14's fall is waited for.
pub(crate) fn wait_for_the_fall() {
    TIM2.sr().write(|w| w.0 = !THIRD);
}

/// When PE14 fell, if it has.
pub(crate) fn fell() -> Option<u32> {
    (TIM2.sr().read().0 & THIRD != 0).then(|| TIM2.ccr(2).read())
}

/// From here on this line is measured, and no pulse of PE9.
pub(crate) fn look_at(line: Line) {
    if line == Line::Fault {
        TIM2.ccer().write(|w| w.0 = EDGES & !0x11);
        TIM2.ccmr_input(0).write(|w| w.0 = EACH_ITS_OWN);
        TIM2.ccer().write(|w| w.0 = ALL_FALLING);
    }
    TIM2.sr().write(|w| w.0 = !(SECOND | THIRD | FOURTH));
}

/// Counts from this line's fall to PE14's, once both have fallen.
#[inline(always)]
pub(crate) fn both_fell(line: Line) -> Option<u32> {
    let (flag, channel) = match line {
        Line::Fault => (SECOND, 1),
        Line::Stop => (FOURTH, 3),
    };
    let both = flag | THIRD;
    (TIM2.sr().read().0 & both == both).then(|| TIM2.ccr(2).read().wrapping_sub(TIM2.ccr(channel).read()))
}

/// From here on pulses of PE9 are seen again.
pub(crate) fn look_at_pulses() {
    TIM2.ccer().write(|w| w.0 = EDGES & !0x11);
    TIM2.ccmr_input(0).write(|w| w.0 = BOTH_FIRST);
    TIM2.ccer().write(|w| w.0 = EDGES);
    TIM2.sr().write(|w| w.0 = !SECOND);
}
