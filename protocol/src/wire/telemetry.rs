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
