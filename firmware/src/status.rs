//! Why a board started and how far its link is, in words for a person.
//!
//! [`Stop`] numbers why a board is not running: 1–31 and from 64 on are the peer's own faults ([`cohold_core::safety::Fault`]), 32 to 63
//! those of the board around it. Numbers are never reused.

use cohold_protocol::link::Stage;

cohold_core::numbered! {
    /// Why the board started anew.
    pub enum Stop {
        32 PowerOn: "power came on",
        33 Panic: "the program found itself in a state that it excludes",
        // A stack overflow ends here too.
        34 HardFault: "the processor refused an instruction or an access",
        35 Watchdog: "the tick or the supervisor made no progress",
        36 BrownOut: "the supply was too low",
        37 Request: "a reset was asked for",
        38 TickMissed: "no tick came for 2 ms",
        39 ClockFailed: "the external clock stopped",
    }
}

impl Stop {
    /// Whether a person has to acknowledge it before the board may be armed.
    pub fn latches(self) -> bool {
        !matches!(self, Self::PowerOn | Self::Request)
    }

    /// Whether memory may have lost what was in it.
    pub fn lost_memory(self) -> bool {
        matches!(self, Self::PowerOn | Self::BrownOut)
    }
}

/// How far the link to the other peer is.
pub fn stage(stage: Stage) -> &'static str {
    match stage {
        Stage::Calling => "calling",
        Stage::Joining => "joining",
        Stage::Idle => "idle",
        Stage::Running => "running",
        Stage::Fading => "fading",
        Stage::Refused => "refused: other settings",
    }
}
