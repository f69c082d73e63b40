//! The PC at the USB cable: it resets the bus, asks what is there, sets it up as Linux does, and carries frames and the serial port's text.
//!
//! From the standards, not from the driver under test: descriptors (USB 2.0 §9.6), the network's blocks NTB-16 (NCM 1.0 §3), which it lays out as
//! Linux does, with the pointers behind the frame, and takes in any layout. What is not as it must be is a panic: this is a bench.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

/// From the reset of the bus to the device at full speed, ns: real PCs take 10 ms and more.
pub(super) const RESET_NS: u64 = 2_000_000;
const PACKET: usize = 64;

/// What the PC wants to do on the bus.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    /// Begin a request.
    Setup([u8; 8]),
    /// Have what an endpoint has to say.
    In(usize),
    /// Tell an endpoint something.
    Out(usize, Vec<u8>),
}

/// Who is at the serial port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reader {
    /// Nobody has opened it.
    #[default]
    Nobody,
    /// Somebody reads.
    Reads,
    /// Somebody has opened it and does not read.
    Stuck,
}

/// What was found at the cable.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Found {
    /// Of whom, and what.
    pub vendor_product: (u16, u16),
    /// Address that the PC's end of the network is to have.
    pub mac: [u8; 6],
    /// Largest block that the board takes.
    pub block: usize,
    /// Times that it was set up.
    pub times: u32,
}

/// What is asked for, in this order.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Ask {
    Device,
    Address,
    Configuration,
    Mac,
    Configure,
    Parameters,
    Network,
    Coding,
    Lines,
}

const ORDER: [Ask; 8] = [
    Ask::Device,
    Ask::Address,
    Ask::Configuration,
    Ask::Mac,
    Ask::Configure,
    Ask::Parameters,
    Ask::Network,
    Ask::Coding,
];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    Setup,
    DataIn,
    DataOut,
    StatusIn,
    StatusOut,
}

/// Numbers that the configuration gives.
#[derive(Clone, Copy, Debug, Default)]
struct Ends {
    mac_string: u8,
    network: u8,
    network_data: u8,
    network_in: usize,
    network_out: usize,
    notices: usize,
    port: u8,
    port_in: usize,
}

#[derive(Debug, Default)]
pub(super) struct Host {
    pub(super) address: u8,
    pub(super) frames: Vec<(u64, Vec<u8>)>,
    pub(super) serial: Vec<u8>,
    pub(super) found: Option<Found>,
    pub(super) unlinked: u64,
    met: bool,
    asks: VecDeque<Ask>,
    asking: Option<(Ask, Stage, Vec<u8>)>,
    ends: Ends,
    finding: Found,
    network: bool,
    reader: Reader,
    packets: VecDeque<Vec<u8>>,
    block: Vec<u8>,
    sequence: u16,
    turn: usize,
}

fn word(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

impl Host {
    /// The device is not there any more.
    pub(super) fn lose(&mut self) {
        let (frames, serial) = (std::mem::take(&mut self.frames), std::mem::take(&mut self.serial));
        let times = self.finding.times;
        let finding = Found { times, ..Found::default() };
        *self = Self { frames, serial, finding, unlinked: self.unlinked, reader: self.reader, ..Self::default() };
    }

    /// Something is there that was not reset yet.
    pub(super) fn wants_reset(&mut self) -> bool {
        let new = !std::mem::replace(&mut self.met, true);
        if new {
            self.asks = ORDER.into();
        }
        new
    }

    pub(super) fn open(&mut self, reader: Reader) {
        self.reader = reader;
        if self.found.is_some() {
            self.asks.push_back(Ask::Lines);
        }
    }

    /// A frame for the board, in a block of its own.
    pub(super) fn send(&mut self, frame: &[u8]) {
        if !self.network {
            self.unlinked += 1;
            return;
        }
        let pointers = (12 + frame.len()).next_multiple_of(4);
        let words = |words: &[u16]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>();
        let mut block =
            [b"NCMH", &words(&[12, self.sequence, pointers as u16 + 16, pointers as u16])[..], frame].concat();
        block.resize(pointers, 0);
        block.extend([b"NCM0", &words(&[16, 0, 12, frame.len() as u16, 0, 0])[..]].concat());
        assert!(block.len() <= self.finding.block, "the board takes blocks of {} bytes", self.finding.block);
        self.sequence = self.sequence.wrapping_add(1);
        // A block that fills its last packet is ended by an empty one.
        let end = block.len().is_multiple_of(PACKET).then(Vec::new);
        self.packets.extend(block.chunks(PACKET).map(<[u8]>::to_vec).chain(end));
    }

    /// What the PC would do now, whatever first: a request goes before the rest, which takes turns.
    pub(super) fn tokens(&mut self) -> impl Iterator<Item = Token> + use<> {
        if self.asking.is_none() {
            self.asking = self.asks.pop_front().map(|ask| (ask, Stage::Setup, Vec::new()));
        }
        let request = self.asking.as_ref().map(|(ask, stage, _)| match stage {
            Stage::Setup => Token::Setup(self.setup(*ask)),
            Stage::DataIn | Stage::StatusIn => Token::In(0),
            // 115200 bits a second, 8 of them a byte.
            Stage::DataOut => Token::Out(0, vec![0, 0xC2, 1, 0, 0, 0, 8]),
            Stage::StatusOut => Token::Out(0, Vec::new()),
        });
        let mut rest = Vec::new();
        if self.network {
            rest.extend(self.packets.front().map(|packet| Token::Out(self.ends.network_out, packet.clone())));
            rest.extend([Token::In(self.ends.network_in), Token::In(self.ends.notices)]);
        }
        if self.reader == Reader::Reads && self.found.is_some() {
            rest.push(Token::In(self.ends.port_in));
        }
        self.turn += 1;
        let turn = self.turn % rest.len().max(1);
        rest.rotate_left(turn);
        request.into_iter().chain(rest)
    }

    fn setup(&self, ask: Ask) -> [u8; 8] {
        let Ends { mac_string, network, network_data, port, .. } = self.ends;
        let lines = if self.reader == Reader::Nobody { 0 } else { 3 };
        match ask {
            Ask::Device => [0x80, 6, 0, 1, 0, 0, 18, 0],
            Ask::Address => [0x00, 5, 7, 0, 0, 0, 0, 0],
            Ask::Configuration => [0x80, 6, 0, 2, 0, 0, 0, 2],
            Ask::Mac => [0x80, 6, mac_string, 3, 9, 4, 255, 0],
            Ask::Configure => [0x00, 9, 1, 0, 0, 0, 0, 0],
            Ask::Parameters => [0xA1, 0x80, 0, 0, network, 0, 28, 0],
            Ask::Network => [0x01, 11, 1, 0, network_data, 0, 0, 0],
            Ask::Coding => [0x21, 0x20, 0, 0, port, 0, 7, 0],
            Ask::Lines => [0x21, 0x22, lines, 0, port, 0, 0, 0],
        }
    }

    pub(super) fn stalled(&mut self) {
        panic!("the board refuses {:?}", self.asking);
    }

    /// The device has taken this.
    pub(super) fn took(&mut self, token: &Token) {
        match (token, self.asking.as_mut()) {
            (Token::Setup([kind, .., low, high]), Some((_, stage, _))) => {
                *stage = match (kind & 0x80 != 0, low | high) {
                    (_, 0) => Stage::StatusIn,
                    (true, _) => Stage::DataIn,
                    (false, _) => Stage::DataOut,
                }
            }
            (Token::Out(0, _), Some((_, stage @ Stage::DataOut, _))) => *stage = Stage::StatusIn,
            (Token::Out(0, _), _) => self.answered(),
            _ => {
                self.packets.pop_front();
            }
        }
    }

    /// The device says this.
    pub(super) fn hear(&mut self, end: usize, bytes: Vec<u8>, now: u64) {
        let Ends { network_in, port_in, .. } = self.ends;
        match end {
            0 => {
                let (ask, stage, heard) = self.asking.as_mut().expect("it was asked");
                let ask = *ask;
                if *stage == Stage::StatusIn {
                    assert!(bytes.is_empty(), "an acknowledgement is empty");
                    self.answered();
                    return;
                }
                let short = bytes.len() < PACKET;
                heard.extend(bytes);
                let heard = heard.len();
                if short || heard >= usize::from(word(&self.setup(ask), 6)) {
                    self.asking.iter_mut().for_each(|(_, stage, _)| *stage = Stage::StatusOut);
                }
            }
            end if end == network_in => {
                let whole = bytes.len() < PACKET;
                self.block.extend(bytes);
                if whole {
                    let block = std::mem::take(&mut self.block);
                    self.frames.extend(frames_of(&block).map(|frame| (now, frame.to_vec())));
                }
            }
            end if end == port_in => self.serial.extend(bytes),
            // That the network is connected.
            _ => assert_eq!(bytes[..2], [0xA1, 0], "a notice of the network's"),
        }
    }

    /// A request is done.
    fn answered(&mut self) {
        let Some((ask, _, heard)) = self.asking.take() else { return };
        match ask {
            Ask::Device => self.finding.vendor_product = (word(&heard, 8), word(&heard, 10)),
            Ask::Address => self.address = 7,
            Ask::Configuration => self.ends = ends_of(&heard),
            Ask::Mac => {
                assert_eq!(heard.len(), 26, "twelve digits: {heard:?}");
                let digit = |at: usize| char::from(heard[2 + 2 * at]).to_digit(16).expect("a digit") as u8;
                self.finding.mac = core::array::from_fn(|at| 16 * digit(2 * at) + digit(2 * at + 1));
            }
            Ask::Parameters => {
                assert_eq!((word(&heard, 0), word(&heard, 2) & 1), (28, 1), "blocks of 16 bits: {heard:?}");
                self.finding.block = usize::from(word(&heard, 16));
            }
            Ask::Network => self.network = true,
            Ask::Coding => {
                self.finding.times += 1;
                self.found = Some(self.finding.clone());
                self.asks.push_back(Ask::Lines);
            }
            Ask::Configure | Ask::Lines => {}
        }
    }
}

/// The numbers in a configuration with its interfaces and endpoints.
fn ends_of(configuration: &[u8]) -> Ends {
    assert_eq!(usize::from(word(configuration, 2)), configuration.len(), "as long as it says");
    assert!(configuration[7] & 1 << 6 != 0, "it has power of its own");
    let (mut ends, mut rest, mut function, mut data) = (Ends::default(), configuration, 0, false);
    while let [length, kind, ..] = rest {
        let (one, others) = rest.split_at(usize::from(*length));
        match (kind, one) {
            (4, [_, _, number, _, _, 2, subclass, ..]) => {
                (function, data) = (*subclass, false);
                match subclass {
                    0x0D => ends.network = *number,
                    2 => ends.port = *number,
                    other => panic!("a function {other:#x} of communication"),
                }
            }
            (4, [_, _, number, _, _, 0x0A, ..]) => {
                data = true;
                if function == 0x0D {
                    ends.network_data = *number;
                }
            }
            (0x24, [_, _, 0x0F, string, ..]) => ends.mac_string = *string,
            (5, [_, _, address, kind, size, ..]) => {
                assert!(usize::from(*size) <= PACKET && kind & 3 == if data { 2 } else { 3 }, "{one:?}");
                let (at, is_in) = (usize::from(address & 0xF), address & 0x80 != 0);
                match (function, data, is_in) {
                    (0x0D, true, true) => ends.network_in = at,
                    (0x0D, true, false) => ends.network_out = at,
                    (0x0D, false, true) => ends.notices = at,
                    (2, true, true) => ends.port_in = at,
                    _ => {}
                }
            }
            _ => {}
        }
        rest = others;
    }
    ends
}

/// The frames in a block.
fn frames_of(block: &[u8]) -> impl Iterator<Item = &[u8]> {
    assert_eq!((&block[..4], usize::from(word(block, 8))), (&b"NCMH"[..], block.len()), "a block as long as it says");
    let pointers = &block[usize::from(word(block, 10))..];
    assert_eq!(pointers[..4], *b"NCM0");
    let places = (8..).step_by(4).map(|at| (usize::from(word(pointers, at)), usize::from(word(pointers, at + 2))));
    places.take_while(|(at, length)| *at != 0 && *length != 0).map(|(at, length)| &block[at..at + length])
}
