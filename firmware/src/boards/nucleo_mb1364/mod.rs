//! MB1364, the printed board of the NUCLEO-H743ZI2 (an STM32H743ZIT6) and of the NUCLEO-H753ZI (an STM32H753ZIT6: the H743's die with CRYP and
//! HASH besides, which nothing here uses), with two encoders and two motor bridges, or three (feature `three-axes`).
//!
//! The first is the default, and the one that all pages mean where they name none. Numbers of connectors are in firmware/wiring/netlist.toml and
//! docs/guides/board/assembly.md.

use embassy_stm32::Peripherals;

#[cfg(feature = "moteus")]
use crate::board::drive;
#[cfg(not(feature = "moteus"))]
use crate::board::encoders;
use crate::board::{Wiring, bridges, cable, legs};

/// The external clock, Hz: of the ST-LINK, at the pin that a crystal would be at.
pub(crate) const EXTERNAL_HZ: u32 = 8_000_000;

/// What is wired to which pin.
pub(crate) fn wiring(p: Peripherals) -> Wiring {
    Wiring {
        bridges: (
            p.TIM1,
            bridges::Pins {
                #[cfg(not(any(feature = "three-axes", feature = "moteus")))]
                legs: legs::Legs { bridge_1: (p.PE9, p.PE11), bridge_2: (p.PE13, p.PE14) },
                #[cfg(feature = "three-axes")]
                legs: legs::Legs {
                    bridge_1: (p.PE9, p.PE8),
                    bridge_2: (p.PE11, p.PE10),
                    bridge_3: (p.PE13, p.PE12),
                    gate: p.PE14,
                },
                #[cfg(feature = "moteus")]
                legs: legs::Legs,
                enable: p.PF3,
                stop: p.PE15,
                fault: p.PE6,
                gate: p.PD15,
            },
        ),
        #[cfg(feature = "moteus")]
        can: drive::fdcan::Pins { can: p.FDCAN1, rx: p.PD0, tx: p.PD1 },
        #[cfg(not(feature = "moteus"))]
        encoders: encoders::Pins {
            #[cfg(not(feature = "spi-encoders"))]
            one: (p.TIM3, p.PC6, p.PC7, p.PC8),
            #[cfg(not(feature = "spi-encoders"))]
            two: (p.TIM4, p.PD12, p.PD13, p.PD14),
            #[cfg(feature = "spi-encoders")]
            one: (p.SPI5, p.PF7, p.PF8, p.PF9, p.PA4),
            #[cfg(feature = "spi-encoders")]
            two: (p.SPI3, p.PC10, p.PC11, p.PC12, p.PA15),
            #[cfg(feature = "three-axes")]
            three: (p.TIM2, p.PA5, p.PB3, p.PB10),
        },
        flash: p.FLASH,
        random: p.RNG,
        pace: p.TIM6,
        halts: p.TIM7,
        watchdog: p.IWDG1,
        strap: p.PG12,
        button: p.PC13,
        switch: p.PG14,
        alive: p.PB0,
        armed: p.PB14,
        #[cfg(feature = "usb")]
        cable: cable::Pins { core: p.USB_OTG_FS, plus: p.PA12, minus: p.PA11, supply: p.PA9 },
        #[cfg(not(feature = "usb"))]
        cable: cable::Pins {
            eth: p.ETH,
            sma: p.ETH_SMA,
            ref_clk: p.PA1,
            mdio: p.PA2,
            crs: p.PA7,
            tx_d1: p.PB13,
            mdc: p.PC1,
            rx_d0: p.PC4,
            rx_d1: p.PC5,
            tx_en: p.PG11,
            tx_d0: p.PG13,
        },
    }
}
