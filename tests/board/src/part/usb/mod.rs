//! The second USB core (RM0433 §57), a device at full speed as embassy-usb-synopsys-otg uses it, and the PC at the other end of its cable ([`host`]).
//!
//! Modelled so that mistakes show: nothing is connected without the cable's 5 V, the transceiver's power and DCTL.SDIS cleared; an
//! endpoint that is not active, not enabled or told to hold back carries nothing; what is received waits in one FIFO, in order, and an
//! interrupt stands until it is read; what is sent leaves when all of the packet is in its FIFO, and no more goes in than that was given room
//! for; masks, and one line that is their level. A packet takes 50 µs.
//!
//! A reset of the bus, a cable that goes (the session's end, 3 ms later the suspend) and one that comes are told as the core does.
//!
//! **From memory, or from what the driver needs**, and not read in the manual: the core's number; that a session's beginning is told at
//! once, before the driver clears what is told; that an endpoint that receives stays enabled after its packet, and endpoint 0 receives without.
//!
//! Left out: DMA, isochronous endpoints, host mode, errors on the bus, sleep of the bus while the cable is in, the clock's gate (an access
//! before RCC enables the core is answered here, and not there), the room of the receive FIFO, the clock: 48 MHz are taken for granted.

pub mod host;

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard};

use rigless::device::{DeviceContext, ErasedDevice, Level, RegisterFile, RequestChange};
use rigless::emulator::InterruptLine;
use rigless::mcu::Mcu;
use rigless::soc::stm32h743::{CPU, Stm32h743};
use rigless::soc::{Access, Bus, Error, Peripheral, ReadAction, RegisterSpec, Width, WriteModify};
use rigless::time::{EventId, VirtualNanos};

use host::{Host, Token};

/// Endpoints each way.
const ENDPOINTS: usize = 9;
/// What a packet takes on the bus with all that belongs to it, ns.
const PACKET_NS: u64 = 50_000;
/// A bus without its frames is asleep after this, ns.
const IDLE_NS: u64 = 3_000_000;
const LINE: InterruptLine = InterruptLine::new(101).expect("OTG_FS has a line");

// GINTSTS.
const OTGINT: u32 = 1 << 2;
const RXFLVL: u32 = 1 << 4;
const USBSUSP: u32 = 1 << 11;
const USBRST: u32 = 1 << 12;
const ENUMDNE: u32 = 1 << 13;
const IEPINT: u32 = 1 << 18;
const OEPINT: u32 = 1 << 19;
const SRQINT: u32 = 1 << 30;
// Of an endpoint: active, holds back, stalls; orders; interrupts.
const USBAEP: u32 = 1 << 15;
const NAKSTS: u32 = 1 << 17;
const STALL: u32 = 1 << 21;
const CNAK: u32 = 1 << 26;
const SNAK: u32 = 1 << 27;
const EPDIS: u32 = 1 << 30;
const EPENA: u32 = 1 << 31;
const XFRC: u32 = 1;
const EPDISD: u32 = 1 << 1;
const STUP: u32 = 1 << 3;
const TXFE: u32 = 1 << 7;
// What stands at the top of the receive FIFO.
const OUT_DATA: u32 = 2;
const OUT_DONE: u32 = 3;
const SETUP_DONE: u32 = 4;
const SETUP_DATA: u32 = 6;

const GLOBAL: u32 = 0;
const DEVICE: u32 = 0x800;
const FIFOS: u32 = 0xE00;
const IN: u32 = 0x900;
const OUT: u32 = 0xB00;

const fn word(offset: u32) -> RegisterSpec {
    RegisterSpec {
        name: "USB",
        offset,
        width: Width::W32,
        reset: 0,
        access: Access::ReadWrite,
        read: ReadAction::None,
        write: WriteModify::None,
        fields: &[],
    }
}

const fn words<const N: usize>(first: u32, step: u32) -> [RegisterSpec; N] {
    let mut words = [word(0); N];
    let mut at = 0;
    while at < N {
        words[at] = word(if at == 0 { 0 } else { first + step * (at as u32 - 1) });
        at += 1;
    }
    words
}

/// The emulator has no model of the core, knows no FIFO, and has the endpoints' registers as ST's file does, which is wrong in places: these tables
/// stand in for its own.
static TABLES: [(&str, u32, &[RegisterSpec]); 3] = {
    static OF_GLOBAL: [RegisterSpec; 0x100] = words(4, 4);
    static OF_DEVICE: [RegisterSpec; 0x108] = words(4, 4);
    // PCGCCTL, and a word for each FIFO.
    static OF_FIFOS: [RegisterSpec; 1 + ENDPOINTS] = words(0x1000 - FIFOS, 0x1000);
    [
        ("OTG2_HS_GLOBAL", GLOBAL, &OF_GLOBAL),
        ("OTG2_HS_DEVICE", DEVICE, &OF_DEVICE),
        ("OTG2_HS_PWRCLK", FIFOS, &OF_FIFOS),
    ]
};

/// An endpoint's direction.
#[derive(Debug, Default, Clone)]
struct End {
    control: u32,
    interrupts: u32,
    size: u32,
    /// What waits to be sent.
    fifo: VecDeque<u8>,
    /// Words that it has room for.
    room: u32,
}

impl End {
    /// Takes what is written to one of its registers, which either direction has.
    fn write(&mut self, register: u32, value: u32, zero: bool) {
        match register {
            0 => self.order(value, zero),
            8 => self.interrupts &= !value,
            0x10 => self.size = value,
            _ => {}
        }
    }

    /// Takes what is written to its control register; endpoint 0 is always active.
    fn order(&mut self, value: u32, zero: bool) {
        let kept = self.control & (NAKSTS | EPENA);
        self.control = value & !(CNAK | SNAK | EPDIS | EPENA | NAKSTS | 3 << 28) | kept | (value & EPENA);
        if zero {
            self.control |= USBAEP;
        }
        if value & SNAK != 0 {
            self.control |= NAKSTS;
        } else if value & CNAK != 0 {
            self.control &= !NAKSTS;
        }
        if value & EPDIS != 0 && kept & EPENA != 0 {
            self.control &= !EPENA;
            self.interrupts |= EPDISD;
        }
    }
}

#[derive(Debug, Default)]
struct Core {
    /// Registers that only keep what is written.
    kept: std::collections::BTreeMap<u32, u32>,
    status: u32,
    session: u32,
    ins: [End; ENDPOINTS],
    outs: [End; ENDPOINTS],
    /// What was received: what it is, and its bytes.
    received: VecDeque<(u32, Vec<u8>)>,
    /// The bytes that are being read.
    reading: VecDeque<u8>,
    line: bool,
    cable: bool,
    /// That it answers at.
    address: u8,
    /// The next packet on the bus, the end of a reset, the suspend.
    due: Option<EventId>,
    enumerated: Option<EventId>,
    suspends: Option<EventId>,
    host: Host,
}

impl Core {
    fn kept(&self, register: u32) -> u32 {
        self.kept.get(&register).copied().unwrap_or(0)
    }

    /// The device shows itself to whoever is at the other end of the cable.
    fn connected(&self) -> bool {
        let powered = self.kept(0x38) & 1 << 16 != 0;
        let hidden = self.kept.get(&0x804).is_none_or(|control| control & 1 << 1 != 0);
        self.cable && powered && !hidden
    }

    /// The endpoints that have something to say, those that send below those that receive.
    fn daint(&self) -> u32 {
        let of = |ends: &[End], mask: u32, empty: u32| {
            ends.iter().enumerate().fold(0, |bits, (at, end)| {
                let told = end.interrupts & mask != 0 || (empty >> at & 1 != 0 && end.fifo.is_empty());
                bits | u32::from(told) << at
            })
        };
        of(&self.ins, self.kept(0x810), self.kept(0x834)) | of(&self.outs, self.kept(0x814), 0) << 16
    }

    fn gintsts(&self) -> u32 {
        let ends = self.daint() & self.kept(0x81C);
        let of = |on: bool, bit| if on { bit } else { 0 };
        self.status
            | of(self.session != 0, OTGINT)
            | of(!self.received.is_empty(), RXFLVL)
            | of(ends & 0xFFFF != 0, IEPINT)
            | of(ends >> 16 != 0, OEPINT)
    }

    fn read(&mut self, register: u32) -> u32 {
        match register {
            0x000 => self.kept(0) & !(1 << 19) | u32::from(self.cable) << 19,
            0x004 => self.session,
            // Idle.
            0x010 => 1 << 31,
            0x014 => self.gintsts(),
            0x020 => self.received.pop_front().map_or(0, |(what, bytes)| {
                let at = (what & 0xF) as usize;
                match what >> 17 & 0xF {
                    OUT_DONE => self.outs[at].interrupts |= XFRC,
                    SETUP_DONE => self.outs[at].interrupts |= STUP,
                    _ => self.reading = bytes.into(),
                }
                what
            }),
            0x03C => 0x2300,
            // Full speed.
            0x808 => 3 << 1,
            0x818 => self.daint(),
            0x900..0xA20 => {
                let end = &self.ins[((register - IN) >> 5) as usize];
                match register & 0x1F {
                    0 => end.control,
                    8 => end.interrupts | if end.fifo.is_empty() { TXFE } else { 0 },
                    0x10 => end.size,
                    0x18 => end.room.saturating_sub(end.fifo.len() as u32 / 4),
                    _ => 0,
                }
            }
            0xB00..0xC20 => {
                let end = &self.outs[((register - OUT) >> 5) as usize];
                match register & 0x1F {
                    0 => end.control,
                    8 => end.interrupts,
                    0x10 => end.size,
                    _ => 0,
                }
            }
            0x1000.. => {
                let bytes = [(); 4].map(|()| self.reading.pop_front().unwrap_or(0));
                u32::from_le_bytes(bytes)
            }
            _ => self.kept(register),
        }
    }

    fn write(&mut self, register: u32, value: u32, c: &mut DeviceContext<'_>) {
        match register {
            0x004 => self.session &= !value,
            0x010 => self.flush(value),
            0x014 => self.status &= !value,
            0x900..0xA20 => {
                let at = ((register - IN) >> 5) as usize;
                self.ins[at].write(register & 0x1F, value, at == 0);
            }
            0xB00..0xC20 => {
                let at = ((register - OUT) >> 5) as usize;
                self.outs[at].write(register & 0x1F, value, at == 0);
            }
            0x1000.. => {
                let end = &mut self.ins[(register / 0x1000 - 1) as usize];
                if end.fifo.len() as u32 / 4 >= end.room {
                    c.tell("FIFO", "more is put into it than it has room for");
                }
                end.fifo.extend(value.to_le_bytes());
            }
            _ => {
                let before = self.kept.insert(register, value).unwrap_or(0);
                // DIEPTXF0, DIEPTXFx.
                match register {
                    0x028 => self.ins[0].room = value >> 16,
                    0x104..0x124 => self.ins[(register - 0x100) as usize / 4].room = value >> 16,
                    _ => {}
                }
                // The session begins for a core that begins to look.
                let looks = 1 << 21;
                if register == 0x38 && value & looks != 0 && before & looks == 0 && self.cable {
                    self.status |= SRQINT;
                }
            }
        }
    }

    fn flush(&mut self, value: u32) {
        if value & 1 << 4 != 0 {
            self.received.clear();
            self.reading.clear();
        }
        if value & 1 << 5 != 0 {
            let (which, all) = ((value >> 6 & 0x1F) as usize, value >> 6 & 0x10 != 0);
            self.ins.iter_mut().enumerate().filter(|(at, _)| all || *at == which).for_each(|(_, end)| end.fifo.clear());
        }
    }

    /// Raises or lowers the line.
    fn settle(&mut self, c: &mut DeviceContext<'_>) {
        let on = self.kept(0x08) & 1 != 0 && self.gintsts() & self.kept(0x18) != 0;
        if on != self.line {
            self.line = on;
            c.drive_line(LINE, if on { Level::High } else { Level::Low });
        }
    }

    /// There may be something to carry.
    fn kick(&mut self, c: &mut DeviceContext<'_>) {
        if self.due.is_none() && self.connected() {
            self.due = Some(c.schedule(VirtualNanos(c.now().0 + PACKET_NS)));
        }
    }

    /// A packet's time on the bus is over: the PC does what it wants to do next, if the device goes along.
    fn go_on(&mut self, c: &mut DeviceContext<'_>) {
        if self.host.wants_reset() {
            (self.status, self.address) = (self.status | USBRST, 0);
            self.enumerated = Some(c.schedule(VirtualNanos(c.now().0 + host::RESET_NS)));
        } else if self.enumerated.is_none() {
            let tokens: Vec<Token> = self.host.tokens().collect();
            if tokens.iter().any(|token| self.carry(token, c.now().0)) {
                self.kick(c);
            }
        }
    }

    /// Carries one packet, if the device does not hold it back.
    fn carry(&mut self, token: &Token, now: u64) -> bool {
        if self.address != self.host.address {
            return false;
        }
        match token {
            Token::Setup(bytes) => {
                let (control, of) = (&mut self.outs[0], |what: u32, bytes: u32| what << 17 | bytes << 4);
                // It is taken whatever the endpoint says, and ends a stall.
                control.control = control.control & !STALL | NAKSTS;
                self.ins[0].control = self.ins[0].control & !STALL | NAKSTS;
                self.received.push_back((of(SETUP_DATA, 8), bytes.to_vec()));
                self.received.push_back((of(SETUP_DONE, 0), Vec::new()));
                self.host.took(token);
                true
            }
            Token::In(at) => {
                let end = &mut self.ins[*at];
                if end.control & STALL != 0 {
                    self.host.stalled();
                    return true;
                }
                let length = (end.size & 0x7_FFFF) as usize;
                let whole = end.fifo.len() >= length.next_multiple_of(4);
                let ready = end.control & (USBAEP | EPENA | NAKSTS) == USBAEP | EPENA;
                if !ready || !whole {
                    return false;
                }
                let bytes: Vec<u8> = end.fifo.drain(..length.next_multiple_of(4)).take(length).collect();
                (end.control, end.size) = (end.control & !EPENA, 0);
                end.interrupts |= XFRC;
                if *at == 0 {
                    // A new address counts once it was acknowledged at the old one.
                    self.address = (self.kept(0x800) >> 4 & 0x7F) as u8;
                }
                self.host.hear(*at, bytes, now);
                true
            }
            Token::Out(at, bytes) => {
                let end = &mut self.outs[*at];
                let ready = end.control & (USBAEP | NAKSTS) == USBAEP;
                let enabled = *at == 0 || end.control & EPENA != 0 && end.size >> 19 & 0x3FF != 0;
                if !ready || !enabled {
                    return false;
                }
                (end.control, end.size) = (end.control | NAKSTS, 0);
                let of = |what: u32, bytes: usize| what << 17 | (bytes as u32) << 4 | *at as u32;
                self.received.push_back((of(OUT_DATA, bytes.len()), bytes.clone()));
                self.received.push_back((of(OUT_DONE, 0), Vec::new()));
                self.host.took(token);
                true
            }
        }
    }
}

/// One of the three blocks of registers.
#[derive(Debug)]
pub struct Block {
    core: Arc<Mutex<Core>>,
    base: u32,
    layout: &'static [RegisterSpec],
}

impl Block {
    fn core(&self) -> MutexGuard<'_, Core> {
        self.core.lock().expect("nobody panics with it")
    }
}

impl ErasedDevice for Block {
    fn layout(&self) -> &'static [RegisterSpec] {
        self.layout
    }
    fn read(&mut self, row: usize, _: &mut RegisterFile, c: &mut DeviceContext<'_>) -> Option<u64> {
        let mut core = self.core();
        let value = core.read(self.base + self.layout[row].offset);
        core.settle(c);
        Some(value.into())
    }
    fn write(&mut self, row: usize, value: u64, _: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        let mut core = self.core();
        core.write(self.base + self.layout[row].offset, value as u32, c);
        core.settle(c);
        core.kick(c);
    }
    fn on_event(&mut self, event: EventId, _: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        let mut core = self.core();
        if core.due == Some(event) {
            core.due = None;
            if core.connected() {
                core.go_on(c);
            }
        } else if core.enumerated == Some(event) {
            core.enumerated = None;
            core.status |= ENUMDNE;
        } else if core.suspends == Some(event) {
            core.suspends = None;
            core.status |= USBSUSP;
        }
        core.settle(c);
    }
    fn on_request(&mut self, _: RequestChange, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
    fn on_clock(&mut self, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
    fn poll(&mut self, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
    fn reset(&mut self) {}
    fn on_access(&mut self, _: u64, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
    fn on_refused(&mut self, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
}

/// The core in its three blocks, and what the emulator has in their place.
#[derive(Debug)]
pub struct Usb {
    /// As [`Usb::slots`] has them.
    pub blocks: [Block; 3],
    /// Where they are on the bus.
    pub slots: [usize; 3],
    core: Arc<Mutex<Core>>,
    /// What is not on the chip's bus.
    aside: Bus,
}

impl Usb {
    /// Takes the emulator's blocks off the chip's bus and puts these there.
    ///
    /// # Errors
    /// The emulator has no such core.
    pub fn new(chip: &mut Stm32h743) -> Result<Self, Error> {
        let mut slots = [0; 3];
        for (slot, (name, ..)) in slots.iter_mut().zip(TABLES) {
            *slot = chip.bus().slot(name)?;
        }
        let ours = slots.iter().zip(TABLES).map(|(slot, (.., registers))| Peripheral {
            registers,
            interrupts: &[],
            ..*chip.bus().slots()[*slot].peripheral()
        });
        let aside = Bus::builder(CPU, &[], ours.collect::<Vec<_>>()).build()?;
        let core = Arc::new(Mutex::new(Core { cable: true, ..Core::default() }));
        let blocks = TABLES.map(|(_, base, layout)| Block { core: core.clone(), base, layout });
        let mut usb = Self { blocks, slots, core, aside };
        usb.exchange(chip);
        Ok(usb)
    }

    /// Exchanges what is on the chip's bus with what is aside: a reset of the emulator's chip wants to find its own.
    pub fn exchange(&mut self, chip: &mut Stm32h743) {
        for (slot, aside) in self.slots.iter().zip(0..) {
            std::mem::swap(chip.bus_mut().slot_mut(*slot), self.aside.slot_mut(aside));
        }
    }

    fn core(&self) -> MutexGuard<'_, Core> {
        self.core.lock().expect("nobody panics with it")
    }

    /// The chip restarts; cable and PC are there as before, and the PC sees the device go.
    pub fn reset(&mut self) {
        let core = &mut *self.core();
        let (cable, mut host) = (core.cable, std::mem::take(&mut core.host));
        host.lose();
        *core = Core { cable, host, ..Core::default() };
    }

    /// The image has turned the transceiver on.
    pub fn is_there(&self) -> bool {
        self.core().kept(0x38) & 1 << 16 != 0
    }

    /// Pulls the cable, or puts it back in.
    pub fn plug(&mut self, cable: bool, c: &mut DeviceContext<'_>) {
        let core = &mut *self.core();
        core.cable = cable;
        let looks = core.kept(0x38) & 1 << 21 != 0;
        core.host.lose();
        if !cable {
            core.session |= if looks { 1 << 2 } else { 0 };
            core.suspends = Some(c.schedule(VirtualNanos(c.now().0 + IDLE_NS)));
        } else {
            core.status |= if looks { SRQINT } else { 0 };
            core.suspends = None;
        }
        core.settle(c);
        core.kick(c);
    }

    /// Frames for the board.
    pub fn deliver(&mut self, frames: impl IntoIterator<Item = Vec<u8>>, c: &mut DeviceContext<'_>) {
        let core = &mut *self.core();
        frames.into_iter().for_each(|frame| core.host.send(&frame));
        core.kick(c);
    }

    /// The PC's program at the serial port does this from now on.
    pub fn read_serial(&mut self, reader: host::Reader, c: &mut DeviceContext<'_>) {
        let core = &mut *self.core();
        core.host.open(reader);
        core.kick(c);
    }

    /// Takes the board's frames, each with its instant, and what it said at its serial port.
    pub fn heard(&mut self) -> (Vec<(u64, Vec<u8>)>, Vec<u8>) {
        let host = &mut self.core().host;
        (std::mem::take(&mut host.frames), std::mem::take(&mut host.serial))
    }

    /// What the PC found there, once it has set it up.
    pub fn found(&self) -> Option<host::Found> {
        self.core().host.found.clone()
    }

    /// Frames for the board that came while its network was not up.
    pub fn unlinked(&self) -> u64 {
        self.core().host.unlinked
    }
}
