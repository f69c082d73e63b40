//! Messages of fixed length: telemetry, what links say for themselves, and a shared object that all push.
//! Every number is finite.

use crate::bytes::layout;

layout! {
    /// How the sender is doing; for people, logs and live views, never for control.
    pub message Telemetry("telemetry", 88 bytes, kind 2) {
        1 => mode: u8 where |mode| *mode <= 2, "0 disarmed, 1 armed, 2 faulted.";
        2 => fault: u8, "The fault's number, 0 none.";
        3 => stage: u8 where |stage| *stage <= 5, "Stage of the sender's link to this end, as a number.";
        4 => tick: u32, "The sender's newest tick, control periods since it started.";
        8 => device_position: f32, "Device position x_h, m.";
        12 => object_position: f32, "Position of the local copy x_o, m.";
        16 => desired_position: f32, "Position of the decoded remote copy x_d, m.";
        20 => contact_force: f32, "Contact force F_LC on the object, N.";
        24 => coordination_force: f32, "Coordination force F_T on the object, N.";
        28 => energy_received: f64, "Energy taken from the network, J.";
        36 => energy_sent: f64, "Energy given to the network, J.";
        44 => round_trip_us: u32, "Round trip, µs; 0 unknown.";
        48 => jitter_us: u32, "Mean deviation of the round trip, µs.";
        52 => clock_offset_us: i64, "The receiver's clock minus the sender's, µs.";
        60 => clock_drift_ppm: f32, "How much faster the receiver's clock runs than the sender's, ppm.";
        64 => packets_taken: u32, "Sealed packets taken.";
        68 => packets_missing: u32, "Sealed packets that never came.";
        72 => flow_late: u32, "Flow packets dropped because a newer one was there.";
        76 => refused: u32, "Datagrams refused.";
        80 => overruns: u32, "Ticks that missed their deadline.";
        84 => longest_tick_ns: u32, "Longest tick, ns.";
    }
}

layout! {
    /// Acknowledgement: the numbers of the events that have arrived.
    pub message Ack("acknowledgement", 12 bytes, kind 4) {
        4 => next: u32, "Every event before this number has arrived.";
        8 => ahead: u32, "Bit i: event `next + 1 + i` has arrived too.";
    }
}

layout! {
    /// What time is it at your end? Also what keeps an idle session alive.
    pub message Probe("probe", 12 bytes, kind 5) {
        4 => sent_us: u64, "The prober's clock when it sent this, µs (t1).";
    }
}

layout! {
    /// The answer to a [`Probe`].
    pub message Reply("reply", 28 bytes, kind 6) {
        4 => probe_sent_us: u64, "The prober's clock when it sent the probe, µs (t1).";
        12 => probe_received_us: u64, "The answerer's clock when the probe came, µs (t2).";
        20 => sent_us: u64, "The answerer's clock when it sent this, µs (t3).";
    }
}

layout! {
    /// The sender ends the session, and says so before it falls silent.
    pub message Goodbye("goodbye", 4 bytes, kind 7) {}
}

layout! {
    /// What a client does to the shared object, to whoever moves it; each packet period, newest wins.
    pub message Push("push", 32 bytes, kind 19) {
        4 => round_trip_us: u32,
            "How long the client takes the way to the engine and back to be, µs: what its contact and the engine's \
             damping follow; 2³² − 1 where it is not known.";
        8 => sent_us: u64,
            "When it was sent, µs of the client's clock; what was sent earlier than one that has come is out of date.";
        16 => force: [f32; 2], "Force on the object along x and y, N.";
        24 => hand: [f32; 2], "Where the hand is, for others to see, m.";
    }
}

layout! {
    /// The object, as it is moved, to each client; each packet period, newest wins. With the time of its arrival the three times
    /// are a sample for [`crate::clock::Clock`].
    pub message Moved("moved", 48 bytes, kind 20) {
        4 => version: u32, "Which engine.";
        8 => axes: [[f32; 2]; 2], "Position (m) and velocity (m/s) along x and y.";
        24 => echo_us: u64, "When the newest push of this client was sent, µs of its clock; 0: none yet.";
        32 => came_us: u64, "When it came, µs of the engine's clock.";
        40 => sent_us: u64, "When this was sent, µs of the engine's clock.";
    }
}
