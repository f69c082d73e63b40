//! Telemetry: how the sender is doing; for people, logs and live views, never for control.
//!
//! | offset | type | field | unit |
//! |---|---|---|---|
//! | 0 | u8 | kind = 2 | |
//! | 1 | u8 | mode: 0 disarmed, 1 armed, 2 faulted | |
//! | 2 | u8 | fault number, 0 none | |
//! | 3 | u8 | stage of the sender's link to this end, `link::Stage` | |
//! | 4 | u32 | tick | control periods |
//! | 8 | f32 | device position x_h | m |
//! | 12 | f32 | local copy x_o | m |
//! | 16 | f32 | decoded remote copy x_d | m |
//! | 20 | f32 | contact force F_LC | N |
//! | 24 | f32 | coordination force F_T | N |
//! | 28 | f32 | engagement, 0 to 1 | |
//! | 32 | f64 | energy taken from the network | J |
//! | 40 | f64 | energy given to the network | J |
//! | 48 | u32 | round trip | µs |
//! | 52 | u32 | jitter of the round trip | µs |
//! | 56 | i64 | the receiver's clock minus the sender's | µs |
//! | 64 | f32 | drift of the receiver's clock against the sender's | ppm |
//! | 68 | u32 | sealed packets taken | |
//! | 72 | u32 | sealed packets that never came | |
//! | 76 | u32 | flow packets dropped because a newer one was there | |
//! | 80 | u32 | datagrams refused | |
//! | 84 | u32 | ticks that missed their deadline | |
//! | 88 | u32 | longest tick | ns |
//!
//! 92 bytes. Every number is finite.

use super::Error;
use super::bytes::{Reader, Writer};

/// How the sender is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Telemetry {
    /// 0 disarmed, 1 armed, 2 faulted.
    pub mode: u8,
    /// The fault's number, 0 none.
    pub fault: u8,
    /// Stage of the sender's link to this end, as a number.
    pub stage: u8,
    /// The sender's newest tick, control periods since it started.
    pub tick: u32,
    /// Device position x_h, m.
    pub device_position: f32,
    /// Position of the local copy x_o, m.
    pub object_position: f32,
    /// Position of the decoded remote copy x_d, m.
    pub desired_position: f32,
    /// Contact force F_LC on the object, N.
    pub contact_force: f32,
    /// Coordination force F_T on the object, N.
    pub coordination_force: f32,
    /// How far the coordination acts, 0 to 1.
    pub engagement: f32,
    /// Energy taken from the network, J.
    pub energy_received: f64,
    /// Energy given to the network, J.
    pub energy_sent: f64,
    /// Round trip, µs; 0 unknown.
    pub round_trip_us: u32,
    /// Mean deviation of the round trip, µs.
    pub jitter_us: u32,
    /// The receiver's clock minus the sender's, µs.
    pub clock_offset_us: i64,
    /// How much faster the receiver's clock runs than the sender's, ppm.
    pub clock_drift_ppm: f32,
    /// Sealed packets taken.
    pub packets_taken: u32,
    /// Sealed packets that never came.
    pub packets_missing: u32,
    /// Flow packets dropped because a newer one was there.
    pub flow_late: u32,
    /// Datagrams refused.
    pub refused: u32,
    /// Ticks that missed their deadline.
    pub overruns: u32,
    /// Longest tick, ns.
    pub longest_tick_ns: u32,
}

impl Telemetry {
    /// First byte.
    pub const KIND: u8 = 2;
    /// Bytes.
    pub const LEN: usize = 92;

    /// Reads telemetry, which must fill `bytes` exactly.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        let mut reader = Reader::exact(bytes, "telemetry", Self::LEN)?;
        reader.kind(Self::KIND)?;
        let telemetry = Self {
            mode: reader.u8()?,
            fault: reader.u8()?,
            stage: reader.u8()?,
            tick: reader.u32()?,
            device_position: reader.f32()?,
            object_position: reader.f32()?,
            desired_position: reader.f32()?,
            contact_force: reader.f32()?,
            coordination_force: reader.f32()?,
            engagement: reader.f32()?,
            energy_received: reader.f64()?,
            energy_sent: reader.f64()?,
            round_trip_us: reader.u32()?,
            jitter_us: reader.u32()?,
            clock_offset_us: reader.i64()?,
            clock_drift_ppm: reader.f32()?,
            packets_taken: reader.u32()?,
            packets_missing: reader.u32()?,
            flow_late: reader.u32()?,
            refused: reader.u32()?,
            overruns: reader.u32()?,
            longest_tick_ns: reader.u32()?,
        };
        reader.end()?;
        Ok(telemetry)
    }

    /// Writes the telemetry to the front of `out` and gives its length.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        Writer::new(out, "telemetry")
            .put(&[Self::KIND, self.mode, self.fault, self.stage])
            .put(&self.tick.to_le_bytes())
            .f32(self.device_position)
            .f32(self.object_position)
            .f32(self.desired_position)
            .f32(self.contact_force)
            .f32(self.coordination_force)
            .f32(self.engagement)
            .f64(self.energy_received)
            .f64(self.energy_sent)
            .put(&self.round_trip_us.to_le_bytes())
            .put(&self.jitter_us.to_le_bytes())
            .put(&self.clock_offset_us.to_le_bytes())
            .f32(self.clock_drift_ppm)
            .put(&self.packets_taken.to_le_bytes())
            .put(&self.packets_missing.to_le_bytes())
            .put(&self.flow_late.to_le_bytes())
            .put(&self.refused.to_le_bytes())
            .put(&self.overruns.to_le_bytes())
            .put(&self.longest_tick_ns.to_le_bytes())
            .end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let telemetry = Telemetry {
            mode: 1,
            fault: 2,
            stage: 3,
            tick: 4,
            device_position: 1.0,
            object_position: 2.0,
            desired_position: 3.0,
            contact_force: 4.0,
            coordination_force: 5.0,
            engagement: 0.5,
            energy_received: 6.0,
            energy_sent: 7.0,
            round_trip_us: 0x10,
            jitter_us: 0x11,
            clock_offset_us: -2,
            clock_drift_ppm: -1.0,
            packets_taken: 0x12,
            packets_missing: 0x13,
            flow_late: 0x14,
            refused: 0x15,
            overruns: 0x16,
            longest_tick_ns: 0x17,
        };
        #[rustfmt::skip]
        let bytes: [u8; Telemetry::LEN] = [
            2, 1, 2, 3, 4, 0, 0, 0,
            0, 0, 0x80, 0x3f, 0, 0, 0x00, 0x40, 0, 0, 0x40, 0x40, 0, 0, 0x80, 0x40, 0, 0, 0xa0, 0x40, 0, 0, 0x00, 0x3f,
            0, 0, 0, 0, 0, 0, 0x18, 0x40, 0, 0, 0, 0, 0, 0, 0x1c, 0x40,
            0x10, 0, 0, 0, 0x11, 0, 0, 0, 0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0, 0, 0x80, 0xbf,
            0x12, 0, 0, 0, 0x13, 0, 0, 0, 0x14, 0, 0, 0, 0x15, 0, 0, 0, 0x16, 0, 0, 0, 0x17, 0, 0, 0,
        ];
        let mut out = [0; Telemetry::LEN];
        assert_eq!(telemetry.emit(&mut out), Ok(Telemetry::LEN));
        assert_eq!(out, bytes);
        assert_eq!(Telemetry::parse(&bytes), Ok(telemetry));
    }
}
