//! What the hand feels, against closed forms: impacts, impacts of a peer, shapes.

mod felt;
mod gas;
mod impact;
mod peer;
pub(crate) mod setup;
mod shape;
