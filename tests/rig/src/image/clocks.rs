//! Clocks: 480 MHz core, 240 MHz timers, 120 MHz peripherals, from the ST-LINK's 8 MHz, as on the board under test; and the timer that
//! makes the steps of 50 µs.
//!
//! It waits for the external clock for ever: without it no figure of the rig would mean anything.

use stm32_metapac::{FLASH, PWR, RCC, SYSCFG, TIM7};

use cohold_rig::pulses::PERIOD;

/// PLL1 or PLL1's output as the system's clock, in both fields of RCC_CFGR.
const PLL1: u32 = 3;
/// TIM7's update.
const UPDATED: u32 = 1;

/// Everything on, and the steps begin.
pub(crate) fn start() {
    RCC.ahb4enr().modify(|w| {
        w.set_gpioaen(true);
        w.set_gpioben(true);
        w.set_gpiocen(true);
        w.set_gpioden(true);
        w.set_gpioeen(true);
        w.set_gpiofen(true);
    });
    RCC.apb1lenr().modify(|w| {
        w.set_tim2en(true);
        w.set_tim7en(true);
        w.set_usart3en(true);
        w.set_dac12en(true);
    });
    RCC.apb4enr().modify(|w| w.set_syscfgen(true));
    // Supply by the regulator, then scale 1, then overdrive, which is scale 0 (RM0433 §6.6.2).
    PWR.cr3().modify(|w| {
        w.set_scuen(true);
        w.set_ldoen(true);
        w.set_bypass(false);
    });
    while !PWR.csr1().read().actvosrdy() {}
    PWR.d3cr().modify(|w| w.0 |= 3 << 14);
    while !PWR.d3cr().read().vosrdy() {}
    SYSCFG.pwrcr().modify(|w| w.set_oden(1));
    while !PWR.d3cr().read().vosrdy() {}

    RCC.cr().modify(|w| w.set_hsebyp(true));
    RCC.cr().modify(|w| w.set_hseon(true));
    while !RCC.cr().read().hserdy() {}
    // 8 MHz / 2 · 240 = 960 MHz, / 2.
    RCC.pllckselr().modify(|w| w.0 = w.0 & !0x3F3 | 2 << 4 | 2);
    // Input of 4 to 8 MHz, wide range, output P.
    RCC.pllcfgr().modify(|w| w.0 = w.0 & !0x7000F | 2 << 2 | 1 << 16);
    RCC.plldivr(0).write(|w| w.0 = 239 | 1 << 9 | 1 << 16 | 1 << 24);
    RCC.cr().modify(|w| w.set_pllon(0, true));
    while !RCC.cr().read().pllrdy(0) {}
    // 240 MHz and scale 0: four wait states.
    FLASH.acr().modify(|w| {
        w.set_latency(4);
        w.set_wrhighfreq(2);
    });
    // Buses at half of the core's, peripherals at half of that.
    RCC.d1cfgr().modify(|w| w.0 = 8 | 4 << 4);
    RCC.d2cfgr().modify(|w| w.0 = 4 << 4 | 4 << 8);
    RCC.d3cfgr().modify(|w| w.0 = 4 << 4);
    RCC.cfgr().modify(|w| w.0 = w.0 & !7 | PLL1);
    while RCC.cfgr().read().0 >> 3 & 7 != PLL1 {}

    TIM7.arr().write(|w| w.0 = PERIOD - 1);
    TIM7.egr().write(|w| w.set_ug(true));
    TIM7.sr().write(|w| w.0 = !UPDATED);
    TIM7.dier().write(|w| w.set_uie(true));
    TIM7.cr1().write(|w| w.set_cen(true));
}

/// Whether a step is due, once.
pub(crate) fn step_is_due() -> bool {
    let due = TIM7.sr().read().0 & UPDATED != 0;
    if due {
        TIM7.sr().write(|w| w.0 = !UPDATED);
    }
    due
}
