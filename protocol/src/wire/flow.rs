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
