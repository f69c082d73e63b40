//! Why a scene or a run was refused.

use std::fmt::Display;

use cohold_core::settings::Refused;

/// What the operating system or a parser said.
type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why a scene, a peer of it, or a file beside it was refused: one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A place, such as a file with its line, and what is wrong there.
    #[error("{0}: {1}")]
    At(String, Box<Self>),
    /// A key that no scene has.
    #[error("there is no key {key}{hint}")]
    NoKey {
        /// Name of the key, as it was written.
        key: String,
        /// The rest of the sentence, which names the key that may be meant; empty where none is similar.
        hint: String,
    },
    /// What a user wrote has a value that is not allowed.
    #[error("{what} is not allowed: {allowed}")]
    NotAllowed {
        /// Name and value of what the user wrote.
        what: String,
        /// What is allowed, in words.
        allowed: String,
    },
    /// A setting has a value that it does not accept.
    #[error(transparent)]
    Setting(#[from] Refused<'static>),
    /// What cannot be done with which file, device or socket, and what the operating system or a parser said.
    #[error("cannot {0}: {1}")]
    Io(String, Cause),
    /// Anything else, in a sentence.
    #[error("{0}")]
    Refused(String),
}

impl Error {
    /// Whether it is about an unknown key without a similar one, so that a caller may point to the list of all keys.
    pub fn is_unlike(&self) -> bool {
        match self {
            Self::At(_, cause) => cause.is_unlike(),
            Self::NoKey { hint, .. } => hint.is_empty(),
            _ => false,
        }
    }

    /// This error with the place where it arose, such as a file with its line.
    pub fn at(place: impl Display, cause: impl Into<Self>) -> Self {
        Self::At(place.to_string(), Box::new(cause.into()))
    }

    /// A value that is not allowed, and what is.
    pub fn not_allowed(what: impl Into<String>, allowed: impl Into<String>) -> Self {
        Self::NotAllowed { what: what.into(), allowed: allowed.into() }
    }

    /// For `map_err`: turns a failure to `act` (a verb, such as `read`) on `with` (a file or the like) into an error.
    pub fn cannot<E: Into<Cause>>(act: &str, with: &dyn Display) -> impl Fn(E) -> Self + use<E> {
        let what = format!("{act} {with}");
        move |cause| Self::Io(what.clone(), cause.into())
    }
}

/// Makes a sentence a `Refused(String)` of this error, so that `?` and `into` take one.
#[doc(hidden)]
#[macro_export]
macro_rules! sentences_are_refusals {
    ($Error:ty) => {
        impl From<String> for $Error {
            fn from(said: String) -> Self {
                Self::Refused(said)
            }
        }

        impl From<&str> for $Error {
            fn from(said: &str) -> Self {
                Self::Refused(said.to_owned())
            }
        }
    };
}

/// Ends a function with a sentence as its error if this holds: `refuse_if!(ticks < 4, "{ticks} ticks are too few");`.
#[doc(hidden)]
#[macro_export]
macro_rules! refuse_if {
    ($wrong:expr, $($sentence:tt)+) => {
        if $wrong {
            return Err(format!($($sentence)+).into());
        }
    };
}

sentences_are_refusals!(Error);
