//! Flow: what holds the two copies of the shared object together, once each packet period, newest wins.
//!
//! The two sums run from the tick at which the sender engaged and cover every tick up to and including `tick`; they are f64 so
//! that an f32 peer's values arrive exactly and hours of summing lose nothing. Every number is finite. Power-domain uses position
//! and velocity, wave-domain the rest (THEORY §2, §5); what a law does not use is 0.

use crate::bytes::layout;

layout! {
    /// One packet period's worth of coordination.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub message Flow("flow", 36 bytes, kind 1) {
        flags at 1 {
            /// The sender's coordination acts: its motors are armed and it is engaged with this end.
            engaged,
            /// The sender has not heard from this end for a while and is letting go.
            fading,
        }
        /// The sender's newest tick, in control periods since it started; wraps after 49 days at 1 kHz.
        4 => tick: u32,
        /// Position of the sender's copy of the object, m.
        8 => position: f32,
        /// Velocity of the sender's copy of the object, m/s.
        12 => velocity: f32,
        /// Wave sample u_out, √W.
        16 => wave: f32,
        /// T_c·Σu_out since the sender engaged, √W·s.
        20 => wave_integral: f64,
        /// ½·T_c·Σu_out² since the sender engaged, J; never falls.
        28 => energy_sent: f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

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
