//! The board: NUCLEO-H743ZI2 with two encoders and two motor bridges, or three (feature `three-axes`). The only folder that knows the chip.
//!
//! docs/assembly.md has the wiring. Ethernet is the Nucleo's own.
//!
//! Interrupt priorities, most urgent first: 0 current loop, 1 tick, 2 bell, 3 supervisor, 4 time driver, 5 Ethernet, 6 network executor,
//! thread: storage. A critical section masks 2 and everything below it, never the loop or the tick.

mod breaks;
pub(crate) mod bridges;
pub(crate) mod clocks;
#[cfg_attr(feature = "three-axes", path = "amplifiers.rs")]
pub(crate) mod current;
pub(crate) mod deadman;
pub(crate) mod encoders;
pub(crate) mod ethernet;
pub(crate) mod flash;
pub(crate) mod gate;
pub(crate) mod memory;
pub(crate) mod pace;
pub(crate) mod random;
pub(crate) mod reset;
mod sections;
mod uptime;

use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::{Peri, peripherals::TIM6, wdg::IndependentWatchdog};
use haptic_protocol::wire::PeerId;

/// The number of this board in the pair, by its strap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub(crate) enum Number {
    /// Strap open: on the left, pushes toward positive x.
    One,
    /// Strap to ground: on the right.
    Two,
}

impl Number {
    pub(crate) fn peer(self) -> PeerId {
        PeerId(self as u8 + 1)
    }

    pub(crate) fn other(self) -> Self {
        match self {
            Self::One => Self::Two,
            Self::Two => Self::One,
        }
    }
}

pub(crate) struct Board {
    pub(crate) number: Number,
    /// Why it must not be armed, whatever anybody acknowledges.
    pub(crate) unfit: Option<&'static str>,
    /// The 1 kHz timer, not yet running.
    pub(crate) pace: Peri<'static, TIM6>,
    /// The watchdog, not yet running.
    pub(crate) watchdog: IndependentWatchdog<'static, embassy_stm32::peripherals::IWDG1>,
    pub(crate) flash: flash::Settings,
    pub(crate) ethernet: ethernet::Pins,
    /// The blue one; high while pressed.
    pub(crate) button: Input<'static>,
    /// Blinks while the supervisor runs.
    pub(crate) alive: Output<'static>,
    /// Lit while the motors are on.
    pub(crate) armed: Output<'static>,
}

/// Milliseconds without a sign of life after which the watchdog resets the chip, and with it turns the outputs off.
/// Nominal: the oscillator behind it is good to a few per cent.
pub(crate) const WATCHDOG_MS: u32 = 25;

/// Brings up everything but the tick, the watchdog and the network. Bridges stay off.
pub(crate) fn init() -> Board {
    // Before anything that could be waited for.
    bridges::disable();
    // Nothing placed in ITCM has been called yet: main does this first.
    memory::load_itcm();
    let external = clocks::external();
    let p = embassy_stm32::init(clocks::config(external));
    bridges::init(
        p.TIM1,
        bridges::Pins {
            #[cfg(not(feature = "three-axes"))]
            legs: bridges::Legs { bridge_1: (p.PE9, p.PE11), bridge_2: (p.PE13, p.PE14) },
            #[cfg(feature = "three-axes")]
            legs: bridges::Legs {
                bridge_1: (p.PE9, p.PE8),
                bridge_2: (p.PE11, p.PE10),
                bridge_3: (p.PE13, p.PE12),
                gate: p.PE14,
            },
            enable: p.PF3,
            stop: p.PE15,
            fault: p.PE6,
            gate: p.PD15,
        },
    );
    breaks::connect(external);
    current::init();
    uptime::put_right();
    memory::protect();
    encoders::init(p.TIM3, (p.PC6, p.PC7, p.PC8), p.TIM4, (p.PD12, p.PD13, p.PD14));
    #[cfg(feature = "three-axes")]
    encoders::init_third(p.TIM2, (p.PA5, p.PB3, p.PB10));
    // All interrupts come out of reset at priority 0, the current loop's own.
    interrupt::TIM5.set_priority(Priority::P4);
    interrupt::ETH.set_priority(Priority::P5);
    let mut flash = flash::Settings::new(p.FLASH);
    random::start(p.RNG, flash.count_boot());
    let strap = Input::new(p.PG12, Pull::Up);
    // The pull-up charges the pin within a microsecond; give it ten.
    cortex_m::asm::delay(4_800);
    Board {
        number: if strap.is_high() { Number::One } else { Number::Two },
        unfit: breaks::unfit(external),
        pace: p.TIM6,
        watchdog: IndependentWatchdog::new(p.IWDG1, WATCHDOG_MS * 1000),
        flash,
        ethernet: ethernet::Pins {
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
        // Pulled down on the Nucleo, too: without it nothing is pressed.
        button: Input::new(p.PC13, Pull::Down),
        alive: Output::new(p.PB0, Level::Low, Speed::Low),
        armed: Output::new(p.PB14, Level::Low, Speed::Low),
    }
}
