//! The lease: one state at each end of a sealed link decides whether a board's motors may be on.
//!
//! The board runs a [`Holder`], an operator's end runs a [`Giver`]. Each end puts one byte into every datagram that it seals: the
//! operator's end its [`Word`], the board its [`Told`]. So an attacker on the path can drop some datagrams and pass others, and gains
//! nothing: no single datagram keeps motors on, and none is needed to turn them off.
//!
//! 1. Running is a level. Motors that an operator turned on stay on while the newest word is the `Run` that started them, and while
//!    that word was said within the lease, by the board's own clock.
//! 2. A run starts once, while its word is the newest one and was said within the lease.
//! 3. Stop is a level, said in every datagram until the board confirms it. It ends every run, also one that runs alone.
//! 4. Only the board says that motors are off. An operator's end says *stopped* if the board says *off* after it heard that very stop.
//!
//! Sans-IO, without allocation and without a clock. Times are µs, and each age is measured by one clock, so clocks may drift.
//! `tests/inside/lease` explores both ends over a network that drops, holds and reorders.

use crate::aged::Aged;

/// Numbers wrap after this one; 0 is the number of nothing. At most three words are ahead of the newest one that the board has heard.
const LAST: u8 = 63;

/// Number of a word. Each change of an operator's mind has the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Number(u8);

impl Number {
    fn next(self) -> Self {
        Self(self.0 % LAST + 1)
    }
}

/// What an operator's end wants, by its code on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Want {
    /// Nothing. Motors that this end let run must not go on.
    #[default]
    Nothing = 0,
    /// All motors off, whoever started them.
    Stop = 1,
    /// The run with this number may start, or go on.
    Run = 2,
}

/// What an operator's end says in every datagram.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Word {
    /// What the operator's end wants.
    pub want: Want,
    /// Which of its wishes this is.
    pub number: Number,
}

/// What is known of a board's motors, by its code on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Motors {
    /// They are off, and no order waits that would turn them on.
    #[default]
    Off = 0,
    /// They may be on, as long as an operator lets them.
    Leased = 1,
    /// They are on without an operator.
    Alone = 2,
}

/// What a board says in every datagram.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Told {
    /// The state of its motors.
    pub motors: Motors,
    /// Number of the newest word that the board has heard of this operator.
    pub heard: Number,
}

impl Word {
    /// The byte on the wire: what is wanted in bits 0 and 1, the number in bits 2 to 7.
    pub fn byte(self) -> u8 {
        self.number.0 << 2 | self.want as u8
    }

    /// From such a byte. An unknown wish is a stop.
    pub fn of_byte(byte: u8) -> Self {
        let known = [Want::Nothing, Want::Stop, Want::Run];
        let want = known.get(usize::from(byte & 3)).copied().unwrap_or(Want::Stop);
        Self { want, number: Number(byte >> 2) }
    }
}

impl Told {
    /// The byte on the wire: the state in bits 0 and 1, the number in bits 2 to 7.
    pub fn byte(self) -> u8 {
        self.heard.0 << 2 | self.motors as u8
    }

    /// From such a byte. In an unknown state motors may be on.
    pub fn of_byte(byte: u8) -> Self {
        let known = [Motors::Off, Motors::Leased, Motors::Alone];
        let motors = known.get(usize::from(byte & 3)).copied().unwrap_or(Motors::Leased);
        Self { motors, heard: Number(byte >> 2) }
    }
}

/// Why a start is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum No {
    /// The newest word is not the run that the start was said under.
    NotLet,
    /// That word is older than the lease.
    Stale,
    /// This run has started before.
    Used,
    /// Motors are on.
    On,
    /// The board has not said lately that its motors are off, or has not heard this end's newest word.
    Unknown,
    /// A stop is not confirmed yet.
    Unstopped,
}

impl No {
    /// One clause for a person.
    pub fn explain(self) -> &'static str {
        match self {
            Self::NotLet => "the operator's end does not let the motors run",
            Self::Stale => {
                "the operator's permission was older than safety.operator_lost_s when it arrived: use a faster path"
            }
            Self::Used => "this start was carried out before: say it again",
            Self::On => "its motors are on: stop them first",
            Self::Unknown => "the board has not said in the last 0.3 s that its motors are off",
            Self::Unstopped => "the board has not confirmed the stop",
        }
    }
}

/// An event at a board.
#[derive(Clone, Copy, Debug)]
pub enum AtBoard {
    /// Another operator, or one that has restarted, takes the place of the one before.
    Session,
    /// The newest datagram of the session said this.
    Heard {
        /// What the operator's end wants.
        word: Word,
        /// The newest time of this board's clock that the sender knew, µs.
        echo_us: Option<u64>,
    },
    /// A line turns motors on.
    Start {
        /// The word that the line was said under.
        word: Word,
        /// They run without an operator.
        alone: bool,
    },
    /// Motors are to be off, or have gone off: a fault, a switch, a stop at the board, the end of a probe.
    Off,
    /// Time passes.
    Look,
}

/// The board's side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Holder {
    /// How old the newest permission may be, µs: `safety.operator_lost_s` minus the time that turning off takes.
    pub lease_us: u64,
    word: Word,
    /// When that word was said at the earliest, µs.
    said_us: Option<u64>,
    /// The run that it is about has started.
    used: bool,
    motors: Motors,
}

impl Holder {
    /// A board that has heard nothing, with its motors off.
    pub fn new(lease_us: u64) -> Self {
        Self { lease_us, ..Self::default() }
    }

    /// Takes in an event. Afterwards [`Holder::motors`] says whether motors are to be on.
    ///
    /// # Errors
    /// Why a start is refused: nothing has changed.
    pub fn step(&mut self, now_us: u64, event: AtBoard) -> Result<(), No> {
        match event {
            AtBoard::Session => self.hear(Word::default()),
            AtBoard::Heard { word, echo_us } => {
                if word != self.word {
                    self.hear(word);
                }
                self.said_us = self.said_us.max(echo_us);
                if word.want == Want::Stop {
                    self.motors = Motors::Off;
                }
            }
            AtBoard::Start { word, alone } => {
                if word != self.word || word.want != Want::Run {
                    return Err(No::NotLet);
                }
                if !self.is_fresh(now_us) {
                    return Err(No::Stale);
                }
                if self.used {
                    return Err(No::Used);
                }
                if self.motors != Motors::Off {
                    return Err(No::On);
                }
                self.used = true;
                self.motors = if alone { Motors::Alone } else { Motors::Leased };
            }
            AtBoard::Off => self.motors = Motors::Off,
            AtBoard::Look if !self.is_fresh(now_us) => self.end_lease(),
            AtBoard::Look => {}
        }
        Ok(())
    }

    /// Whether motors are to be on, and for whom.
    pub fn motors(&self) -> Motors {
        self.motors
    }

    /// What is said in every datagram. `driven`: motors are on, or an order waits that turns them on.
    pub fn told(&self, driven: bool) -> Told {
        let motors = if driven && self.motors == Motors::Off { Motors::Leased } else { self.motors };
        Told { motors, heard: self.word.number }
    }

    /// Another word: no run of it has started, and the lease of the one before is over.
    fn hear(&mut self, word: Word) {
        (self.word, self.said_us, self.used) = (word, None, false);
        self.end_lease();
    }

    fn is_fresh(&self, now_us: u64) -> bool {
        self.said_us.is_some_and(|said_us| now_us.saturating_sub(said_us) < self.lease_us)
    }

    fn end_lease(&mut self) {
        if self.motors == Motors::Leased {
            self.motors = Motors::Off;
        }
    }
}

/// How old a board's word may be that is shown to a person, µs.
const SHOWN_US: u64 = 300_000;

/// An event at an operator's end.
#[derive(Clone, Copy, Debug)]
pub enum AtOperator {
    /// The board has restarted, or is another one.
    Session,
    /// A person starts something.
    Start,
    /// A person stops everything.
    Stop,
    /// Nobody lets motors run any more.
    Leave,
    /// Somebody is there who can stop them: a page has asked.
    Asked,
    /// The newest datagram of the board said this.
    Heard {
        /// What the board says.
        told: Told,
        /// The newest time of this end's clock that the board knew, µs.
        echo_us: Option<u64>,
    },
}

/// The operator's side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Giver {
    /// Permission ends if nobody has asked for so long, µs.
    pub silence_us: u64,
    shown_us: u64,
    word: Word,
    asked_us: u64,
    /// What the board said last, at the earliest then by this end's clock.
    told: Option<Aged<Told>>,
    stopped: bool,
}

impl Default for Giver {
    /// An end that wants nothing, whose permissions need nobody who asks.
    fn default() -> Self {
        let word = Word { want: Want::Nothing, number: Number::default().next() };
        Self { silence_us: u64::MAX, shown_us: SHOWN_US, word, asked_us: 0, told: None, stopped: false }
    }
}

impl Giver {
    /// Takes in an event.
    ///
    /// # Errors
    /// Why a start is refused: nothing has changed.
    pub fn step(&mut self, now_us: u64, event: AtOperator) -> Result<(), No> {
        match event {
            AtOperator::Session => {
                self.told = None;
                // A stop that is not confirmed goes on.
                if self.want() == Want::Run || self.stopped {
                    self.change(Want::Nothing);
                }
            }
            AtOperator::Start => {
                match self.fresh(now_us) {
                    _ if self.want() == Want::Stop && !self.stopped => return Err(No::Unstopped),
                    Some(Told { motors: Motors::Leased | Motors::Alone, .. }) => return Err(No::On),
                    Some(Told { heard, .. }) if *heard == self.word.number => {}
                    _ => return Err(No::Unknown),
                }
                self.asked_us = now_us;
                self.change(Want::Run);
            }
            AtOperator::Stop if self.want() != Want::Stop || self.stopped => self.change(Want::Stop),
            AtOperator::Leave if self.want() == Want::Run => self.change(Want::Nothing),
            AtOperator::Stop | AtOperator::Leave => {}
            AtOperator::Asked => self.asked_us = now_us,
            AtOperator::Heard { told, echo_us } => {
                self.told = echo_us.map(|echo_us| Aged::new(told, echo_us));
                let off = Told { motors: Motors::Off, heard: self.word.number };
                self.stopped |= self.want() == Want::Stop && told == off;
            }
        }
        Ok(())
    }

    /// What is said in every datagram from now on.
    pub fn word(&mut self, now_us: u64) -> Word {
        if now_us.saturating_sub(self.asked_us) > self.silence_us && self.want() == Want::Run {
            self.change(Want::Nothing);
        }
        self.word
    }

    /// Whether the other end has to hear from this one in every packet period: a run goes on, or a stop is not confirmed.
    pub fn is_eager(&self) -> bool {
        self.want() == Want::Run || self.want() == Want::Stop && !self.stopped
    }

    /// What a person may be shown of the motors. `None`: the board's newest word is too old, motors may be on.
    pub fn shown(&self, now_us: u64) -> Option<Motors> {
        self.fresh(now_us).map(|told| told.motors)
    }

    fn fresh(&self, now_us: u64) -> Option<&Told> {
        self.told.as_ref()?.within(now_us, self.shown_us)
    }

    /// Whether the board has said *off* after it heard the newest stop. Only then a person is told *stopped*.
    pub fn is_stopped(&self) -> bool {
        self.stopped
    }

    fn want(&self) -> Want {
        self.word.want
    }

    fn change(&mut self, want: Want) {
        (self.word, self.stopped) = (Word { want, number: self.word.number.next() }, false);
    }
}

#[cfg(test)]
#[path = "../tests/inside/lease/mod.rs"]
mod explored;
