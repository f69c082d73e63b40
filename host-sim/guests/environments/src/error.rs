//! Why a shared environment was not made, or ended.

use cohold_core::settings::Refused;
use cohold_protocol::link::ConfigError;

use crate::cooperative::MOST_USERS;
use crate::roles::cooperative::OutOfRange;

/// Why a shared environment was not made, or an end of it ended: one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Too few or too many users.
    #[error("users = {0} is not allowed: it must be a whole number from 1 to {MOST_USERS}")]
    Users(usize),
    /// What the peers refuse.
    #[error(transparent)]
    Setting(#[from] Refused<'static>),
    /// What the hand-over refuses.
    #[error(transparent)]
    Lease(#[from] OutOfRange),
    /// The engine cannot move to a client that computes no contact.
    #[error(
        "the engine must be at the server where contact is computed there: a client that computes no contact cannot \
         move the object"
    )]
    NoContact,
    /// The node is lossless only for waves that come when they are due.
    #[error(
        "network: through the node every wave must arrive, after a constant delay: leave jitter, loss and all else at \
         0, or set coordination.ledger = true, which pays for waves that are held"
    )]
    NotConstant,
    /// There are no waves to scatter.
    #[error("coordination.comm = \"{0}\" is not allowed: a node scatters waves, so it must be a law that sends them")]
    NoWaves(&'static str),
    /// A link that cannot be made.
    #[error(transparent)]
    Link(#[from] ConfigError),
    /// A world that cannot be told apart from others.
    #[error(transparent)]
    Wire(#[from] cohold_protocol::wire::Error),
    /// A scene, a file or a value that is not allowed.
    #[error(transparent)]
    Sim(#[from] cohold_sim::Error),
    /// An analysis that could not be made.
    #[error(transparent)]
    Analysis(#[from] cohold_analysis::Error),
    /// An end in real time.
    #[error(transparent)]
    Live(#[from] cohold_live::Error),
    /// Anything else, in a sentence.
    #[error("{0}")]
    Refused(String),
}

cohold_sim::sentences_are_refusals!(Error);
