//! The Ethernet controller (RM0433 §58): station management and the PHY behind it, the address filter, one DMA channel each
//! way.
//!
//! Modelled so that mistakes show: frames for other addresses are not taken; while receiver or transmitter are off, or the
//! link is down, nothing passes; a descriptor or buffer where this DMA cannot reach (DTCM, ITCM) is a fatal bus error and
//! stops the channel; without a free descriptor frames wait in a 2 kB FIFO and what does not fit is lost and counted; the
//! PHY takes a while to bring the link up.
//!
//! Left out: the cable's speed (a frame is there at once), errors on the wire, checksum offload, multicast hashing, time
//! stamps, and every interrupt but receive, transmit, buffer unavailable and bus error.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Arc, Mutex};

use rigless::device::{Device, DeviceContext, Level, RegisterFile};
use rigless::emulator::InterruptLine;
use rigless::soc::Width;
use rigless::soc::stm32h743::generated::{ethernet_dma as d, ethernet_mac as m};
use rigless::time::VirtualNanos;

/// Auto-negotiation after the cable is in or was asked for, ns: real PHYs take seconds, tests need not.
const NEGOTIATION_NS: u64 = 20_000_000;
/// Size of the receive FIFO, bytes.
const FIFO: usize = 2048;

/// What the two halves know of each other.
#[derive(Debug, Default)]
struct MacState {
    receiver: bool,
    transmitter: bool,
    promiscuous: bool,
    address: [u8; 6],
    cable: bool,
    up_at: Option<u64>,
}

impl MacState {
    fn up(&self, now: VirtualNanos) -> bool {
        self.cable && self.up_at.is_some_and(|at| now.0 >= at)
    }

    fn takes(&self, frame: &[u8]) -> bool {
        // Group addresses (broadcast, and multicast as the driver asks) are taken.
        self.promiscuous || frame.first().is_some_and(|first| first & 1 != 0) || frame.get(..6) == Some(&self.address)
    }
}

/// Model of the MAC and the PHY behind it.
#[derive(Debug)]
pub struct Mac(Arc<Mutex<MacState>>);

/// Both halves, with the cable in.
pub fn pair() -> (Mac, Dma) {
    let state = Arc::new(Mutex::new(MacState { cable: true, ..MacState::default() }));
    (Mac(state.clone()), Dma { state, ..Dma::default() })
}

impl Mac {
    /// Pulls the cable, or puts it back in.
    pub fn plug(&mut self, now: VirtualNanos, cable: bool) {
        let mut state = self.0.lock().expect("no panic holds it");
        state.cable = cable;
        state.up_at = cable.then_some(now.0 + NEGOTIATION_NS);
    }

    /// PHY registers of a LAN8742A at address 0; other addresses float.
    fn phy(state: &MacState, phy: u64, register: u64, now: VirtualNanos) -> u64 {
        match (phy, register) {
            (0, 0) => 0x3000,
            (0, 1) if state.up(now) => 0x782D,
            (0, 1) => 0x7809,
            (0, 2) => 0x0007,
            (0, 3) => 0xC131,
            (0, _) => 0,
            _ => 0xFFFF,
        }
    }
}

impl Device for Mac {
    type Register = m::Register;
    fn write(&mut self, register: m::Register, value: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        use m::Register as R;
        let state = &mut *self.0.lock().expect("no panic holds it");
        match register {
            R::Maccr => {
                state.receiver = value & 1 != 0;
                state.transmitter = value & 2 != 0;
            }
            R::Macpfr => state.promiscuous = value & 1 != 0,
            // The low word is written last, and takes the high one with it.
            R::Maca0lr => {
                let (low, high) = (value as u32, f.get(R::Maca0hr) as u16);
                state.address[..4].copy_from_slice(&low.to_le_bytes());
                state.address[4..].copy_from_slice(&high.to_le_bytes());
            }
            R::Macmdioar if value & 1 != 0 => {
                let (phy, number, operation) = (value >> 21 & 31, value >> 16 & 31, value >> 2 & 3);
                if operation == 3 {
                    f.set(R::Macmdiodr, Self::phy(state, phy, number, c.now()));
                } else if (phy, number) == (0, 0) && f.get(R::Macmdiodr) & 1 << 9 != 0 {
                    state.up_at = Some(c.now().0 + NEGOTIATION_NS);
                }
                f.set(R::Macmdioar, value & !1);
            }
            _ => {}
        }
    }
    fn reset(&mut self) {
        let mut state = self.0.lock().expect("no panic holds it");
        *state = MacState { cable: state.cable, ..MacState::default() };
    }
}

const LINE: InterruptLine = InterruptLine::new(61).expect("ETH has a line");
const OWN: u32 = 1 << 31;
const TRANSMITTED: u64 = 1;
const RECEIVED: u64 = 1 << 6;
const NO_BUFFER: u64 = 1 << 7;
const BUS_ERROR: u64 = 1 << 12;
const ABNORMAL: u64 = 1 << 14;
const NORMAL: u64 = 1 << 15;

/// What an access that the DMA asked for was for, in the upper half of its token; the word's number in the lower.
const TX_DESCRIPTOR: u64 = 1 << 32;
const TX_DATA: u64 = 2 << 32;
const TX_DONE: u64 = 3 << 32;
const RX_DESCRIPTOR: u64 = 4 << 32;
const RX_DATA: u64 = 5 << 32;
const RX_DONE: u64 = 6 << 32;

/// Tightly coupled memories: the processor's own, out of every other master's reach.
const UNREACHABLE: [Range<u32>; 2] = [0x2000_0000..0x2002_0000, 0..0x0001_0000];

/// The DMA and its channel.
#[derive(Debug, Default)]
pub struct Dma {
    state: Arc<Mutex<MacState>>,
    /// Frames that left, with the time.
    pub sent: Vec<(u64, Vec<u8>)>,
    /// Frames on the wire, not yet looked at.
    pub inbox: VecDeque<Vec<u8>>,
    /// Frames that the filter did not take.
    pub filtered: u64,
    /// Frames lost because there was neither descriptor nor room in the FIFO.
    pub overflowed: u64,
    /// Frames that got nowhere: link down, or transmitter or receiver off.
    pub unlinked: u64,
    fifo: VecDeque<Vec<u8>>,
    status: u64,
    line: bool,
    dead: bool,
    tx_busy: bool,
    tx_at: u32,
    tx_descriptor: [u32; 4],
    tx_data: Vec<u8>,
    rx_busy: bool,
    rx_starved: bool,
    rx_at: u32,
    rx_descriptor: [u32; 4],
    rx_left: usize,
}

impl Dma {
    fn raise(&mut self, what: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        self.status |= what | if what & (NO_BUFFER | BUS_ERROR) != 0 { ABNORMAL } else { NORMAL };
        self.settle(f, c);
    }

    fn settle(&mut self, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        let enabled = f.get(d::Register::Dmacier);
        let active = self.status & enabled;
        let on = enabled & NORMAL != 0 && active & (TRANSMITTED | RECEIVED) != 0
            || enabled & ABNORMAL != 0 && active & (NO_BUFFER | BUS_ERROR) != 0;
        f.set(d::Register::Dmacsr, self.status);
        f.set(d::Register::Dmaisr, u64::from(on));
        if on != self.line {
            self.line = on;
            c.drive_line(LINE, if on { Level::High } else { Level::Low });
        }
    }

    /// Refuses what this bus master cannot reach.
    fn reaches(&mut self, address: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) -> bool {
        let reachable = u32::try_from(address).is_ok_and(|at| !UNREACHABLE.iter().any(|range| range.contains(&at)));
        if !reachable {
            self.dead = true;
            c.tell("DMACSR", "a descriptor or buffer lies where the Ethernet DMA cannot reach");
            self.raise(BUS_ERROR, f, c);
        }
        reachable
    }

    fn tx_descriptor_at(&self, f: &RegisterFile) -> u64 {
        f.get(d::Register::Dmactxdlar) + u64::from(self.tx_at) * 16
    }

    fn rx_descriptor_at(&self, f: &RegisterFile) -> u64 {
        f.get(d::Register::Dmacrxdlar) + u64::from(self.rx_at) * 16
    }

    fn kick_tx(&mut self, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        if self.dead || self.tx_busy || f.get(d::Register::Dmactxcr) & 1 == 0 {
            return;
        }
        let at = self.tx_descriptor_at(f);
        if self.reaches(at, f, c) {
            self.tx_busy = true;
            (0..4).for_each(|word| c.read_from(at + 4 * word, Width::W32, TX_DESCRIPTOR | word));
        }
    }

    /// Takes what is on the wire into the FIFO, as far as it is for us and fits.
    fn listen(&mut self, now: VirtualNanos) {
        let state = self.state.clone();
        let state = state.lock().expect("no panic holds it");
        for frame in self.inbox.drain(..) {
            if !(state.receiver && state.up(now)) {
                self.unlinked += 1;
            } else if !state.takes(&frame) {
                self.filtered += 1;
            } else if self.rx_starved && self.fifo.iter().map(Vec::len).sum::<usize>() + frame.len() > FIFO {
                self.overflowed += 1;
            } else {
                self.fifo.push_back(frame);
            }
        }
    }

    fn kick_rx(&mut self, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        if self.dead || self.rx_busy || self.fifo.is_empty() || f.get(d::Register::Dmacrxcr) & 1 == 0 {
            return;
        }
        let at = self.rx_descriptor_at(f);
        if self.reaches(at, f, c) {
            self.rx_busy = true;
            (0..4).for_each(|word| c.read_from(at + 4 * word, Width::W32, RX_DESCRIPTOR | word));
        }
    }

    /// Takes a transmit descriptor's four words; the last starts the transfer.
    fn tx_descriptor(&mut self, word: usize, value: u32, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        self.tx_descriptor[word] = value;
        let [buffer, _, length, control] = self.tx_descriptor;
        if word < 3 {
            return;
        }
        if control & OWN == 0 || !self.reaches(buffer.into(), f, c) {
            self.tx_busy = false;
            return;
        }
        self.tx_data = vec![0; ((length & 0x3FFF) as usize).next_multiple_of(4)];
        for word in 0..self.tx_data.len() as u64 / 4 {
            c.read_from(u64::from(buffer) + 4 * word, Width::W32, TX_DATA | word);
        }
    }

    /// Takes a receive descriptor's four words; the last starts the transfer.
    fn rx_descriptor(&mut self, word: usize, value: u32, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        self.rx_descriptor[word] = value;
        let [buffer, .., control] = self.rx_descriptor;
        if word < 3 {
            return;
        }
        self.rx_starved = control & OWN == 0;
        if self.rx_starved || !self.reaches(buffer.into(), f, c) {
            self.rx_busy = false;
            if self.rx_starved {
                self.raise(NO_BUFFER, f, c);
            }
            return;
        }
        let frame = self.fifo.front().expect("the transfer began with one");
        self.rx_left = frame.len().div_ceil(4);
        for (word, bytes) in (0..).zip(frame.chunks(4)) {
            let mut whole = [0; 4];
            whole[..bytes.len()].copy_from_slice(bytes);
            let value = u64::from(u32::from_le_bytes(whole));
            c.write_to(u64::from(buffer) + 4 * word, Width::W32, value, RX_DATA);
        }
    }
}

impl Device for Dma {
    type Register = d::Register;

    fn write(&mut self, register: d::Register, value: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        use d::Register as R;
        match register {
            R::Dmamr if value & 1 != 0 => {
                Device::reset(self);
                f.reset();
            }
            R::Dmacsr => {
                self.status &= !value;
                self.settle(f, c);
            }
            R::Dmacier => self.settle(f, c),
            R::Dmactxdlar => self.tx_at = 0,
            R::Dmacrxdlar => self.rx_at = 0,
            R::Dmactxcr | R::Dmactxdtpr => self.kick_tx(f, c),
            R::Dmacrxcr | R::Dmacrxdtpr => self.kick_rx(f, c),
            _ => {}
        }
    }

    fn on_access(&mut self, token: u64, value: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        let word = (token & 0xFFFF_FFFF) as usize;
        match token & !0xFFFF_FFFF {
            TX_DESCRIPTOR => self.tx_descriptor(word, value as u32, f, c),
            TX_DATA => {
                self.tx_data[4 * word..4 * word + 4].copy_from_slice(&(value as u32).to_le_bytes());
                if 4 * word + 4 == self.tx_data.len() {
                    let [.., control] = self.tx_descriptor;
                    c.write_to(self.tx_descriptor_at(f) + 12, Width::W32, u64::from(control & !OWN), TX_DONE);
                }
            }
            TX_DONE => {
                let mut frame = std::mem::take(&mut self.tx_data);
                frame.truncate((self.tx_descriptor[2] & 0x3FFF) as usize);
                let state = self.state.lock().expect("no panic holds it");
                if state.transmitter && state.up(c.now()) {
                    self.sent.push((c.now().0, frame));
                } else {
                    self.unlinked += 1;
                }
                drop(state);
                self.tx_at = (self.tx_at + 1) % (f.get(d::Register::Dmactxrlr) as u32 + 1);
                self.tx_busy = false;
                self.raise(TRANSMITTED, f, c);
                self.kick_tx(f, c);
            }
            RX_DESCRIPTOR => self.rx_descriptor(word, value as u32, f, c),
            RX_DATA => {
                self.rx_left -= 1;
                if self.rx_left == 0 {
                    let length = self.fifo.front().map_or(0, Vec::len) as u64;
                    // First and last descriptor of the frame, with its length.
                    c.write_to(self.rx_descriptor_at(f) + 12, Width::W32, 0x3000_0000 | length, RX_DONE);
                }
            }
            RX_DONE => {
                self.fifo.pop_front();
                self.rx_at = (self.rx_at + 1) % (f.get(d::Register::Dmacrxrlr) as u32 + 1);
                self.rx_busy = false;
                self.raise(RECEIVED, f, c);
                self.kick_rx(f, c);
            }
            other => unreachable!("no access was asked for with token {other:#x}"),
        }
    }

    fn on_refused(&mut self, _: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        self.dead = true;
        self.raise(BUS_ERROR, f, c);
    }

    fn poll(&mut self, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        if !self.inbox.is_empty() {
            self.listen(c.now());
            self.kick_rx(f, c);
        }
    }

    fn reset(&mut self) {
        *self = Self {
            state: self.state.clone(),
            sent: std::mem::take(&mut self.sent),
            inbox: std::mem::take(&mut self.inbox),
            filtered: self.filtered,
            overflowed: self.overflowed,
            unlinked: self.unlinked,
            ..Self::default()
        };
    }
}
