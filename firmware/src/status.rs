//! Mode, fault and the cause of a start, as a person is told them.
//!
//! [`Stop`] numbers why a board is not running: 1–31 are the peer's own faults ([`haptic_core::safety::Fault`]), 32 and up
//! those of the board around it. Numbers are never reused.

use haptic_core::safety::Mode;
use haptic_protocol::link::Stage;

/// Why the board started anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Stop {
    /// Power came on, or the reset button was pressed.
    PowerOn = 32,
    /// The program found itself in a state that it excludes.
    Panic = 33,
    /// The processor refused an instruction or an access; a stack overflow ends here too.
    HardFault = 34,
    /// The tick or the supervisor made no progress, and the watchdog ended it.
    Watchdog = 35,
    /// The supply fell below the brown-out threshold.
    BrownOut = 36,
    /// A debugger or the operator asked for a reset.
    Request = 37,
}

impl Stop {
    /// The cause called by `number`.
    pub fn from_number(number: u8) -> Option<Self> {
        [Self::PowerOn, Self::Panic, Self::HardFault, Self::Watchdog, Self::BrownOut, Self::Request]
            .into_iter()
            .find(|stop| *stop as u8 == number)
    }

    /// Whether a person has to acknowledge it before the board may be armed.
    pub fn latches(self) -> bool {
        matches!(self, Self::Panic | Self::HardFault | Self::Watchdog | Self::BrownOut)
    }

    /// One sentence for a person.
    pub fn explain(self) -> &'static str {
        match self {
            Self::PowerOn => "power came on",
            Self::Panic => "the program found itself in a state that it excludes",
            Self::HardFault => "the processor refused an instruction or an access",
            Self::Watchdog => "the tick or the supervisor made no progress",
            Self::BrownOut => "the supply was too low",
            Self::Request => "a reset was asked for",
        }
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
