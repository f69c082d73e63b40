//! The operator's PC on the wire: answers ARP, sends lines of text, takes in answers and telemetry.
//!
//! The least that talks to a board: Ethernet II, ARP, IPv4 without options, UDP without checksum.

use firmware_parts::record::{BYTES, Record};

const MAC: [u8; 6] = [0x02, 0, 0, 0, 0, 0x10];
const IP: [u8; 4] = [192, 168, 77, 10];
/// The operator's port on a board, and the port that telemetry comes from.
const OPERATOR: u16 = 7702;
const TELEMETRY: u16 = 7703;
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

/// What the PC has heard, board by board.
#[derive(Debug, Default)]
pub struct Pc {
    /// Answers of each board, oldest first.
    pub answers: [Vec<String>; 2],
    /// Ticks of each board, oldest first.
    pub records: [Vec<Record>; 2],
    /// Records that each board lost by its own account.
    pub lost: [u32; 2],
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

impl Pc {
    /// The frame that says `line` to a board (1 or 2).
    pub fn say(number: usize, line: &str) -> Vec<u8> {
        udp((MAC, IP, OWN), (board_mac(number), board_ip(number), OPERATOR), line.as_bytes())
    }

    /// The frame that asks a board (1 or 2) for its address; with it the board learns the PC's, as from any PC.
    pub fn resolve(number: usize) -> Vec<u8> {
        [&[0xFF; 6][..], &MAC, &[8, 6, 0, 1, 8, 0, 6, 4, 0, 1], &MAC, &IP, &[0; 6], &board_ip(number)].concat()
    }

    /// Takes in a frame, and gives the one that answers it, if any.
    pub fn hear(&mut self, frame: &[u8]) -> Option<Vec<u8>> {
        match frame.get(12..14)? {
            [0x08, 0x06] => Self::arp(frame),
            [0x08, 0x00] if frame.get(..6)? == MAC && frame.get(30..34)? == IP => {
                self.datagram(frame);
                None
            }
            _ => None,
        }
    }

    fn arp(frame: &[u8]) -> Option<Vec<u8>> {
        let asks_for_us = frame.get(20..22)? == [0, 1] && frame.get(38..42)? == IP;
        asks_for_us.then(|| {
            let (sender_mac, sender_ip) = (&frame[22..28], &frame[28..32]);
            [sender_mac, &MAC, &[8, 6, 0, 1, 8, 0, 6, 4, 0, 2], &MAC, &IP, sender_mac, sender_ip].concat()
        })
    }

    fn datagram(&mut self, frame: &[u8]) {
        let (Some(source), Some(board)) = (frame.get(34..36), frame.get(29)) else { return };
        let Some(at) = usize::from(*board).checked_sub(1).filter(|at| *at < 2) else { return };
        let length = usize::from(u16::from_be_bytes([frame[38], frame[39]]));
        let Some(payload) = frame.get(42..34 + length) else { return };
        match u16::from_be_bytes([source[0], source[1]]) {
            OPERATOR => self.answers[at].push(String::from_utf8_lossy(payload).into_owned()),
            TELEMETRY if payload.get(..3) == Some(b"HT\x01") => {
                self.lost[at] = u32::from_le_bytes([payload[4], payload[5], payload[6], payload[7]]);
                let (records, _) = payload[8..].as_chunks::<BYTES>();
                self.records[at].extend(records.iter().map(Record::from_bytes));
            }
            _ => {}
        }
    }
}
