//! What the hand feels: the contact between the device and the local copy of the shared object.

pub mod contact;

pub use contact::{Contact, Side};
