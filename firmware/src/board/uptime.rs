//! The time driver's clock, which embassy-stm32 (0.6.0) starts half a round ahead.
//!
//! The driver counts half rounds of a 16-bit counter in its interrupt, TIM5's, and reads time as that number and the counter: an even
//! number goes with the lower half, an odd one with the upper. So time is right, too, where the counter has begun a half that the
//! interrupt has not counted yet. But when the driver loads the prescaler (UG), counter and channel 1 are both 0: they match, the
//! driver takes that match for the first half, and from then on every number goes with the wrong half. Time then reads as if
//! nothing were wrong, 65.536 ms ahead, except between the start of a half and the interrupt: there it jumps back by 65.536 ms.
//! Whoever sets an alarm then sets it that much too late, and for the supervisor that is a watchdog's reset. It takes somebody who
//! preempts the interrupt at that very moment, every 32.768 ms a microsecond or as long as a tick lasts.
//!
//! Here one more match is made by hand; time goes on from where it was.

use embassy_stm32::pac;
use embassy_time::Instant;

/// Counts in a round.
const ROUND: u64 = 1 << 16;

/// Puts the driver's number right; call within 30 ms after it was started, before anything waits for a time.
pub(crate) fn put_right() {
    if Instant::now().as_ticks() >= ROUND {
        pac::TIM5.egr().write(|w| w.set_ccg(0, true));
    }
}
