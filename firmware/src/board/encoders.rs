//! Two quadrature encoders on 16-bit counters: every edge counts, and the counter wraps; the peer takes care of that.
//!
//! The input filter takes an edge only when 8 samples at the timer's clock agree (33 ns at 240 MHz): a glitch of the wiring
//! is shorter, and no encoder that a hand moves is faster than a few MHz.

use embassy_stm32::peripherals::{PC6, PC7, PD12, PD13, TIM3, TIM4};
use embassy_stm32::timer::qei::{Config, Qei};
use embassy_stm32::{Peri, gpio::Pull, pac, pac::timer::vals::FilterValue};
use haptic_core::{device::AXES, device::encoder::Counts};

/// Starts both counters, at 0.
pub(crate) fn init(
    one: Peri<'static, TIM3>,
    (a1, b1): (Peri<'static, PC6>, Peri<'static, PC7>),
    two: Peri<'static, TIM4>,
    (a2, b2): (Peri<'static, PD12>, Peri<'static, PD13>),
) {
    // Open-collector encoders need the pull-ups, others do not mind.
    let config = Config { ch1_pull: Pull::Up, ch2_pull: Pull::Up, ..Config::default() };
    // Dropping a counter would stop its clock: they run until the power goes.
    core::mem::forget(Qei::new(one, a1, b1, config));
    core::mem::forget(Qei::new(two, a2, b2, config));
    for timer in [pac::TIM3, pac::TIM4] {
        timer.ccmr_input(0).modify(|w| {
            w.set_icf(0, FilterValue::FCK_INT_N8);
            w.set_icf(1, FilterValue::FCK_INT_N8);
        });
    }
}

#[inline(always)]
pub(crate) fn read() -> [Counts; AXES] {
    [Counts(pac::TIM3.cnt().read().cnt()), Counts(pac::TIM4.cnt().read().cnt())]
}
