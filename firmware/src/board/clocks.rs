//! Clocks: 480 MHz core, 240 MHz buses and timers, 120 MHz peripherals, from the ST-LINK's 8 MHz.
//!
//! 8 MHz / 2 × 240 = 960 MHz, / 2 = 480 MHz: needs voltage scale 0, which silicon before revision V does not have.
//!
//! The regulator comes first (RM0433 §6.6.2): embassy-stm32 clocks SYSCFG, asks for scale 1, waits until it is ready, sets
//! SYSCFG_PWRCR.ODEN (scale 0), waits again, and only then turns to oscillators, PLL and the system clock. The emulator knows
//! scales 1 to 3 only and tells of clocks above scale 1's limits; that ODEN is set, and SYSCFG clocked when it was,
//! tests/board checks.

use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, HSIPrescaler, Hse, HseMode, Pll, PllDiv, PllMul, PllPreDiv, PllSource, Sysclk,
    VoltageScale,
};
use embassy_stm32::{Config, time::Hertz};

pub(crate) const TIMERS_HZ: u32 = 240_000_000;
/// Of the buses that peripherals are on, PCLK1 to PCLK4.
pub(crate) const PERIPHERALS_HZ: u32 = TIMERS_HZ / 2;

pub(crate) fn config() -> Config {
    let mut config = Config::default();
    let rcc = &mut config.rcc;
    rcc.hsi = Some(HSIPrescaler::DIV1);
    rcc.csi = true;
    rcc.hse = Some(Hse { freq: Hertz(8_000_000), mode: HseMode::Bypass });
    rcc.pll1 = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV2,
        mul: PllMul::MUL240,
        fracn: None,
        divp: Some(PllDiv::DIV2),
        divq: Some(PllDiv::DIV8),
        divr: None,
    });
    rcc.sys = Sysclk::PLL1_P;
    rcc.ahb_pre = AHBPrescaler::DIV2;
    rcc.apb1_pre = APBPrescaler::DIV2;
    rcc.apb2_pre = APBPrescaler::DIV2;
    rcc.apb3_pre = APBPrescaler::DIV2;
    rcc.apb4_pre = APBPrescaler::DIV2;
    rcc.voltage_scale = VoltageScale::Scale0;
    config
}
