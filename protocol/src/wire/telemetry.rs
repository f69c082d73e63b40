//! Telemetry: how the sender is doing; for people, logs and live views, never for control. Every number is finite.

use crate::bytes::layout;

layout! {
    /// How the sender is doing.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub message Telemetry("telemetry", 92 bytes, kind 2) {
        /// 0 disarmed, 1 armed, 2 faulted.
        1 => mode: u8,
        /// The fault's number, 0 none.
        2 => fault: u8,
        /// Stage of the sender's link to this end, as a number.
        3 => stage: u8,
        /// The sender's newest tick, control periods since it started.
        4 => tick: u32,
        /// Device position x_h, m.
        8 => device_position: f32,
        /// Position of the local copy x_o, m.
        12 => object_position: f32,
        /// Position of the decoded remote copy x_d, m.
        16 => desired_position: f32,
        /// Contact force F_LC on the object, N.
        20 => contact_force: f32,
        /// Coordination force F_T on the object, N.
        24 => coordination_force: f32,
        /// How far the coordination acts, 0 to 1.
        28 => engagement: f32,
        /// Energy taken from the network, J.
        32 => energy_received: f64,
        /// Energy given to the network, J.
        40 => energy_sent: f64,
        /// Round trip, µs; 0 unknown.
        48 => round_trip_us: u32,
        /// Mean deviation of the round trip, µs.
        52 => jitter_us: u32,
        /// The receiver's clock minus the sender's, µs.
        56 => clock_offset_us: i64,
        /// How much faster the receiver's clock runs than the sender's, ppm.
        64 => clock_drift_ppm: f32,
        /// Sealed packets taken.
        68 => packets_taken: u32,
        /// Sealed packets that never came.
        72 => packets_missing: u32,
        /// Flow packets dropped because a newer one was there.
        76 => flow_late: u32,
        /// Datagrams refused.
        80 => refused: u32,
        /// Ticks that missed their deadline.
        84 => overruns: u32,
        /// Longest tick, ns.
        88 => longest_tick_ns: u32,
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
