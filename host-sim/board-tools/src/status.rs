//! What a board says to `status` and `probed`, as far as a program decides by it; the sentences themselves are for a person.

use std::fmt;

use cohold_core::device::probe::{End, Verdict};
use cohold_core::safety::Mode;
use cohold_core::settings::Choice;

use crate::Error;

/// A board's answer to `status`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Status {
    /// Its mode, with the fault in it.
    pub mode: Mode,
    /// Its motors went off because its operator was silent.
    pub let_go: bool,
    said: String,
}

impl Status {
    /// From what stands behind `ok`.
    ///
    /// # Errors
    /// It is no status that this version knows.
    pub fn parse(said: &str) -> Result<Self, Error> {
        let words: Vec<&str> = said.split([' ', ';']).collect();
        let mode = words.windows(3).find_map(|three| match three {
            [name, "fault", number] => Mode::named(name, number.parse().ok()?),
            _ => None,
        });
        let mode = mode.ok_or_else(|| format!("the board says no mode: {said:?}"))?;
        Ok(Self { mode, let_go: said.contains("the operator was silent"), said: said.to_owned() })
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.said)
    }
}

/// A board's answer to `probed`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Probed {
    /// How the last probe ended, or that it has not.
    pub end: End,
    /// Verdict on the signs, once the probe has ended and if it was the check.
    pub verdict: Option<Verdict>,
    said: String,
}

impl Probed {
    /// From what stands behind `ok`.
    ///
    /// # Errors
    /// It is no outcome that this version knows.
    pub fn parse(said: &str) -> Result<Self, Error> {
        let end = said.split([' ', ':']).nth(2).and_then(End::from_name);
        let end = end.ok_or_else(|| format!("the board does not say how the probe ended: {said:?}"))?;
        let verdict = said.split("; ").find_map(|part| Verdict::from_name(part.split_once(": ")?.0));
        Ok(Self { end, verdict, said: said.to_owned() })
    }

    /// Whether it is still under way.
    pub fn is_running(&self) -> bool {
        self.end == End::Running
    }
}

impl fmt::Display for Probed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.said)
    }
}
