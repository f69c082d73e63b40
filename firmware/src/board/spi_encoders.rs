//! Two absolute encoders on SPI in place of quadrature ([`firmware_parts::as5047p`]), each on a bus of its own: both are read at the same time.
//!
//! The tick reads them as it begins, two frames, and waits for them: 16 bits at 7.5 MHz take 2.1 µs, and 0.35 µs each are wanted between chip
//! select and clock and between two frames (t_L, t_CSn), 5.4 µs in all. What the encoder tells it sampled after the first of them, so a position
//! is 3 µs old where the peer takes it: no delay that a scene counts. A bus that does not bring a frame within [`LOOKS`] looks has
//! brought none: it is started anew, so that what comes late is not taken for the next frame, and the tick goes on.
//!
//! Mode 1 (clock low while idle, read at its falling edge), most significant bit first. The endless transfer of this SPI (TSIZE 0) starts with
//! what is written and ends with it: nothing is restarted from frame to frame, where the chip has errata. Chip selects are outputs.
//!
//! Encoders have 3.3 V: the board pulls MISO up, so that a wire that is off reads all ones.

use cohold_core::device::encoder::{Counts, Marks};
use cohold_core::safety::Fault;
use embassy_stm32::gpio::{AfType, Flex, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::pac::rcc::vals::{Saisel, Spi45sel};
use embassy_stm32::pac::spi::{Spi, vals};
use embassy_stm32::peripherals::{PA4, PA15, PC10, PC11, PC12, PF7, PF8, PF9, SPI3, SPI5};
use embassy_stm32::{Peri, pac, rcc};
use firmware_parts::as5047p::{self, ANGLE, Sensor, Trouble};
use firmware_parts::image::JOINTS;
use firmware_parts::signals::Signals;

use super::clocks::{CORE_HZ, PERIPHERALS_HZ};

/// A bus and its pins: clock, from the encoder, to the encoder, chip select.
type Bus<T, C, I, O, S> = (Peri<'static, T>, Peri<'static, C>, Peri<'static, I>, Peri<'static, O>, Peri<'static, S>);

/// Each encoder's.
pub(crate) struct Pins {
    pub(crate) one: Bus<SPI5, PF7, PF8, PF9, PA4>,
    pub(crate) two: Bus<SPI3, PC10, PC11, PC12, PA15>,
}

/// What the settings make of them.
pub(crate) type Plan = as5047p::Design;

const BUSES: [Spi; JOINTS] = [pac::SPI5, pac::SPI3];
/// Chip selects of both, on port A.
const SELECTS: u32 = 1 << 4 | 1 << 15;

/// SPI3 runs on PLL1's Q and SPI5 on its bus's clock, which are as fast; the encoder's own limit is 10 MHz.
const DIVIDER: vals::Mbr = vals::Mbr::DIV16;
const _: () = assert!(PERIPHERALS_HZ / 16 <= 10_000_000);
/// Cycles of 0.35 µs, and one.
const PAUSE: u32 = CORE_HZ / 1_000_000 * 350 / 1000 + 1;
/// Looks for a frame: 5 µs at the least, each being two accesses to the bus and more.
const LOOKS: u32 = 500;

/// Starts both buses, with no encoder selected.
pub(crate) fn init(pins: Pins) {
    pac::RCC.d2ccip1r().modify(|w| {
        w.set_spi123sel(Saisel::PLL1_Q);
        w.set_spi45sel(Spi45sel::PCLK2);
    });
    rcc::enable_and_reset::<SPI5>();
    rcc::enable_and_reset::<SPI3>();
    let (_spi, clock, from, to, select) = pins.one;
    lead(
        [(Flex::new(clock), 5), (Flex::new(to), 5)],
        (Flex::new(from), 5),
        Output::new(select, Level::High, Speed::Medium),
    );
    let (_spi, clock, from, to, select) = pins.two;
    lead(
        [(Flex::new(clock), 6), (Flex::new(to), 6)],
        (Flex::new(from), 6),
        Output::new(select, Level::High, Speed::Medium),
    );
    for spi in BUSES {
        spi.cfg1().write(|w| {
            w.set_dsize(15);
            w.set_mbr(DIVIDER);
        });
        // A master that nobody else selects: with SSM, SSI says so.
        spi.cr1().write(|w| w.set_ssi(true));
        spi.cfg2().write(|w| {
            w.set_ssm(true);
            w.set_master(vals::Master::MASTER);
            w.set_cpha(vals::Cpha::SECOND_EDGE);
        });
        start(spi);
    }
}

/// Leads pins to a bus, by these alternate functions, for as long as there is power.
fn lead(driven: [(Flex<'static>, u8); 2], (mut from, function): (Flex<'static>, u8), select: Output<'static>) {
    for (mut pin, function) in driven {
        pin.set_as_af_unchecked(function, AfType::output(OutputType::PushPull, Speed::Medium));
        core::mem::forget(pin);
    }
    from.set_as_af_unchecked(function, AfType::input(Pull::Up));
    core::mem::forget((from, select));
}

/// Starts a bus: from here on it sends what is written, and has nothing from before.
#[cold]
#[inline(never)]
#[unsafe(link_section = ".itcm.encoders")]
fn start(spi: Spi) {
    spi.cr1().write(|w| w.set_ssi(true));
    spi.cr1().modify(|w| w.set_spe(true));
    spi.cr1().modify(|w| w.set_cstart(true));
}

/// A frame each way on every bus, at the same time; none where it did not come.
#[inline(never)]
#[unsafe(link_section = ".itcm.encoders")]
fn frames(commands: [u16; JOINTS]) -> [Option<u16>; JOINTS] {
    pac::GPIOA.bsrr().write(|w| w.0 = SELECTS << 16);
    cortex_m::asm::delay(PAUSE);
    for (spi, command) in BUSES.iter().zip(commands) {
        spi.txdr16().write_value(command);
    }
    let answers = BUSES.map(|spi| {
        if (0..LOOKS).any(|_| spi.sr().read().rxp()) {
            Some(spi.rxdr16().read())
        } else {
            start(spi);
            None
        }
    });
    pac::GPIOA.bsrr().write(|w| w.0 = SELECTS);
    answers
}

/// Both encoders, and whom to tell of them.
pub(crate) struct Encoders {
    sensors: [Sensor; JOINTS],
    signals: &'static Signals,
}

impl Encoders {
    pub(crate) fn start(signals: &'static Signals) -> Self {
        Self { sensors: [Sensor::default(); JOINTS], signals }
    }

    /// What stands against driving now, and what the motors were turned off for since they were last on.
    pub(crate) fn says(signals: &Signals) -> [Option<&'static str>; 2] {
        [signals.drive.get(), signals.drive_last.get()].map(Trouble::explain)
    }

    /// What they were turned off for is over.
    pub(crate) fn forget(&self) {
        self.signals.drive_last.set(Trouble::default());
    }

    /// Where the joints are; a fault, unless there is one, where that is not known of motors that are driven, or no longer of any.
    #[inline(always)]
    pub(crate) fn read(&mut self, plan: &Plan, driving: bool, fault: &mut Option<Fault>) -> [Counts; JOINTS] {
        let mut commands = [ANGLE; JOINTS];
        let answers = frames(commands);
        for ((sensor, command), answer) in self.sensors.iter_mut().zip(&mut commands).zip(answers) {
            *command = sensor.first(answer);
        }
        cortex_m::asm::delay(PAUSE);
        for (sensor, answer) in self.sensors.iter_mut().zip(frames(commands)) {
            sensor.second(answer);
        }
        let (trouble, found) = as5047p::judge(plan, &self.sensors, driving);
        self.signals.drive.set(trouble);
        if found.is_some() && driving {
            self.signals.drive_last.set(trouble);
        }
        *fault = fault.or(found);
        self.sensors.each_ref().map(Sensor::counts)
    }

    /// They have none: what a wire does wrong shows in their frames.
    #[inline(always)]
    pub(crate) fn marks(&mut self) -> Option<[Marks; JOINTS]> {
        None
    }
}
