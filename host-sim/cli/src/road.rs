//! Flags by which `peer` and `play` meet the other end, which they do not call at an address.

use std::fmt::Debug;
use std::path::Path;
use std::sync::Arc;

use cohold_live::endpoint::Stop;
use cohold_live::road::Roads;
use cohold_protocol::key::Key;

use super::{Failure, Ui};

/// A peer's side of a meeting: its number, the key, and the road.
#[derive(Debug)]
pub struct Met {
    /// 1 (left) or 2 (right).
    pub number: u8,
    /// The same at both ends.
    pub key: Key,
    /// To the other end.
    pub road: Arc<dyn Roads>,
    /// Six digits that both ends of a link show.
    pub code: Option<String>,
}

/// What these flags say.
pub trait Meets: Debug + Send + Sync {
    /// Whether the other end is met, and not called.
    fn is_given(&self) -> bool;

    /// Comes to a key, where there is none yet, and to a road. None where nobody is to be met. `own` is a key file and a peer's number.
    ///
    /// # Errors
    /// The flags do not go together, or nobody came.
    fn agree(&self, ui: &Ui, stop: &Stop, own: Option<(&Path, u8)>) -> Result<Option<Met>, Failure>;
}

/// Nobody is met.
#[derive(Debug)]
pub(crate) struct Nobody;

impl Meets for Nobody {
    fn is_given(&self) -> bool {
        false
    }

    fn agree(&self, _: &Ui, _: &Stop, _: Option<(&Path, u8)>) -> Result<Option<Met>, Failure> {
        Ok(None)
    }
}
