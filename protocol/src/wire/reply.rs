//! Reply: the answer to a probe.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 6 | |
//! | 1 | u8 × 3 | 0 | |
//! | 4 | u64 | probe sent: t1 as the probe had it | µs, the prober's clock |
//! | 12 | u64 | probe received, t2 | µs, the answerer's clock |
//! | 20 | u64 | reply sent, t3 | µs, the answerer's clock |
//!
//! 28 bytes.

use super::Error;
use super::bytes::{Reader, Writer};

/// The answer to a [`super::Probe`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reply {
    /// The prober's clock when it sent the probe, µs (t1).
    pub probe_sent_us: u64,
    /// The answerer's clock when the probe came, µs (t2).
    pub probe_received_us: u64,
    /// The answerer's clock when it sent this, µs (t3).
    pub sent_us: u64,
}

impl Reply {
    /// First byte.
    pub const KIND: u8 = 6;
    /// Bytes.
    pub const LEN: usize = 28;

    /// Reads a reply, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let mut reader = Reader::exact(bytes, "reply", Self::LEN)?;
        reader.kind(Self::KIND)?;
        reader.reserved::<3>()?;
        let reply = Self { probe_sent_us: reader.u64()?, probe_received_us: reader.u64()?, sent_us: reader.u64()? };
        reader.end()?;
        Ok(reply)
    }

    /// Writes the reply to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        Writer::new(out, "reply")
            .put(&[Self::KIND, 0, 0, 0])
            .put(&self.probe_sent_us.to_le_bytes())
            .put(&self.probe_received_us.to_le_bytes())
            .put(&self.sent_us.to_le_bytes())
            .end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let reply = Reply { probe_sent_us: 1, probe_received_us: 0x0203, sent_us: 0x04 << 56 };
        #[rustfmt::skip]
        let bytes = [
            6, 0, 0, 0,
            1, 0, 0, 0, 0, 0, 0, 0,
            3, 2, 0, 0, 0, 0, 0, 0,
            0, 0, 0, 0, 0, 0, 0, 4,
        ];
        let mut out = [0; Reply::LEN];
        assert_eq!(reply.emit(&mut out), Ok(Reply::LEN));
        assert_eq!(out, bytes);
        assert_eq!(Reply::parse(&bytes), Ok(reply));
    }
}
