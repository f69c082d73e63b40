//! Mode, fault and the cause of a start, as a person is told them.
//!
//! [`Stop`] numbers why a board is not running: 1–31 are the peer's own faults ([`haptic_core::safety::Fault`]), 32 and up
//! those of the board around it. Numbers are never reused.

use haptic_core::safety::Mode;
use haptic_protocol::link::Stage;

haptic_core::numbered! {
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
}

/// A mode's name.
pub fn name(mode: Mode) -> &'static str {
    match mode {
        Mode::Disarmed => "disarmed",
        Mode::Armed => "armed",
        Mode::Probing => "probing",
        Mode::Faulted(_) => "faulted",
    }
}

/// The number of the fault that a mode holds; 0: none.
pub fn fault(mode: Mode) -> u8 {
    if let Mode::Faulted(fault) = mode { fault.number() } else { 0 }
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
