//! The operator's PC on the wire: answers ARP, and has cohold's own operator session with each board, in virtual time.
//!
//! The least that carries it: Ethernet II, ARP, IPv4 without options, UDP without checksum.

use std::net::{SocketAddr, UdpSocket};
use std::path::Path;

use cohold_board_tools::operator::{PORT, Session};
use cohold_live::recording::ticks::{BoardTicks, board_channels};
use cohold_live::recording::{mcap::INFO, origin::Origin, recorder::Recorder};
use cohold_protocol::key::{Key, Role};
use cohold_protocol::wire::MAX_DATAGRAM;
use cohold_report::Provenance;
use firmware_parts::record::{CODE, Record};

/// Ethernet address of the PC.
pub const MAC: [u8; 6] = [0x02, 0, 0, 0, 0, 0x10];
const IP: [u8; 4] = [192, 168, 77, 10];
/// The PC's own port.
const OWN: u16 = 40_000;

/// Address of a board (1 or 2).
pub const fn board_mac(number: usize) -> [u8; 6] {
    [0x02, 0x48, 0x61, 0x70, 0x74, number as u8]
}

/// Address of a board (1 or 2).
pub const fn board_ip(number: usize) -> [u8; 4] {
    [192, 168, 77, number as u8]
}

/// The key that the boards share on the bench.
pub fn peers_key() -> Key {
    Key::new(core::array::from_fn(|at| 3 * at as u8 + 1))
}

/// The key that boards and PC share.
pub fn operator_key() -> Key {
    Key::new(core::array::from_fn(|at| 5 * at as u8 + 2))
}

/// Where a board keeps its two keys (memory.x), as `cargo xtask provision` puts them there: address and value.
pub fn keys_in_flash(peers: &Key, operator: &Key) -> Vec<(u64, u32)> {
    in_key_sector(&[peers.image(Role::Peers), operator.image(Role::Operator)].concat())
}

/// Bytes at the beginning of the sector of keys, whole words of them.
pub fn in_key_sector(bytes: &[u8]) -> Vec<(u64, u32)> {
    let words = bytes.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes));
    (0x081A_0000..).step_by(4).zip(words).collect()
}

/// What the PC has heard, board by board.
#[derive(Debug)]
pub struct Pc {
    sessions: [Session; 2],
    /// Answers of each board, oldest first.
    pub answers: [Vec<String>; 2],
    /// Ticks of each board, oldest first.
    pub records: [Vec<Record>; 2],
    /// Ticks of each board along further shared axes, oldest first.
    pub further: [Vec<Record>; 2],
    /// Says nothing to anybody.
    pub away: bool,
    /// It only carries datagrams between board 1 and whoever wrote to this socket last.
    carries: Option<(UdpSocket, Option<SocketAddr>)>,
    /// What is recorded of each board, as `cohold board operator --record` does.
    recordings: [Option<(BoardTicks, Recorder)>; 2],
}

impl Default for Pc {
    fn default() -> Self {
        Self::holding(&operator_key())
    }
}

fn checksum(header: &[u8]) -> u16 {
    let sum: u32 = header.chunks(2).map(|pair| u32::from(u16::from_be_bytes([pair[0], pair[1]]))).sum();
    let folded = (sum & 0xFFFF) + (sum >> 16);
    !((folded & 0xFFFF) + (folded >> 16)) as u16
}

/// A UDP datagram in its frame.
pub fn udp(from: ([u8; 6], [u8; 4], u16), to: ([u8; 6], [u8; 4], u16), payload: &[u8]) -> Vec<u8> {
    let mut ip = vec![0x45, 0];
    ip.extend((28 + payload.len() as u16).to_be_bytes());
    ip.extend([0, 0, 0x40, 0, 64, 17, 0, 0]);
    ip.extend(from.1);
    ip.extend(to.1);
    let sum = checksum(&ip);
    ip[10..12].copy_from_slice(&sum.to_be_bytes());
    let mut frame = [&to.0[..], &from.0, &[0x08, 0x00], &ip].concat();
    frame.extend(from.2.to_be_bytes());
    frame.extend(to.2.to_be_bytes());
    frame.extend((8 + payload.len() as u16).to_be_bytes());
    frame.extend([0, 0]);
    frame.extend(payload);
    frame
}

/// The answer to a frame that asks by ARP who has `ip`: `mac` has.
pub fn resolved(frame: &[u8], mac: [u8; 6], ip: [u8; 4]) -> Option<Vec<u8>> {
    let asks = frame.get(12..14)? == [8, 6] && frame.get(20..22)? == [0, 1] && frame.get(38..42)? == ip;
    asks.then(|| {
        let (sender_mac, sender_ip) = (&frame[22..28], &frame[28..32]);
        [sender_mac, &mac, &[8, 6, 0, 1, 8, 0, 6, 4, 0, 2], &mac, &ip, sender_mac, sender_ip].concat()
    })
}

impl Pc {
    /// A PC that calls boards under this key.
    ///
    /// # Panics
    /// The key is none.
    pub fn holding(key: &Key) -> Self {
        let session = |number| Session::new(key.clone(), number, [16 + number; Key::LEN]).expect("a good key");
        Self {
            sessions: [session(1), session(2)],
            answers: Default::default(),
            records: Default::default(),
            further: Default::default(),
            away: false,
            carries: None,
            recordings: Default::default(),
        }
    }

    /// Records a board (1 or 2) that shares so many axes in this file, on the PC's clock.
    ///
    /// # Panics
    /// The file is there already, or cannot be written.
    pub fn record(&mut self, number: u8, axes: usize, file: &Path) {
        let provenance = Provenance::now(env!("CARGO_PKG_VERSION"), "bench");
        let origin = Origin {
            clock: "bench".to_owned(),
            ..Origin::simulated(&provenance, format!("operator of board {number}"))
        };
        let recorder =
            Recorder::create(file, &origin, board_channels(number, axes)).expect("a file that is not there yet");
        self.recordings[usize::from(number - 1)] = Some((BoardTicks::new(1e-3, axes), recorder));
    }

    /// From here on it has no session of its own, and carries datagrams between board 1 and whoever writes to this socket, which must not block.
    pub fn carry(&mut self, socket: UdpSocket) {
        self.carries = Some((socket, None));
    }

    /// Closes what is recorded.
    pub fn end_recordings(&mut self) {
        self.recordings = Default::default();
    }

    /// Says `line` to a board (1 or 2).
    ///
    /// # Panics
    /// The line before is still on its way.
    pub fn say(&mut self, number: usize, line: &str) {
        assert!(self.sessions[number - 1].say(line), "board {number} has not taken the line before {line:?}");
    }

    /// Whether a board (1 or 2) has answered under the key.
    pub fn reaches(&self, number: usize) -> bool {
        self.sessions[number - 1].is_there()
    }

    /// What the PC has to say to the first `boards` boards now, as frames.
    pub fn talk(&mut self, now_ns: u64, boards: usize) -> Vec<Vec<u8>> {
        let mut frames = Vec::new();
        if self.away {
            return frames;
        }
        if let Some((socket, whom)) = &mut self.carries {
            let mut bytes = [0; MAX_DATAGRAM];
            while let Ok((length, from)) = socket.recv_from(&mut bytes) {
                *whom = Some(from);
                frames.push(udp((MAC, IP, OWN), (board_mac(1), board_ip(1), PORT), &bytes[..length]));
            }
            return frames;
        }
        for (number, session) in (1..=boards).zip(&mut self.sessions) {
            let mut out = [0; MAX_DATAGRAM];
            while let Some(length) = session.poll(now_ns / 1000, &mut out) {
                frames.push(udp((MAC, IP, OWN), (board_mac(number), board_ip(number), PORT), &out[..length]));
            }
        }
        frames
    }

    /// The frame that asks a board (1 or 2) for its address; with it the board learns the PC's, as from any PC.
    pub fn resolve(number: usize) -> Vec<u8> {
        Self::ask_for(board_ip(number))
    }

    /// The frame that asks who has an address.
    pub fn ask_for(ip: [u8; 4]) -> Vec<u8> {
        [&[0xFF; 6][..], &MAC, &[8, 6, 0, 1, 8, 0, 6, 4, 0, 1], &MAC, &IP, &[0; 6], &ip].concat()
    }

    /// Takes in a frame, and gives the one that answers it, if any.
    pub fn hear(&mut self, now_ns: u64, frame: &[u8]) -> Option<Vec<u8>> {
        match frame.get(12..14)? {
            [0x08, 0x06] => resolved(frame, MAC, IP),
            [0x08, 0x00] if frame.get(..6)? == MAC && frame.get(30..34)? == IP => {
                self.datagram(now_ns, frame);
                None
            }
            _ => None,
        }
    }

    fn datagram(&mut self, now_ns: u64, frame: &[u8]) {
        let (Some(source), Some(board)) = (frame.get(34..36), frame.get(29)) else { return };
        let Some(at) = usize::from(*board).checked_sub(1).filter(|at| *at < 2) else { return };
        let length = usize::from(u16::from_be_bytes([frame[38], frame[39]]));
        let Some(payload) = frame.get(42..34 + length) else { return };
        if u16::from_be_bytes([source[0], source[1]]) != PORT {
            return;
        }
        if let Some((socket, whom)) = &self.carries {
            // One that is lost is no more than a network does.
            whom.map(|whom| socket.send_to(payload, whom));
            return;
        }
        let session = &mut self.sessions[at];
        session.receive(now_ns / 1000, &mut payload.to_vec());
        self.answers[at].extend(std::iter::from_fn(|| session.answer()));
        let samples = session.take_stamped();
        if let Some((ticks, recorder)) = &mut self.recordings[at] {
            ticks.take(session.link(), &samples, |channel, row| recorder.put_all(channel, now_ns, row));
            while let Some((at_us, words)) = session.logged() {
                recorder.log(1000 * at_us, INFO, words);
            }
        }
        for (_, sample) in &samples {
            // PWM periods are recorded only.
            let record = Record::from_bytes(sample.payload());
            [&mut self.records, &mut self.further][usize::from(sample.code != CODE)][at].extend(record);
        }
    }
}
