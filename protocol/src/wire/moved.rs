//! Push and moved: what clients do to the shared object, and where whoever has the dynamics engine moves it; each once each packet
//! period, newest wins ([`crate::roles::cooperative`]).

use crate::bytes::layout;

layout! {
    /// What a client does to the shared object, to whoever moves it.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub message Push("push", 32 bytes, kind 19) {
        /// How long the client takes the way to the engine and back to be, µs: what its contact and the engine's damping follow;
        /// 2³² − 1 where it is not known.
        4 => round_trip_us: u32,
        /// When it was sent, µs of the client's clock; what was sent earlier than one that has come is out of date.
        8 => sent_us: u64,
        /// Force on the object along x and y, N.
        16 => force: [f32; 2],
        /// Where the hand is, for others to see, m.
        24 => hand: [f32; 2],
    }
}

layout! {
    /// The object, as it is moved, to each client. With the time of its arrival the three times are a sample for
    /// [`crate::clock::Clock`].
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub message Moved("moved", 48 bytes, kind 20) {
        /// Which engine.
        4 => version: u32,
        /// Position (m) and velocity (m/s) along x and y.
        8 => axes: [[f32; 2]; 2],
        /// When the newest push of this client was sent, µs of its clock; 0: none yet.
        24 => echo_us: u64,
        /// When it came, µs of the engine's clock.
        32 => came_us: u64,
        /// When this was sent, µs of the engine's clock.
        40 => sent_us: u64,
    }
}
