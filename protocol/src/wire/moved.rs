//! Moved: the shared object as whoever has the dynamics engine moves it, to each client; once each packet period, newest
//! wins ([`crate::roles::cooperative`]).
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 20 | |
//! | 1 | u8 × 3 | 0 | |
//! | 4 | u32 | version: which engine | |
//! | 8 | f32 × 4 | x, ẋ, y, ẏ of the object | m, m/s |
//! | 24 | u64 | echo: when this client's newest push was sent; 0: none | µs, the client's clock |
//! | 32 | u64 | when that push came | µs, the engine's clock |
//! | 40 | u64 | sent | µs, the engine's clock |
//!
//! 48 bytes. With the time of its arrival the three times are a sample for [`crate::clock::Clock`].

use super::Error;
use super::bytes::{Reader, Writer};

/// The object, as it is moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moved {
    /// Which engine.
    pub version: u32,
    /// Position (m) and velocity (m/s) along x and y.
    pub axes: [[f32; 2]; 2],
    /// When the newest push of this client was sent, µs of its clock; 0: none yet.
    pub echo_us: u64,
    /// When it came, µs of the engine's clock.
    pub came_us: u64,
    /// When this was sent, µs of the engine's clock.
    pub sent_us: u64,
}

impl Moved {
    /// First byte.
    pub const KIND: u8 = 20;
    /// Bytes.
    pub const LEN: usize = 48;

    /// Reads a motion, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let mut reader = Reader::exact(bytes, "moved", Self::LEN)?;
        reader.kind(Self::KIND)?;
        reader.reserved::<3>()?;
        let moved = Self {
            version: reader.u32()?,
            axes: [[reader.f32()?, reader.f32()?], [reader.f32()?, reader.f32()?]],
            echo_us: reader.u64()?,
            came_us: reader.u64()?,
            sent_us: reader.u64()?,
        };
        reader.end()?;
        Ok(moved)
    }

    /// Writes the motion to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let writer = Writer::new(out, "moved").put(&[Self::KIND, 0, 0, 0]).put(&self.version.to_le_bytes());
        let writer = self.axes.iter().flatten().fold(writer, |writer, number| writer.f32(*number));
        let times = [self.echo_us, self.came_us, self.sent_us];
        times.iter().fold(writer, |writer, time| writer.put(&time.to_le_bytes())).end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let moved = Moved { version: 9, axes: [[1.0, -0.5], [2.5, 0.0]], echo_us: 5, came_us: 6, sent_us: 0x0708 };
        let mut bytes = [0; Moved::LEN];
        bytes[0] = 20;
        bytes[4] = 9;
        bytes[8..24].copy_from_slice(&[0, 0, 0x80, 0x3f, 0, 0, 0, 0xbf, 0, 0, 0x20, 0x40, 0, 0, 0, 0]);
        (bytes[24], bytes[32], bytes[40], bytes[41]) = (5, 6, 8, 7);
        let mut out = [0; Moved::LEN];
        assert_eq!(moved.emit(&mut out), Ok(Moved::LEN));
        assert_eq!(out, bytes);
        assert_eq!(Moved::parse(&bytes), Ok(moved));
        out[1] = 1;
        assert_eq!(Moved::parse(&out), Err(Error::Reserved { message: "moved" }));
    }
}
