//! What only the crate itself can see: known answers of its keys and seals, and reliable events without a link.

mod reliable;
mod vectors;
