//! Probe: what time is it at your end? Also what keeps an idle session alive.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 5 | |
//! | 1 | u8 × 3 | 0 | |
//! | 4 | u64 | sent: the prober's clock when it sent this, t1 | µs |
//!
//! 12 bytes.

use super::Error;
use super::bytes::{Reader, Writer};

/// A question about time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Probe {
    /// The prober's clock when it sent this, µs (t1).
    pub sent_us: u64,
}

impl Probe {
    /// First byte.
    pub const KIND: u8 = 5;
    /// Bytes.
    pub const LEN: usize = 12;

    /// Reads a probe, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let mut reader = Reader::exact(bytes, "probe", Self::LEN)?;
        reader.kind(Self::KIND)?;
        reader.reserved::<3>()?;
        let probe = Self { sent_us: reader.u64()? };
        reader.end()?;
        Ok(probe)
    }

    /// Writes the probe to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        Writer::new(out, "probe").put(&[Self::KIND, 0, 0, 0]).put(&self.sent_us.to_le_bytes()).end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let probe = Probe { sent_us: 0x0102_0304_0506_0708 };
        let bytes = [5, 0, 0, 0, 8, 7, 6, 5, 4, 3, 2, 1];
        let mut out = [0; Probe::LEN];
        assert_eq!(probe.emit(&mut out), Ok(Probe::LEN));
        assert_eq!(out, bytes);
        assert_eq!(Probe::parse(&bytes), Ok(probe));
    }
}
