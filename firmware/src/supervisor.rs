//! The supervisor: feeds the watchdog while the tick makes progress, lets go when the operator does, looks at the blue button,
//! shows signs of life, logs what changes.
//!
//! Every 5 ms it looks at the tick counter. It feeds the watchdog only if the tick advanced by 3 to 7 ms since the last look:
//! a tick that stands still, and a supervisor that does, both end in a reset within [`crate::board::WATCHDOG_MS`].

use cohold_core::safety::Mode;
use embassy_stm32::gpio::{Input, Level, Output};
use embassy_stm32::{peripherals::IWDG1, wdg::IndependentWatchdog};
use embassy_time::{Duration, Ticker};
use firmware_parts::signals::{Button, Signals};
use firmware_parts::{button::Watch, hold};

use crate::{board::pace, lease::Lease, log::log};

/// Between two looks, ms; and so the milliseconds of ticks expected in between.
const EVERY_MS: u32 = hold::LOOK_EVERY;
/// What the phases of two timers may make of it, ms.
const SLACK: u32 = 2;

#[embassy_executor::task]
pub(crate) async fn run(
    mut watchdog: IndependentWatchdog<'static, IWDG1>,
    mut alive: Output<'static>,
    mut armed: Output<'static>,
    button: Input<'static>,
    signals: &'static Signals,
    hold: &'static Lease,
) -> ! {
    watchdog.unleash();
    let mut last = signals.ticks.get();
    let mut mode = Mode::Disarmed;
    let mut looks: u32 = 0;
    let mut watch = Watch::default();
    let mut pace = Ticker::every(Duration::from_millis(EVERY_MS.into()));
    loop {
        pace.next().await;
        let now = signals.ticks.get();
        let per_ms = pace::per_ms();
        if now.wrapping_sub(last).abs_diff(EVERY_MS * per_ms) <= SLACK * per_ms {
            watchdog.pet();
        }
        last = now;
        looks = looks.wrapping_add(1);
        let held = watch.look(button.is_high());
        if held != signals.button.get() && held == Button::Stuck {
            log!(warn, "the blue button is down since before the start: it counts once it was released");
        }
        signals.button.set(held);
        if looks.is_multiple_of(100) {
            alive.toggle();
        }
        if hold.with(|hold, now_us| hold.look(now_us, signals)) {
            log!(warn, "the operator does not let the motors run: off");
        }
        let new = signals.mode.get();
        if new != mode {
            let (before, after) = (mode.name(), new.name());
            defmt::info!("tick {=u32}: {=str} -> {=str}, fault {=u8}", now, before, after, new.fault_number());
            if new == Mode::Disarmed && signals.released.get() {
                log!(warn, "the hold-to-run switch was released: off");
            }
            let lit = matches!(new, Mode::Armed | Mode::Probing);
            armed.set_level(if lit { Level::High } else { Level::Low });
            mode = new;
        }
    }
}
