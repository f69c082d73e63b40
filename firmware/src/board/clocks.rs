//! Clocks: 480 MHz core, 240 MHz buses and timers, 120 MHz peripherals, from the ST-LINK's 8 MHz.
//!
//! 8 MHz / 2 × 240 = 960 MHz, / 2 = 480 MHz: needs voltage scale 0, which silicon before revision V does not have. Where the 8 MHz do
//! not come, 64 MHz / 16 of the chip's own oscillator take their place, good to 1 %: a board that talks and says so, and is not armed.
//!
//! The regulator comes first (RM0433 §6.6.2): embassy-stm32 clocks SYSCFG, asks for scale 1, waits until it is ready, sets
//! SYSCFG_PWRCR.ODEN (scale 0), waits again, and only then turns to oscillators, PLL and the system clock. The emulator knows
//! scales 1 to 3 only and tells of clocks above scale 1's limits; that ODEN is set, and SYSCFG clocked when it was,
//! tests/board checks.

use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, HSIPrescaler, Hse, HseMode, Pll, PllDiv, PllMul, PllPreDiv, PllSource, Sysclk,
    VoltageScale,
};
use embassy_stm32::{Config, pac, time::Hertz};

use super::cable;
use crate::boards::EXTERNAL_HZ;

/// Frequency of the core, Hz.
pub(crate) const CORE_HZ: u32 = 2 * TIMERS_HZ;
pub(crate) const TIMERS_HZ: u32 = 240_000_000;
/// Frequency of the buses that peripherals are on, PCLK1 to PCLK4, Hz.
pub(crate) const PERIPHERALS_HZ: u32 = TIMERS_HZ / 2;

/// Looks at the external clock until it must be there: one or two seconds on the 64 MHz of the start.
const LOOKS: u32 = 8_000_000;

const _: () = assert!(EXTERNAL_HZ == 8_000_000, "the dividers below are for 8 MHz");

/// Waits for the external clock, and says whether it came. The ST-LINK may need longer to start than the chip does.
pub(crate) fn external() -> bool {
    pac::RCC.cr().modify(|w| w.set_hsebyp(true));
    pac::RCC.cr().modify(|w| w.set_hseon(true));
    let came = (0..LOOKS).any(|_| pac::RCC.cr().read().hserdy());
    if !came {
        pac::RCC.cr().modify(|w| w.set_hseon(false));
    }
    came
}

/// The tree, from the external clock or the chip's own.
pub(crate) fn config(external: bool) -> Config {
    let mut config = Config::default();
    let rcc = &mut config.rcc;
    rcc.hsi = Some(HSIPrescaler::DIV1);
    rcc.csi = true;
    rcc.hse = external.then_some(Hse { freq: Hertz(EXTERNAL_HZ), mode: HseMode::Bypass });
    rcc.pll1 = Some(Pll {
        source: if external { PllSource::HSE } else { PllSource::HSI },
        prediv: if external { PllPreDiv::DIV2 } else { PllPreDiv::DIV16 },
        mul: PllMul::MUL240,
        // The driver knows of it for this chip alone.
        #[cfg(feature = "nucleo-h743zi2")]
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
    cable::clock(rcc);
    config
}
