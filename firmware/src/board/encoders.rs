//! Two quadrature encoders on 16-bit counters: every edge counts, and the counter wraps; the peer takes care of that.
//!
//! The input filter takes an edge only when 8 samples at the timer's clock agree (33 ns at 240 MHz): a glitch of the wiring
//! is shorter, and no encoder that a hand moves is faster than a few MHz.
//!
//! Beside counting, channels 1 and 2 capture at rising edges of A and B, which leaves a flag at the first and another one at the next:
//! a wire that is cut shows none. Channel 3 captures the counter at a rising edge of the index, in hardware: this timer has no index
//! of its own in encoder mode (RM0433 §39.3.22).

use embassy_stm32::gpio::{AfType, Flex, Pull};
use embassy_stm32::pac::timer::{regs, vals};
use embassy_stm32::peripherals::{PC6, PC7, PC8, PD12, PD13, PD14, TIM3, TIM4};
use embassy_stm32::timer::qei::{Config, Qei};
use embassy_stm32::{Peri, pac};
use haptic_core::{device::AXES, device::encoder::Counts, device::encoder::Marks};

/// Starts both counters, at 0.
pub(crate) fn init(
    one: Peri<'static, TIM3>,
    (a1, b1, index1): (Peri<'static, PC6>, Peri<'static, PC7>, Peri<'static, PC8>),
    two: Peri<'static, TIM4>,
    (a2, b2, index2): (Peri<'static, PD12>, Peri<'static, PD13>, Peri<'static, PD14>),
) {
    // Open-collector encoders need the pull-ups, others do not mind.
    let config = Config { ch1_pull: Pull::Up, ch2_pull: Pull::Up, ..Config::default() };
    // Dropping a counter would stop its clock: they run until the power goes.
    core::mem::forget(Qei::new(one, a1, b1, config));
    core::mem::forget(Qei::new(two, a2, b2, config));
    for mut pin in [Flex::new(index1), Flex::new(index2)] {
        // Without an index there is never an edge.
        pin.set_as_af_unchecked(2, AfType::input(Pull::Down));
        core::mem::forget(pin);
    }
    for timer in [pac::TIM3, pac::TIM4] {
        timer.ccmr_input(0).modify(|w| {
            w.set_icf(0, vals::FilterValue::FCK_INT_N8);
            w.set_icf(1, vals::FilterValue::FCK_INT_N8);
        });
        timer.ccmr_input(1).modify(|w| {
            w.set_ccs(0, vals::CcmrInputCcs::TI4);
            w.set_icf(0, vals::FilterValue::FCK_INT_N8);
        });
        timer.ccer().modify(|w| w.set_cce(2, true));
    }
}

#[inline(always)]
pub(crate) fn read() -> [Counts; AXES] {
    [Counts(pac::TIM3.cnt().read().cnt()), Counts(pac::TIM4.cnt().read().cnt())]
}

/// What the encoders showed since this was asked last.
#[inline(always)]
pub(crate) fn marks() -> [Marks; AXES] {
    [pac::TIM3, pac::TIM4].map(|timer| {
        let seen = timer.sr().read();
        // A flag goes off where 0 is written; what came since it was read stays.
        timer.sr().write_value(regs::SrGp16(!seen.0));
        let index = seen.ccif(2).then(|| Counts(timer.ccr(2).read().ccr()));
        Marks::of([0, 1].map(|channel| seen.ccif(channel)), [0, 1].map(|channel| seen.ccof(channel)), index)
    })
}
