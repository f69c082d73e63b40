//! Refused: what was not taken and why, reported to a person while the program runs, in bounded memory and never in a stream.

use std::fmt::Display;

use cohold_protocol::link::Error;

/// Between two lines about different things, µs.
const EVERY_US: u64 = 5_000_000;
/// Between two lines about the same, µs.
const AGAIN_US: u64 = 60_000_000;

/// The newest refusal of a line, or of nobody's line: whose it was, and why.
#[derive(Clone, Copy, Debug)]
pub struct Refused<A, W = Error> {
    /// The newest one, reported or not.
    pub newest: Option<(A, W)>,
    reported: Option<((A, W), u64)>,
    waits: bool,
}

impl<A, W> Default for Refused<A, W> {
    fn default() -> Self {
        Self { newest: None, reported: None, waits: false }
    }
}

impl<A: Copy + PartialEq, W: Copy + PartialEq> Refused<A, W> {
    /// What came from there was refused.
    pub fn note(&mut self, from: A, why: W) {
        self.newest = Some((from, why));
        self.waits = true;
    }

    /// The newest one, if it is to be reported now.
    pub fn take(&mut self, now_us: u64) -> Option<(A, W)> {
        let newest = self.newest.filter(|_| self.waits)?;
        let since_us = self.reported.map(|(reported, at_us)| (reported == newest, now_us.saturating_sub(at_us)));
        if since_us.is_some_and(|(same, since_us)| since_us < if same { AGAIN_US } else { EVERY_US }) {
            return None;
        }
        self.waits = false;
        self.reported = Some((newest, now_us));
        Some(newest)
    }
}

/// Whether it is worth telling: what comes of a restart, a replay or the network passes by itself.
pub fn is_telling(why: &Error) -> bool {
    use Error::{BeyondLast, Exhausted, Forged, NoSession, OtherSession, Replayed, TooOld};
    !matches!(why, NoSession | OtherSession | Replayed | TooOld | Forged | BeyondLast | Exhausted)
}

/// What is wrong with whoever is at `from`, in words for a person at this end.
pub fn wrong(from: impl Display, why: &Error) -> String {
    let what = match why {
        Error::ForgedGreeting => "holds another key: give both ends of a line the same one".to_owned(),
        Error::OwnNumber => "has the number of this end, or is this end: give the two different numbers".to_owned(),
        Error::Stranger | Error::NotForUs => "has another number than belongs here".to_owned(),
        Error::OtherLine => "is on another line".to_owned(),
        Error::Stale => {
            "answers too late: the way there and back takes more than 1 s and than twice safety.max_delay_s".to_owned()
        }
        Error::Parameters(table) => format!("was told other parameters: table [{table}] differs"),
        Error::Impossible(_) => format!("says what cannot be and is let go of: {why}"),
        why => format!("is not understood: {why}"),
    };
    format!("{from} {what}")
}
