//! What only the crate itself can see: known answers of its keys and seals, and the degradation by silence and
//! reliable events without a link.

mod engagement;
mod parameters;
mod reliable;
mod vectors;
