//! Why the processor started, from the flags of the reset controller.

use embassy_stm32::pac;
use firmware_parts::status::Stop;

/// The cause, and the flags cleared for the next time.
pub(crate) fn cause() -> Stop {
    let flags = pac::RCC.rsr().read();
    pac::RCC.rsr().modify(|w| w.set_rmvf(true));
    if flags.wwdg1rstf() {
        Stop::TickMissed
    } else if flags.iwdg1rstf() {
        Stop::Watchdog
    } else if flags.porrstf() {
        Stop::PowerOn
    } else if flags.borrstf() {
        Stop::BrownOut
    } else if flags.sftrstf() {
        Stop::Request
    } else {
        Stop::PowerOn
    }
}
