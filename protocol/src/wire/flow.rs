//! Flow: what holds the two copies of the shared object together, once each packet period, newest wins.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 1 | |
//! | 1 | u8 | flags: bit 0 engaged, bit 1 fading, others 0 | |
//! | 2 | u16 | 0 | |
//! | 4 | u32 | tick | control periods since the sender started, wraps |
//! | 8 | f32 | position of the sender's copy x_o | m |
//! | 12 | f32 | velocity of the sender's copy ẋ_o | m/s |
//! | 16 | f32 | wave sample u_out | √W |
//! | 20 | f64 | wave integral T_c·Σu_out | √W·s |
//! | 28 | f64 | energy sent ½·T_c·Σu_out² | J |
//!
//! 36 bytes. The two sums run from the tick at which the sender engaged and cover every tick up to and including `tick`;
//! they are f64 so that an f32 peer's values arrive exactly and hours of summing lose nothing. Every number is finite.
//! Power-domain uses position and velocity, wave-domain the rest (THEORY §2, §5); what a law does not use is 0.

use super::Error;
use super::bytes::{Reader, Writer};

/// One packet period's worth of coordination.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flow {
    /// The sender's coordination acts: its motors are armed and it is engaged with this end.
    pub engaged: bool,
    /// The sender has not heard from this end for a while and is letting go.
    pub fading: bool,
    /// The sender's newest tick, in control periods since it started; wraps after 49 days at 1 kHz.
    pub tick: u32,
    /// Position of the sender's copy of the object, m.
    pub position: f32,
    /// Velocity of the sender's copy of the object, m/s.
    pub velocity: f32,
    /// Wave sample u_out, √W.
    pub wave: f32,
    /// T_c·Σu_out since the sender engaged, √W·s.
    pub wave_integral: f64,
    /// ½·T_c·Σu_out² since the sender engaged, J; never falls.
    pub energy_sent: f64,
}

impl Flow {
    /// First byte.
    pub const KIND: u8 = 1;
    /// Bytes.
    pub const LEN: usize = 36;

    const ENGAGED: u8 = 1 << 0;
    const FADING: u8 = 1 << 1;

    /// Reads a flow, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let mut reader = Reader::exact(bytes, "flow", Self::LEN)?;
        reader.kind(Self::KIND)?;
        let flags = reader.u8()?;
        if flags & !(Self::ENGAGED | Self::FADING) != 0 {
            return Err(Error::Reserved { message: "flow" });
        }
        reader.reserved::<2>()?;
        let flow = Self {
            engaged: flags & Self::ENGAGED != 0,
            fading: flags & Self::FADING != 0,
            tick: reader.u32()?,
            position: reader.f32()?,
            velocity: reader.f32()?,
            wave: reader.f32()?,
            wave_integral: reader.f64()?,
            energy_sent: reader.f64()?,
        };
        reader.end()?;
        Ok(flow)
    }

    /// Writes the flow to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        let flags = u8::from(self.engaged) | u8::from(self.fading) << 1;
        Writer::new(out, "flow")
            .put(&[Self::KIND, flags, 0, 0])
            .put(&self.tick.to_le_bytes())
            .f32(self.position)
            .f32(self.velocity)
            .f32(self.wave)
            .f64(self.wave_integral)
            .f64(self.energy_sent)
            .end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BYTES: [u8; Flow::LEN] = [
        0x01, 0x01, 0x00, 0x00, // kind, engaged
        0x78, 0x56, 0x34, 0x12, // tick
        0x00, 0x00, 0x80, 0x3f, // 1.0
        0x00, 0x00, 0x00, 0xbf, // -0.5
        0x00, 0x00, 0x20, 0x40, // 2.5
        0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xd0, 0xbf, // -0.25
        0x00, 0x00, 0x00, 0x00, 0x00, 0x40, 0x5f, 0x40, // 125.0
    ];

    #[test]
    fn literal_bytes() {
        let flow = Flow {
            engaged: true,
            fading: false,
            tick: 0x1234_5678,
            position: 1.0,
            velocity: -0.5,
            wave: 2.5,
            wave_integral: -0.25,
            energy_sent: 125.0,
        };
        let mut out = [0; Flow::LEN];
        assert_eq!(flow.emit(&mut out), Ok(Flow::LEN));
        assert_eq!(out, BYTES);
        assert_eq!(Flow::parse(&BYTES), Ok(flow));
    }

    #[test]
    fn refuses_what_version_1_does_not_know() {
        let mut bytes = BYTES;
        bytes[1] = 4;
        assert_eq!(Flow::parse(&bytes), Err(Error::Reserved { message: "flow" }));
        bytes = BYTES;
        bytes[3] = 1;
        assert_eq!(Flow::parse(&bytes), Err(Error::Reserved { message: "flow" }));
        bytes = BYTES;
        bytes[8..12].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(Flow::parse(&bytes), Err(Error::NotFinite { message: "flow" }));
        bytes = BYTES;
        bytes[28..36].copy_from_slice(&f64::INFINITY.to_le_bytes());
        assert_eq!(Flow::parse(&bytes), Err(Error::NotFinite { message: "flow" }));
    }

    #[test]
    fn too_little_room_is_an_error() {
        let wanted = Err(Error::Length { message: "flow", wanted: 36, got: 35 });
        assert_eq!(Flow::default().emit(&mut [0; 35]), wanted);
    }
}
