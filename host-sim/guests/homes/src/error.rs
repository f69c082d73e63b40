//! Why an invite is none, or did not lead to a key: one line.

/// Why an invite is none, or did not lead to a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// What was typed is no link.
    #[error("this is no link: one reads haptic://HOST:PORT/ and 29 letters and digits, as `--invite` prints it")]
    NoLink,
    /// A letter of a link is wrong.
    #[error("a letter of this link is wrong or missing: copy it whole")]
    Mistyped,
    /// The other side says that somebody else was quicker.
    #[error("this link has been used: each serves once; ask for a new one, and ask who has used it if you did not")]
    Used,
    /// Nobody has come in time.
    #[error("this link is over: it lives ten minutes; make a new one")]
    Over,
}

impl From<Error> for cohold_live::Error {
    fn from(error: Error) -> Self {
        Self::Refused(error.to_string())
    }
}
