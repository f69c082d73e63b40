//! [`NetworkTrace`]: what became of each packet, written down, so that one recording impairs a run in memory, two processes
//! and two boards alike:
//!
//! ```csv
//! direction,packet,delay_s,fate
//! 1,0,0.0031,arrives
//! 1,1,,lost
//! 2,0,0.0005,corrupt
//! ```
//!
//! `direction` is the sender (1 or 2), `delay_s` what is added to the constant delay; a packet with two rows arrives twice.
//! After its end a trace begins anew. A file may also be what `irtt` or `ping -D` wrote, compressed by gzip or not: their modules say what is
//! taken of it.

use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

use super::measured::{Arrival, Found, Measured};
use super::{irtt, ping};
use crate::Error;
use crate::quantities::Named;
use crate::user::TRACE;

/// What a file that gzip compressed begins with.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Columns of the file.
pub const COLUMNS: [Named; 4] = [
    ("direction", "who sent the packet: 1 or 2"),
    ("packet", "which packet of this direction, from 0; one with two rows arrives twice"),
    ("delay_s", "what is added to the constant delay; empty of a packet that is lost"),
    ("fate", "arrives, corrupt or lost"),
];

/// Converts a time in ns to s.
pub fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}

/// Converts a time in s to ns, rounded to the nearest.
pub fn nanoseconds(s: f64) -> u64 {
    (1e9 * s).round() as u64
}

/// The direction in which a packet travels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From peer 1 to peer 2.
    OneToTwo,
    /// From peer 2 to peer 1.
    TwoToOne,
}

/// A recording of what a network did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NetworkTrace {
    /// The file it was read from; empty for none.
    pub file: PathBuf,
    packets: [Vec<Vec<Arrival>>; 2],
    /// For how long an entry counts, ns; 0 where each is one packet's.
    every_ns: u64,
    found: Found,
}

impl NetworkTrace {
    /// A recording that no file holds yet.
    pub fn of_packets(packets: [Vec<Vec<Arrival>>; 2]) -> Self {
        Self { packets, ..Self::default() }
    }

    /// The constant delay each way that a measurement found, s, which a scene's `network.one_way_delay_packets` must bring; 0 of a CSV file.
    pub fn constant_s(&self) -> f64 {
        seconds(self.found.constant_ns)
    }

    /// What a measurement found and left out.
    pub fn found(&self) -> &Found {
        &self.found
    }

    /// What became of that packet, or of what was sent then; after its end a trace begins anew.
    pub(super) fn of(&self, direction: Direction, packet: u64, sent_ns: u64) -> &[Arrival] {
        let half = &self.packets[direction as usize];
        let entry = sent_ns.checked_div(self.every_ns).unwrap_or(packet);
        half.get((entry % half.len().max(1) as u64) as usize).map_or(&[], Vec::as_slice)
    }

    /// Reads a trace from a CSV file, or from one that irtt or ping wrote.
    ///
    /// # Errors
    /// The file cannot be read, or a row of it is wrong; the error names the first such row.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let place = path.display();
        let cannot = Error::cannot("read", &place);
        let mut bytes = cohold_io::read(path, TRACE).map_err(&cannot)?;
        if bytes.starts_with(&GZIP) {
            bytes = cohold_io::all(MultiGzDecoder::new(bytes.as_slice()), TRACE).map_err(&cannot)?;
        }
        let file = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let measured = if bytes.starts_with(b"{") || path.extension().is_some_and(|extension| extension == "json") {
            Some(irtt::read(&bytes))
        } else {
            str::from_utf8(&bytes).ok().filter(|text| ping::is(text)).map(ping::read)
        };
        if let Some(measured) = measured {
            let Measured { packets, every_ns, found } = measured.map_err(|cause| Error::at(&place, cause))?;
            return Ok(Self { file, packets, every_ns, found });
        }
        let mut reader = csv::Reader::from_reader(bytes.as_slice());
        let mut packets = [Vec::new(), Vec::new()];
        for (at, row) in reader.deserialize::<(usize, usize, Option<f64>, String)>().enumerate() {
            let wrong = |what: &str| Error::at(&place, Error::at(format_args!("row {}", at + 1), what));
            let (direction, packet, delay_s, fate) = row.map_err(|cause| wrong(&cause.to_string()))?;
            let half: &mut Vec<Vec<Arrival>> = match direction {
                1 => &mut packets[0],
                2 => &mut packets[1],
                _ => return Err(wrong("direction must be 1 or 2")),
            };
            // A second copy follows its first; anything else is the next packet.
            if packet == half.len() {
                half.push(Vec::new());
            } else if packet + 1 != half.len() {
                return Err(wrong(&format!("packet {packet} must be {} or, for a copy, the one before", half.len())));
            }
            let corrupt = match fate.as_str() {
                "arrives" => false,
                "corrupt" => true,
                "lost" => continue,
                _ => return Err(wrong("fate must be arrives, corrupt or lost")),
            };
            match delay_s {
                Some(delay_s) if (0.0..=1e4).contains(&delay_s) => {
                    half[packet].push(Arrival { delay_ns: nanoseconds(delay_s), corrupt });
                }
                _ => return Err(wrong("delay_s must be a number from 0 to 10000")),
            }
        }
        if packets.iter().any(Vec::is_empty) {
            return Err(Error::at(&place, "both directions need at least one packet"));
        }
        Ok(Self { file, packets, ..Self::default() })
    }

    /// Writes the trace as a CSV file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let failed = Error::cannot::<csv::Error>("write", &path.display());
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(COLUMNS.map(|(name, _)| name)).map_err(&failed)?;
        for (direction, half) in (1..).zip(&self.packets) {
            for (packet, copies) in half.iter().enumerate() {
                let mut row = |delay: String, fate: &str| {
                    writer.write_record([&direction.to_string(), &packet.to_string(), &delay, fate]).map_err(&failed)
                };
                if copies.is_empty() {
                    row(String::new(), "lost")?;
                }
                for copy in copies {
                    row(seconds(copy.delay_ns).to_string(), if copy.corrupt { "corrupt" } else { "arrives" })?;
                }
            }
        }
        let bytes = writer.into_inner().map_err(|cause| failed(cause.into_error().into()))?;
        cohold_io::write(path, &bytes, cohold_io::Kind::Named).map_err(|cause| failed(cause.into()))
    }
}
