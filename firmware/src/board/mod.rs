//! The chip, an STM32H743 or H753, and what is at its pins. The only folder that knows it; [`crate::boards`] knows which pin is wired to what.
//!
//! docs/guides/board/assembly.md has the wiring. Ethernet is the Nucleo's own, and so is USB in its place (feature `usb`).
//!
//! Interrupt priorities, most urgent first: 0 current loop, 1 tick, 2 bell, 3 supervisor, 4 time driver, 5 Ethernet or USB, 6 network executor,
//! thread: storage. A critical section masks 2 and everything below it, never the loop or the tick.

mod breaks;
pub(crate) mod bridges;
#[cfg_attr(feature = "usb", path = "usb.rs")]
#[cfg_attr(not(feature = "usb"), path = "ethernet.rs")]
pub(crate) mod cable;
pub(crate) mod clocks;
#[cfg_attr(feature = "three-axes", path = "amplifiers.rs")]
#[cfg_attr(feature = "moteus", path = "no_loop.rs")]
pub(crate) mod current;
pub(crate) mod deadman;
pub(crate) mod drive;
#[cfg(not(feature = "moteus"))]
#[cfg_attr(feature = "spi-encoders", path = "spi_encoders.rs")]
pub(crate) mod encoders;
pub(crate) mod flash;
#[cfg(not(feature = "moteus"))]
pub(crate) mod gate;
#[cfg_attr(feature = "moteus", path = "no_legs.rs")]
pub(crate) mod legs;
pub(crate) mod memory;
#[cfg(feature = "three-axes")]
mod no_loop;
pub(crate) mod pace;
pub(crate) mod random;
pub(crate) mod reset;
mod sections;
pub(crate) mod switch;
pub(crate) mod update;
mod uptime;

use cohold_protocol::wire::PeerId;
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::peripherals::{FLASH, IWDG1, PB0, PB14, PC13, PG12, PG14, RNG, TIM1, TIM6, TIM7};
use embassy_stm32::{Peri, wdg::IndependentWatchdog};

use crate::boards;

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
    pub(crate) halts: Peri<'static, TIM7>,
    /// The watchdog, not yet running.
    pub(crate) watchdog: IndependentWatchdog<'static, IWDG1>,
    pub(crate) flash: flash::Settings,
    /// The source of random numbers, not yet running.
    pub(crate) random: Peri<'static, RNG>,
    pub(crate) cable: cable::Pins,
    /// The blue one; high while pressed.
    pub(crate) button: Input<'static>,
    /// The hold-to-run switch, not yet looked at.
    pub(crate) switch: Peri<'static, PG14>,
    /// Blinks while the supervisor runs.
    pub(crate) alive: Output<'static>,
    /// Lit while the motors are on.
    pub(crate) armed: Output<'static>,
}

/// What a board says of its pins.
pub(crate) struct Wiring {
    pub(crate) bridges: (Peri<'static, TIM1>, bridges::Pins),
    #[cfg(not(feature = "moteus"))]
    pub(crate) encoders: encoders::Pins,
    #[cfg(feature = "moteus")]
    pub(crate) can: drive::fdcan::Pins,
    pub(crate) flash: Peri<'static, FLASH>,
    pub(crate) random: Peri<'static, RNG>,
    pub(crate) pace: Peri<'static, TIM6>,
    pub(crate) halts: Peri<'static, TIM7>,
    pub(crate) watchdog: Peri<'static, IWDG1>,
    /// To ground: board 2.
    pub(crate) strap: Peri<'static, PG12>,
    /// The blue one.
    pub(crate) button: Peri<'static, PC13>,
    /// The hold-to-run switch.
    pub(crate) switch: Peri<'static, PG14>,
    /// The green light.
    pub(crate) alive: Peri<'static, PB0>,
    /// The red light.
    pub(crate) armed: Peri<'static, PB14>,
    pub(crate) cable: cable::Pins,
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
    let w = boards::wiring(embassy_stm32::init(clocks::config(external)));
    uptime::put_right();
    let (timer, pins) = w.bridges;
    bridges::init(timer, pins);
    breaks::connect(external);
    let converter = current::init();
    memory::protect();
    #[cfg(not(feature = "moteus"))]
    encoders::init(w.encoders);
    #[cfg(feature = "moteus")]
    drive::fdcan::start(w.can);
    // All interrupts come out of reset at priority 0, the current loop's own.
    interrupt::TIM5.set_priority(Priority::P4);
    cable::INTERRUPT.set_priority(Priority::P5);
    let strap = Input::new(w.strap, Pull::Up);
    // The pull-up charges the pin within a microsecond; give it ten.
    cortex_m::asm::delay(4_800);
    Board {
        number: if strap.is_high() { Number::One } else { Number::Two },
        unfit: breaks::unfit(external).or(converter.err()),
        pace: w.pace,
        halts: w.halts,
        watchdog: IndependentWatchdog::new(w.watchdog, WATCHDOG_MS * 1000),
        flash: flash::Settings::new(w.flash),
        random: w.random,
        cable: w.cable,
        // Pulled down on the Nucleo, too: without it nothing is pressed.
        button: Input::new(w.button, Pull::Down),
        switch: w.switch,
        alive: Output::new(w.alive, Level::Low, Speed::Low),
        armed: Output::new(w.armed, Level::Low, Speed::Low),
    }
}
