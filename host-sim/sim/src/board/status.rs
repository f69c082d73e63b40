//! What a board says to `status`, as far as a program decides by it; the sentence itself is for a person.

use std::fmt;

use haptic_core::safety::Mode;

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
    pub fn parse(said: &str) -> Result<Self, String> {
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
