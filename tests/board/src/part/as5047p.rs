//! An AS5047P on one of the chip's SPI: what it makes of a frame, bit by bit of its data sheet, and its faults. The emulator's SPI clocks it while
//! its chip select is low.
//!
//! A command is executed as its frame ends, which is where its angle is sampled, and answered in the next one. Left out: writing, and all registers
//! but the three that the image reads: they are invalid commands.

use rigless::chip::Timeline;
use rigless::chip::spi::Peer;
use rigless::device::Level;
use rigless::snapshot::Store;
use rigless::soc::stm32h743::peripherals::gpio::Pin;
use rigless::soc::stm32h743::peripherals::spi::Select;
use serde::{Deserialize, Serialize};

/// Registers: errors, diagnosis, angle.
const ERRFL: u16 = 0x0001;
const DIAAGC: u16 = 0x3FFC;
const ANGLECOM: u16 = 0x3FFF;
/// Errors of a frame's length, of a command, of parity.
const FRAMING: u16 = 1;
const INVALID: u16 = 1 << 1;
const PARITY: u16 = 1 << 2;
/// Diagnosis: too weak, too strong; offsets are compensated for, and a gain in the middle.
const WEAK: u16 = 1 << 11;
const STRONG: u16 = 1 << 10;
const WELL: u16 = 1 << 8 | 0x80;

/// What is wrong with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Planted {
    /// Nothing.
    #[default]
    None,
    /// It has no supply, or its chip select is off: it hears nothing, and its line is pulled up.
    Dead,
    /// Its line is at ground.
    Shorted,
    /// What it hears is at ground.
    Deaf,
    /// These bits of all that it tells are wrong.
    Told(u16),
    /// These bits of all that it hears are wrong.
    Heard(u16),
    /// Its magnet is off.
    Weak,
    /// Another magnet is near.
    Strong,
    /// Its magnet has turned on its shaft by so many counts.
    Slipped(i64),
}

/// Model of the encoder.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct As5047p {
    /// What is wrong with it.
    pub planted: Planted,
    /// Where the joint is, counts of 2⁻¹⁴ of a revolution from where it was first turned on.
    pub counts: i64,
    /// Its angle there.
    begins: i64,
    errors: u16,
    /// The next answer.
    out: u16,
    /// What this frame brought.
    heard: Option<u16>,
    /// Since it was selected, and since it was not, ns.
    selected_ns: u64,
    released_ns: u64,
    /// Frames that there were.
    pub frames: u64,
    /// The shortest from its select to the end of its bits, and the shortest pause between two, ns.
    pub shortest_ns: [u64; 2],
}

impl Default for As5047p {
    fn default() -> Self {
        Self {
            planted: Planted::None,
            counts: 0,
            begins: 0,
            errors: 0,
            out: 0,
            heard: None,
            selected_ns: 0,
            released_ns: 0,
            frames: 0,
            shortest_ns: [u64::MAX; 2],
        }
    }
}

impl As5047p {
    /// One whose angle is that as it is first turned on.
    pub fn new(begins: i64) -> Self {
        Self { begins, ..Self::default() }
    }

    fn angle(&self) -> u16 {
        let slipped = if let Planted::Slipped(counts) = self.planted { counts } else { 0 };
        (self.begins + self.counts + slipped).rem_euclid(1 << 14) as u16
    }

    /// What a command reads.
    fn execute(&mut self, command: u16) {
        let is_even = command.count_ones().is_multiple_of(2);
        let data = match command & 0x7FFF {
            _ if !is_even => None,
            // To write nothing into nothing is allowed.
            0 => Some(0),
            command if command >> 14 == 0 => None,
            command => match command & 0x3FFF {
                ERRFL => Some(core::mem::take(&mut self.errors)),
                ANGLECOM => Some(self.angle()),
                DIAAGC => Some(match self.planted {
                    Planted::Weak => WELL | WEAK,
                    Planted::Strong => WELL | STRONG,
                    _ => WELL,
                }),
                _ => None,
            },
        };
        if data.is_none() {
            self.errors |= if is_even { INVALID } else { PARITY };
        }
        let lower = data.unwrap_or(0) | if self.errors == 0 { 0 } else { 1 << 14 };
        self.out = lower | if lower.count_ones().is_multiple_of(2) { 0 } else { 1 << 15 };
    }
}

impl Store for As5047p {}

impl Peer for As5047p {
    fn transfer(&mut self, mosi: u32, bits: u8, time: &mut Timeline<'_, '_>) -> u32 {
        let shortest = &mut self.shortest_ns[0];
        *shortest = (*shortest).min(time.now().0 - self.selected_ns);
        if bits != 16 || self.heard.is_some() {
            self.errors |= FRAMING;
        }
        let (heard, told) = match self.planted {
            Planted::Dead => return 0xFFFF,
            Planted::Shorted => (mosi as u16, 0),
            Planted::Deaf => (0, self.out),
            Planted::Told(wrong) => (mosi as u16, self.out ^ wrong),
            Planted::Heard(wrong) => (mosi as u16 ^ wrong, self.out),
            _ => (mosi as u16, self.out),
        };
        self.heard = Some(heard);
        told.into()
    }

    fn select(&mut self, time: &mut Timeline<'_, '_>) {
        self.selected_ns = time.now().0;
        if self.frames > 0 {
            let shortest = &mut self.shortest_ns[1];
            *shortest = (*shortest).min(self.selected_ns - self.released_ns);
        }
    }

    fn deselect(&mut self, time: &mut Timeline<'_, '_>) {
        self.released_ns = time.now().0;
        self.frames += 1;
        match self.heard.take() {
            Some(command) => self.execute(command),
            None if self.planted == Planted::Dead => {}
            None => self.errors |= FRAMING,
        }
    }
}

/// Encoders that are on the board.
pub const ENCODERS: usize = 2;
/// Of each: which of the chip's SPI it is on, by which pin of port A it is selected, and its angle as it is first turned on.
pub(super) const ON: [(usize, u8, i64); ENCODERS] = [(4, 4, 16_380), (2, 15, 5000)];

/// The chip select.
pub(super) fn select(pin: u8) -> Select {
    Select { port: "GPIOA", pin: Pin::new(pin).expect("a pin of the port"), active: Level::Low }
}
