//! The input of the hold-to-run switch, PG14 ([`firmware_parts::switch`]): closed it is at 3.3 V, open or with a wire off it is pulled down.

use embassy_stm32::gpio::{Input, Pull};
use embassy_stm32::{Peri, pac, peripherals::PG14};
use embassy_sync::once_lock::OnceLock;
use firmware_parts::{signals::Signals, switch::Switch};

static SWITCH: Switch = Switch::unseen();
/// Whom it is told.
static SIGNALS: OnceLock<&'static Signals> = OnceLock::new();

/// Looks from the next tick on.
pub(crate) fn start(pin: Peri<'static, PG14>, signals: &'static Signals) {
    core::mem::forget(Input::new(pin, Pull::Down));
    // Nobody has called this before.
    let _ = SIGNALS.init(signals);
}

/// After every tick.
pub(crate) fn look() {
    if let Some(signals) = SIGNALS.try_get() {
        SWITCH.see(signals, pac::GPIOG.idr().read().idr(14) == pac::gpio::vals::Idr::HIGH);
    }
}
