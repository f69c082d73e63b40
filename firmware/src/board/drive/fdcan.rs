//! FDCAN1 as a drive needs it: one frame out a tick, the newest frame in, both with flexible data rate; no interrupt, no queue.
//!
//! Bits: 1 Mbit/s in arbitration, 5 Mbit/s in the data (BRS), both sampled at two thirds, from PLL1's Q at 120 MHz, which is no faster than the
//! bus's clock (RM0433 §56.3). Delay of the transceiver is compensated for at 5 Mbit/s (TDC).
//!
//! **Out**: transmit buffer 0, not repeated by itself (DAR): what could not be sent in its tick must not be sent in a later one. A frame that still
//! waits when the next is due is withdrawn, and that one is left out. **In**: whatever comes, to FIFO 0; the newest is taken, the others are let go.
//!
//! Message memory, 10 kB at 0x4000_AC00, in words: the transmit buffer (2 and 12), then four places of FIFO 0 (2 and 8 each). It
//! holds anything at power-on: what is read was received, and what is sent was written.

use embassy_stm32::gpio::{AfType, Flex, OutputType, Pull, Speed};
use embassy_stm32::pac::can::regs::{Rxfa, Txbar, Txbcr};
use embassy_stm32::pac::{self, can::Fdcan};
use embassy_stm32::peripherals::{FDCAN1, PD0, PD1};
use embassy_stm32::{Peri, rcc};
use firmware_parts::moteus::{ANSWER_WORDS, COMMAND_WORDS};

use crate::board::clocks::PERIPHERALS_HZ;

/// The controller, and its two pins: in, out.
pub(crate) struct Pins {
    pub(crate) can: Peri<'static, FDCAN1>,
    pub(crate) rx: Peri<'static, PD0>,
    pub(crate) tx: Peri<'static, PD1>,
}

const CAN: Fdcan = pac::FDCAN1;
const MEMORY: *mut u32 = 0x4000_AC00 as *mut u32;
/// Words of an element's head, of the transmit buffer, and of a place of the FIFO.
const HEAD: usize = 2;
const OUT_WORDS: usize = HEAD + COMMAND_WORDS;
const IN_WORDS: usize = HEAD + 8;
const PLACES: usize = 4;

/// Clock of a bit's parts, PLL1's Q, Hz.
const QUANTA_HZ: u32 = 120_000_000;
/// Quanta of a bit: before its sample (with the first, which stands alone), and after it.
const NOMINAL: [u32; 2] = [80, 40];
const DATA: [u32; 2] = [16, 8];
const _: () = assert!(QUANTA_HZ <= PERIPHERALS_HZ);
const _: () =
    assert!((NOMINAL[0] + NOMINAL[1]) * 1_000_000 == QUANTA_HZ && (DATA[0] + DATA[1]) * 5_000_000 == QUANTA_HZ);

/// CCCR: initialising, changes allowed, no repetition, flexible data rate, its switching.
const INIT: u32 = 1;
const CCE: u32 = 1 << 1;
const DAR: u32 = 1 << 6;
const FDOE: u32 = 1 << 8;
const BRSE: u32 = 1 << 9;
/// An identifier of 29 bits; flexible data rate, its switching, 48 bytes.
const EXTENDED: u32 = 1 << 30;
const FRAME: u32 = 1 << 21 | 1 << 20 | 14 << 16;

/// Starts it: on the bus from 11 recessive bits on.
pub(crate) fn start(pins: Pins) {
    let Pins { can: _can, rx, tx } = pins;
    pac::RCC.d2ccip1r().modify(|w| w.set_fdcansel(pac::rcc::vals::Fdcansel::PLL1_Q));
    rcc::enable_and_reset::<FDCAN1>();
    let (mut rx, mut tx) = (Flex::new(rx), Flex::new(tx));
    // Alternate function 9 of both. Without a transceiver nothing holds the input, and low would be a bus that is jammed.
    rx.set_as_af_unchecked(9, AfType::input(Pull::Up));
    tx.set_as_af_unchecked(9, AfType::output(OutputType::PushPull, Speed::VeryHigh));
    core::mem::forget((rx, tx));
    CAN.cccr().write(|w| w.0 = INIT);
    let _ = (0..1000).any(|_| CAN.cccr().read().init());
    CAN.cccr().write(|w| w.0 = INIT | CCE);
    CAN.cccr().write(|w| w.0 = INIT | CCE | DAR | FDOE | BRSE);
    // Each field is one less than what it means; resynchronised by as much as the part behind the sample.
    let [before, after] = NOMINAL;
    CAN.nbtp().write(|w| w.0 = (after - 1) << 25 | (before - 2) << 8 | (after - 1));
    let [before, after] = DATA;
    CAN.dbtp().write(|w| w.0 = 1 << 23 | (before - 2) << 8 | (after - 1) << 4 | (after - 1));
    // The second sample point is as far into the bit as the first.
    CAN.tdcr().write(|w| w.0 = before << 8);
    // No filter: frames of either kind of identifier go to FIFO 0, remote ones nowhere.
    CAN.gfc().write(|w| w.0 = 0b11);
    CAN.rxfc(0).write(|w| w.0 = ((PLACES as u32) << 16) | (4 * OUT_WORDS as u32));
    // Data of 32 bytes in a place, of 48 in the buffer.
    CAN.rxesc().write(|w| w.0 = 0b101);
    CAN.txbc().write(|w| w.0 = 1 << 16);
    CAN.txesc().write(|w| w.0 = 0b110);
    CAN.cccr().write(|w| w.0 = DAR | FDOE | BRSE);
}

/// Whether it went off the bus after errors.
#[inline(always)]
pub(crate) fn is_off() -> bool {
    CAN.psr().read().bo()
}

/// Comes back after that, when 129 times 11 recessive bits have passed; nothing changes for one that is there.
pub(crate) fn come_back() {
    CAN.cccr().write(|w| w.0 = DAR | FDOE | BRSE);
}

/// The newest frame that came, if it is from there and as long; whatever else came is gone.
#[inline(always)]
pub(crate) fn newest(identifier: u32) -> Option<[u32; ANSWER_WORDS]> {
    let status = CAN.rxfs(0).read().0;
    let level = status as usize & 0x7F;
    if level == 0 {
        return None;
    }
    let place = ((status >> 8) as usize + level - 1) & (PLACES - 1);
    let word = |at: usize| {
        // SAFETY: within the FIFO, whose places the controller writes only after they were let go.
        unsafe { MEMORY.add(OUT_WORDS + place * IN_WORDS + at).read_volatile() }
    };
    // Its own error state says nothing about the answer.
    let ours = word(0) & !(1 << 31) == identifier && word(1) >> 16 & 0xF == 12;
    let words = core::array::from_fn(|at| word(HEAD + at));
    CAN.rxfa(0).write_value(Rxfa(place as u32));
    ours.then_some(words)
}

/// Sends a frame to there, unless the one before it still waits: that one is withdrawn.
#[inline(always)]
pub(crate) fn send(identifier: u32, words: &[u32; COMMAND_WORDS]) {
    if CAN.txbrp().read().0 & 1 != 0 {
        CAN.txbcr().write_value(Txbcr(1));
        return;
    }
    let put = |at: usize, word: u32| {
        // SAFETY: within the transmit buffer, which the controller reads only while something waits.
        unsafe { MEMORY.add(at).write_volatile(word) }
    };
    put(0, EXTENDED | identifier);
    put(1, FRAME);
    for (at, word) in words.iter().enumerate() {
        put(HEAD + at, *word);
    }
    CAN.txbar().write_value(Txbar(1));
}
