//! Why bytes are not a message of version 4, the error that every layout gives; and why a link does not take a datagram.

/// The version this crate speaks: byte 0 of every datagram, now and in every version to come.
pub const VERSION: u8 = 4;

/// Why bytes are not a message of version 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// A message is shorter or longer than its layout.
    #[error("{message}: {got} bytes where {wanted} belong")]
    Length {
        /// Which message.
        message: &'static str,
        /// Bytes its layout has.
        wanted: usize,
        /// Bytes there were.
        got: usize,
    },
    /// The first byte names a version this crate does not speak.
    #[error("version {0} is spoken here, this end speaks {VERSION}")]
    UnknownVersion(u8),
    /// The kind byte names no message of version 4.
    #[error("kind {0} is no message of version {VERSION}")]
    UnknownKind(u8),
    /// A byte or bit of this message that version 4 reserves is not 0.
    #[error("{0}: a reserved byte or flag is not 0")]
    Reserved(&'static str),
    /// A number in this message is infinite or NaN.
    #[error("{0}: a number is infinite or NaN")]
    NotFinite(&'static str),
    /// A field holds a value that version 4 gives no meaning.
    #[error("{message}: {field} has a value without a meaning")]
    OutOfRange {
        /// In which message.
        message: &'static str,
        /// Which field.
        field: &'static str,
    },
}

impl Error {
    pub(crate) const fn length(message: &'static str, wanted: usize, got: usize) -> Self {
        Self::Length { message, wanted, got }
    }
}

/// Why a link does not take a datagram, or seals none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// It is not a datagram of version 4, or what was sealed in it is not a message of version 4.
    #[error(transparent)]
    Wire(#[from] Error),
    /// It comes from this peer's own number.
    #[error("a datagram from this peer's own number: reflected, or two peers have the same number")]
    OwnNumber,
    /// It comes from a peer that this link does not lead to.
    #[error("a datagram from a peer that this link does not lead to")]
    Stranger,
    /// It is for another peer.
    #[error("a datagram for another peer")]
    NotForUs,
    /// A greeting that is about another client of the same server.
    #[error("a greeting on another line: it is about another client of the same server")]
    OtherLine,
    /// A greeting that was altered on the way, or made by someone without the key.
    #[error("the tag of a greeting is wrong: altered, or another shared key")]
    ForgedGreeting,
    /// A greeting that answers a challenge that this peer no longer has.
    #[error("a greeting that answers a challenge of the past")]
    Stale,
    /// A greeting that would cost a multiplication so soon after another.
    #[error("a greeting with another ephemeral too soon after the last")]
    Hurried,
    /// A greeting whose ephemeral is one of the few that lead to no secret.
    #[error("a greeting with an ephemeral that leads to no secret")]
    WeakEphemeral,
    /// The other peer has other parameters in this table, the first that differs.
    #[error("the other peer has other parameters: {0}")]
    Parameters(&'static str),
    /// It is sealed, and there is no session that could open it.
    #[error("a sealed datagram, and no session to open it")]
    NoSession,
    /// It belongs to another session: an earlier one, or none that this peer knows.
    #[error("this datagram belongs to another session")]
    OtherSession,
    /// It could be this old, µs: the other end had not heard from this one for so long when it sealed it, the way included.
    #[error("this datagram may be {0} µs old")]
    Old(u64),
    /// What it says of this is more than the limits of this end's scene let anybody do.
    #[error("its {0} is more than the limits in [safety] allow")]
    Impossible(&'static str),
    /// Its sequence number has been taken before.
    #[error("this datagram was taken before")]
    Replayed,
    /// Its sequence number is older than the window remembers.
    #[error("this datagram is older than the replay window")]
    TooOld,
    /// Its sequence number is beyond the last one allowed.
    #[error("the sequence number is beyond the last one allowed")]
    BeyondLast,
    /// It was altered on the way, is from another session, or was sealed by someone without the key.
    #[error("the tag of a sealed datagram is wrong")]
    Forged,
    /// Every sequence number of this peer has been used.
    #[error("every sequence number has been used: restart this peer")]
    Exhausted,
}
