//! The supervisor: feeds the watchdog while the tick makes progress, shows signs of life, logs what changes.
//!
//! Every 5 ms it looks at the tick counter. It feeds the watchdog only if the tick advanced by 3 to 7 since the last look:
//! a tick that stands still, and a supervisor that does, both end in a reset within [`crate::board::WATCHDOG_MS`].

use core::sync::atomic::Ordering;

use embassy_stm32::gpio::{Level, Output};
use embassy_stm32::peripherals::IWDG1;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::{Duration, Ticker};
use firmware_parts::status;

use crate::tick::{STATUS, TICKS};

/// Between two looks, ms; and so the ticks expected in between.
const EVERY_MS: u32 = 5;
/// What the phases of two timers may make of it.
const SLACK: u32 = 2;

/// Runs for ever.
#[embassy_executor::task]
pub(crate) async fn run(
    mut watchdog: IndependentWatchdog<'static, IWDG1>,
    mut alive: Output<'static>,
    mut armed: Output<'static>,
) -> ! {
    watchdog.unleash();
    let mut last = TICKS.load(Ordering::Relaxed);
    let mut status = 0;
    let mut looks: u32 = 0;
    let mut pace = Ticker::every(Duration::from_millis(EVERY_MS.into()));
    loop {
        pace.next().await;
        let now = TICKS.load(Ordering::Relaxed);
        if now.wrapping_sub(last).abs_diff(EVERY_MS) <= SLACK {
            watchdog.pet();
        }
        last = now;
        looks = looks.wrapping_add(1);
        if looks.is_multiple_of(100) {
            alive.toggle();
        }
        let new = STATUS.load(Ordering::Relaxed);
        if new != status {
            let ((before, _), (mode, fault)) = (status::unpack(status), status::unpack(new));
            defmt::info!("tick {=u32}: {=str} -> {=str}, fault {=u8}", now, before, mode, fault);
            armed.set_level(if matches!(mode, "armed" | "probing") { Level::High } else { Level::Low });
            status = new;
        }
    }
}
