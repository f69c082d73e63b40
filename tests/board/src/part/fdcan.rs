//! FDCAN1 (RM0433 §56) as the image for a moteus uses it, its message memory, and the bus with one controller at its other end.
//!
//! Modelled so that mistakes show: nothing is sent or heard while INIT is set; configuration is taken with CCE alone; bit rates come of the kernel's
//! clock and the timing registers, and at others than 1 and 5 Mbit/s nobody understands anything; elements lie in the message memory where the
//! registers say, and beyond it is an error; a frame takes its time on the bus, and one that waits is not changed; FIFO 0 that is full loses what
//! comes; error counters, and the bus-off that ends them.
//!
//! A register that the image does not use is refused loudly: whatever is written there is told in the report.
//!
//! Left out: filters (what does not match goes to FIFO 0), repetition (it must be off), FIFO 1, dedicated receive buffers, events, interrupts,
//! time stamps, time-triggered operation, other nodes, stuff bits as the data has them: the most that there can be are counted.

use std::num::NonZeroU64;
use std::sync::{Arc, Mutex, MutexGuard};

use rigless::device::{Device, DeviceContext, ErasedDevice, RegisterFile, RequestChange};
use rigless::soc::stm32h743::generated::fdcan1::Register;
use rigless::soc::{RegisterSpec, Width};
use rigless::time::{EventId, VirtualNanos};
use serde::{Deserialize, Serialize};

use super::moteus::Controller;

/// Bytes of the message memory, and where it is.
pub(super) const MEMORY: NonZeroU64 = NonZeroU64::new(10 * 1024).expect("it has some");
pub(super) const MEMORY_AT: u64 = 0x4000_AC00;

/// CCCR.
const INIT: u64 = 1;
const CCE: u64 = 1 << 1;
const DAR: u64 = 1 << 6;
const FDOE: u64 = 1 << 8;
const BRSE: u64 = 1 << 9;
/// Errors in a row of a sender, each of which counts 8, that send it off the bus.
const OFF_AT: u32 = 256;
/// From coming back to being there: 129 times 11 bits of 1 µs.
const BACK_NS: u64 = 129 * 11 * 1000;

/// What the two halves share.
type Words = Arc<Mutex<Vec<u32>>>;

/// The message memory, as the processor sees it.
#[derive(Debug)]
pub struct MessageMemory {
    words: Words,
    /// No registers, and those of the emulator's own window.
    pub(super) layout: &'static [RegisterSpec],
}

/// What is wrong with the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum BusFault {
    /// Nothing.
    #[default]
    None,
    /// A wire is off: nobody acknowledges.
    Open,
    /// Its two wires touch: whatever is sent is read back wrong.
    Shorted,
}

/// A frame: identifier, whether that has 29 bits, data.
pub type Frame = (u32, bool, Vec<u8>);

/// Model of the CAN controller.
#[derive(Debug)]
pub struct Fdcan {
    memory: Words,
    kernel_hz: u64,
    control: u64,
    /// Its count of errors as a sender.
    pub errors: u32,
    off: bool,
    back: Option<EventId>,
    /// What is on the bus, and when it has passed.
    sending: Option<(EventId, Frame)>,
    answering: Option<(EventId, Frame)>,
    /// FIFO 0: places in use, the oldest, and whether one was lost.
    level: u64,
    oldest: u64,
    lost: bool,
    /// What is wrong with the bus.
    pub fault: BusFault,
    /// What is at the other end.
    pub controller: Controller,
    /// Frames that were sent, and heard.
    pub frames: [u64; 2],
}

/// The controller and its memory, which holds anything at power-on.
pub fn pair() -> (Fdcan, MessageMemory) {
    let memory = Arc::new(Mutex::new(vec![0xA5A5_A5A5; MEMORY.get() as usize / 4]));
    let fdcan = Fdcan {
        memory: memory.clone(),
        kernel_hz: 0,
        control: INIT,
        errors: 0,
        off: false,
        back: None,
        sending: None,
        answering: None,
        level: 0,
        oldest: 0,
        lost: false,
        fault: BusFault::None,
        controller: Controller::default(),
        frames: [0; 2],
    };
    (fdcan, MessageMemory { words: memory, layout: &[] })
}

/// Bytes of a data length code.
const LENGTHS: [usize; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

/// How long a frame with flexible data rate and its switching takes, ns, with as many stuff bits as there can be.
fn lasts_ns(extended: bool, bytes: usize) -> u64 {
    let stuffed = |bits: u64| bits + bits / 4;
    let head = stuffed(if extended { 36 } else { 17 });
    // Error state and length; data; then stuff count and checksum, with stuff bits at fixed places.
    let data = stuffed(5 + 8 * bytes as u64) + if bytes > 16 { 31 } else { 26 };
    (head + 13) * 1000 + data * 200
}

impl Fdcan {
    fn words(&self) -> MutexGuard<'_, Vec<u32>> {
        self.memory.lock().expect("nobody panics with it")
    }

    /// The bits of both rates, per second.
    fn rates(&self, f: &RegisterFile) -> [u64; 2] {
        let (nominal, data) = (f.get(Register::FdcanNbtp), f.get(Register::FdcanDbtp));
        let of = |prescaler: u64, before: u64, after: u64| self.kernel_hz / ((prescaler + 1) * (before + after + 3));
        [
            of(nominal >> 16 & 0x1FF, nominal >> 8 & 0xFF, nominal & 0x7F),
            of(data >> 16 & 0x1F, data >> 8 & 0x1F, data >> 4 & 0xF),
        ]
    }

    /// Bytes of data in an element of the receive FIFO or the transmit buffers, by its code.
    fn element(code: u64) -> usize {
        [8, 12, 16, 20, 24, 32, 48, 64][(code & 7) as usize]
    }

    /// The frame in transmit buffer 0; or why there is none.
    fn waiting(&self, f: &RegisterFile) -> Result<Frame, &'static str> {
        let (buffers, size) = (f.get(Register::FdcanTxbc), Self::element(f.get(Register::FdcanTxesc)));
        if buffers >> 16 & 0x3F != 1 || buffers >> 24 != 0 {
            return Err("one dedicated transmit buffer is what is modelled");
        }
        let (words, at) = (self.words(), (buffers & 0xFFFC) as usize / 4);
        let element = words.get(at..at + 2 + size / 4).ok_or("the transmit buffer is beyond the message memory")?;
        let (head, length) = (element[0], LENGTHS[(element[1] >> 16 & 15) as usize]);
        if element[1] >> 20 & 3 != 3 || length > size {
            return Err("flexible data rate with its switching, and no more than fits, is what is modelled");
        }
        let extended = head & 1 << 30 != 0;
        let identifier = if extended { head & 0x1FFF_FFFF } else { head >> 18 & 0x7FF };
        let bytes = element[2..].iter().flat_map(|word| word.to_le_bytes()).take(length).collect();
        Ok((identifier, extended, bytes))
    }

    /// Puts a frame into FIFO 0.
    fn take(&mut self, (identifier, extended, bytes): &Frame, f: &RegisterFile, c: &mut DeviceContext<'_>) {
        let (fifo, size) = (f.get(Register::FdcanRxf0c), Self::element(f.get(Register::FdcanRxesc)));
        let places = fifo >> 16 & 0x7F;
        if self.level >= places {
            self.lost = true;
            return;
        }
        let place = ((self.oldest + self.level) % places) as usize;
        let at = (fifo & 0xFFFC) as usize / 4 + place * (2 + size / 4);
        let mut words = self.words();
        let Some(element) = words.get_mut(at..at + 2 + size / 4) else {
            c.tell("FDCAN_RXF0C", "a place of the FIFO is beyond the message memory");
            return;
        };
        let code =
            LENGTHS.iter().position(|length| *length == bytes.len()).expect("a frame has a length that there is");
        element[0] = if *extended { 1 << 30 | identifier } else { identifier << 18 };
        element[1] = 1 << 31 | 3 << 20 | (code as u32) << 16;
        for (word, bytes) in element[2..].iter_mut().zip(bytes.chunks(4)) {
            *word = bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
        }
        drop(words);
        self.level += 1;
        self.frames[1] += 1;
    }

    /// An attempt to send failed. One that nobody acknowledges counts up to where a sender is passive, and no further.
    fn failed(&mut self) {
        self.errors += if self.fault != BusFault::Shorted && self.errors >= 128 { 0 } else { 8 };
        if self.errors >= OFF_AT {
            (self.off, self.control) = (true, self.control | INIT);
        }
    }

    fn send(&mut self, f: &RegisterFile, c: &mut DeviceContext<'_>) {
        if self.control & INIT != 0 || self.off || self.sending.is_some() {
            return;
        }
        if self.control & (DAR | FDOE | BRSE) != DAR | FDOE | BRSE || self.rates(f) != [1_000_000, 5_000_000] {
            c.tell("FDCAN_TXBAR", "flexible data rate at 1 and 5 Mbit/s, each frame once, is what the bus understands");
            return;
        }
        match self.waiting(f) {
            Ok(frame) => {
                let ends = c.now().0 + lasts_ns(frame.1, frame.2.len());
                self.sending = Some((c.schedule(VirtualNanos(ends)), frame));
            }
            Err(why) => c.tell("FDCAN_TXBAR", why),
        }
    }

    /// What a register reads that is not as it was written.
    fn word(&self, register: Register, f: &RegisterFile) -> Option<u64> {
        let places = (f.get(Register::FdcanRxf0c) >> 16 & 0x7F).max(1);
        Some(match register {
            Register::FdcanCccr => self.control,
            Register::FdcanPsr => u64::from(self.off) << 7 | u64::from(self.errors >= 128) << 5,
            Register::FdcanEcr => u64::from(self.errors.min(255)),
            Register::FdcanTxbrp => u64::from(self.sending.is_some()),
            Register::FdcanRxf0s => {
                let newest = (self.oldest + self.level) % places;
                self.level | self.oldest << 8 | newest << 16 | u64::from(self.lost) << 25
            }
            _ => return None,
        })
    }
}

impl Device for Fdcan {
    type Register = Register;

    fn read(&mut self, register: Register, f: &mut RegisterFile, _: &mut DeviceContext<'_>) -> Option<u64> {
        self.word(register, f)
    }
    fn peek(&self, register: Register, f: &RegisterFile, _: VirtualNanos) -> Option<u64> {
        self.word(register, f)
    }
    fn write(&mut self, register: Register, value: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        match register {
            Register::FdcanCccr => {
                let runs = self.control & INIT != 0 && value & INIT == 0;
                // What configures is taken with CCE only, and CCE with INIT only.
                let kept = if self.control & CCE == 0 { self.control & (DAR | FDOE | BRSE) } else { value & !3 };
                let change = if value & INIT != 0 && self.control & INIT != 0 { value & CCE } else { 0 };
                self.control = kept | value & INIT | change;
                if runs && self.off && self.back.is_none() {
                    self.back = Some(c.schedule(VirtualNanos(c.now().0 + BACK_NS)));
                }
            }
            // The vendor's file has some of these as read-only; they are written while configuring.
            Register::FdcanNbtp
            | Register::FdcanDbtp
            | Register::FdcanTdcr
            | Register::FdcanGfc
            | Register::FdcanRxf0c
            | Register::FdcanRxesc
            | Register::FdcanTxbc
            | Register::FdcanTxesc => {
                if self.control & CCE == 0 {
                    c.tell("FDCAN_CCCR", "configuration is locked");
                } else {
                    f.set(register, value);
                }
            }
            Register::FdcanRxf0a => {
                // Everything up to this place is let go.
                let places = (f.get(Register::FdcanRxf0c) >> 16 & 0x7F).max(1);
                let gone = ((value & 0x3F) + places - self.oldest) % places + 1;
                if gone > self.level {
                    c.tell("FDCAN_RXF0A", "what was not received is let go of");
                }
                self.level -= gone.min(self.level);
                self.oldest = ((value & 0x3F) + 1) % places;
            }
            Register::FdcanTxbar if value == 1 => self.send(f, c),
            // What is on the bus already goes on.
            Register::FdcanTxbcr if value == 1 => {}
            _ => c.tell("FDCAN", "a register that the model does not know was written"),
        }
    }
    fn on_event(&mut self, event: EventId, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        if self.back == Some(event) {
            (self.back, self.off, self.errors) = (None, false, 0);
        } else if let Some((_, frame)) = self.sending.take_if(|(ends, _)| *ends == event) {
            if self.fault != BusFault::None || !self.controller.hears() {
                self.failed();
                return;
            }
            self.errors = self.errors.saturating_sub(1);
            self.frames[0] += 1;
            if let Some((answer, think_ns)) = self.controller.hear(c.now().0, &frame) {
                let ends = c.now().0 + think_ns + lasts_ns(answer.1, answer.2.len());
                self.answering = Some((c.schedule(VirtualNanos(ends)), answer));
            }
        } else if let Some((_, answer)) = self.answering.take_if(|(ends, _)| *ends == event)
            && self.control & INIT == 0
            && self.fault == BusFault::None
        {
            self.take(&answer, f, c);
        }
    }
    fn on_clock(&mut self, hz: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        self.kernel_hz = hz;
    }
    fn reset(&mut self) {
        let (fresh, _) = pair();
        let controller = std::mem::take(&mut self.controller);
        // Memory, bus and what is at its other end are not the chip's to reset; nor is what its clock says.
        *self = Self {
            memory: self.memory.clone(),
            kernel_hz: self.kernel_hz,
            fault: self.fault,
            controller,
            frames: self.frames,
            ..fresh
        };
    }
}

impl ErasedDevice for MessageMemory {
    fn layout(&self) -> &'static [RegisterSpec] {
        self.layout
    }
    fn read(&mut self, _: usize, _: &mut RegisterFile, _: &mut DeviceContext<'_>) -> Option<u64> {
        None
    }
    fn write(&mut self, _: usize, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
    fn on_event(&mut self, _: EventId, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
    fn on_request(&mut self, _: RequestChange, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
    fn on_clock(&mut self, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
    fn poll(&mut self, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
    fn reset(&mut self) {}
    fn on_access(&mut self, _: u64, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
    fn on_refused(&mut self, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
    fn read_window(&mut self, offset: u64, width: Width, c: &mut DeviceContext<'_>) -> u64 {
        self.peek_window(offset, width, c.now()).unwrap_or_else(|| {
            c.tell("message memory", "it is read in whole words");
            0
        })
    }
    fn peek_window(&self, offset: u64, width: Width, _: VirtualNanos) -> Option<u64> {
        let words = self.words.lock().expect("nobody panics with it");
        let word = words.get(offset as usize / 4).copied().filter(|_| width == Width::W32 && offset.is_multiple_of(4));
        word.map(u64::from)
    }
    fn write_window(&mut self, offset: u64, width: Width, value: u64, c: &mut DeviceContext<'_>) {
        let mut words = self.words.lock().expect("nobody panics with it");
        match words.get_mut(offset as usize / 4).filter(|_| width == Width::W32 && offset.is_multiple_of(4)) {
            Some(word) => *word = value as u32,
            None => c.tell("message memory", "it is written in whole words"),
        }
    }
}
