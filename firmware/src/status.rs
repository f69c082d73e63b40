//! Mode, fault and progress, in words that an interrupt can publish with one store each.
//!
//! [`Stop`] numbers why a board is not running: 1–31 are the peer's own faults ([`haptic_core::safety::Fault`]), 32 and up
//! those of the board around it. Numbers are never reused.

use haptic_core::safety::{Command, Mode};

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

/// Mode and fault in one word: mode in bits 0–7, fault number in bits 8–15.
pub fn pack(mode: Mode) -> u32 {
    match mode {
        Mode::Disarmed => 0,
        Mode::Armed => 1,
        Mode::Faulted(fault) => 2 | u32::from(fault.number()) << 8,
        Mode::Probing => 3,
    }
}

/// The mode's name and the fault's number (0: none) in a word of [`pack`].
pub fn unpack(word: u32) -> (&'static str, u8) {
    let name = match word & 0xFF {
        0 => "disarmed",
        1 => "armed",
        3 => "probing",
        _ => "faulted",
    };
    (name, (word >> 8) as u8)
}

/// A command and its number in one word, so that each is carried out once; 0 is none.
pub fn order(number: u32, command: Command) -> u32 {
    let code = match command {
        Command::Arm => 1,
        Command::Disarm => 2,
        Command::Clear => 3,
    };
    number << 8 | code
}

/// The command in a word of [`order`].
pub fn ordered(word: u32) -> Option<Command> {
    match word & 0xFF {
        1 => Some(Command::Arm),
        2 => Some(Command::Disarm),
        3 => Some(Command::Clear),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_core::safety::Fault;

    #[test]
    fn words_carry_what_was_put_in() {
        assert_eq!(unpack(pack(Mode::Disarmed)), ("disarmed", 0));
        assert_eq!(unpack(pack(Mode::Armed)), ("armed", 0));
        assert_eq!(unpack(pack(Mode::Probing)), ("probing", 0));
        assert_eq!(unpack(pack(Mode::Faulted(Fault::PeerLost))), ("faulted", 5));
        for command in [Command::Arm, Command::Disarm, Command::Clear] {
            assert_eq!(ordered(order(77, command)), Some(command));
            assert_ne!(order(77, command), order(78, command));
        }
        assert_eq!(ordered(0), None);
    }

    #[test]
    fn numbers_lead_back_to_causes_and_are_not_the_peers() {
        for number in 0..=255 {
            if let Some(stop) = Stop::from_number(number) {
                assert!(stop as u8 == number && number >= 32);
            }
        }
        assert_eq!(Stop::from_number(35), Some(Stop::Watchdog));
    }
}
