//! What the hand feels, against closed forms: impacts, and impacts of a peer.

mod felt;
mod gas;
mod impact;
mod peer;
pub(crate) mod setup;
