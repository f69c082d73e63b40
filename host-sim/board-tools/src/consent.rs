//! Consent: whether an operator lets a board run, in the hands of all who may order it to run, and of all who may stop it.
//!
//! What is sealed for the board says it, from the moment it is taken back: no line has to go through first, nothing that waits for an
//! answer stands in the way. An order to run that was given before it was taken back, and is carried out only after, does not give it again.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Bit 0: given. The others: how often it was taken back.
#[derive(Clone, Debug, Default)]
pub struct Consent(Arc<AtomicU64>);

/// A moment: no consent was taken back since, or one was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment(u64);

impl Consent {
    const GIVEN: u64 = 1;

    /// The moment of an order, which is to be carried out later.
    pub fn moment(&self) -> Moment {
        Moment(self.0.load(Ordering::Acquire) & !Self::GIVEN)
    }

    /// Lets the board run, if consent was not taken back since the moment; whether it does.
    pub fn give(&self, since: Moment) -> bool {
        let give = |state: u64| (state & !Self::GIVEN == since.0).then_some(state | Self::GIVEN);
        self.0.fetch_update(Ordering::AcqRel, Ordering::Acquire, give).is_ok()
    }

    /// Takes it back.
    pub fn withdraw(&self) {
        let withdraw = |state: u64| Some((state & !Self::GIVEN).wrapping_add(2));
        let _ = self.0.fetch_update(Ordering::AcqRel, Ordering::Acquire, withdraw);
    }

    /// Whether the board may run.
    pub fn is_given(&self) -> bool {
        self.0.load(Ordering::Acquire) & Self::GIVEN != 0
    }
}

/// Whether a line to a board turns motors on, and so needs consent.
pub fn runs(line: &str) -> bool {
    matches!(line.split_whitespace().next(), Some("arm" | "check" | "probe"))
}

/// How an operator knows that a board has stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// The board has opened something that was sealed after consent was taken back.
    Heard,
    /// It has heard nothing, and its lease is over: the last yes is longer ago than the board runs on.
    LeaseOver,
}

impl Stopped {
    /// A few words for a person.
    pub fn explain(self) -> &'static str {
        match self {
            Self::Heard => "stopped: the board has heard it",
            Self::LeaseOver => "stopped: the board was not heard, and its lease is over",
        }
    }
}
