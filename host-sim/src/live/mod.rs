//! Peers in real time, over real sockets.
//!
//! | module | holds |
//! |---|---|
//! | [`key_file`] | the shared key, readable by its owner only |
//! | [`operator`] | a person's end of a board's command port |
//! | [`pace`] | a 1 kHz beat from the operating system, with its misses counted |
//! | [`peer`] | one peer: the same tick and exchange, a simulated device, a sealed link |
//! | [`relay`] | a bad network between two peers |

pub mod key_file;
pub mod operator;
pub mod pace;
pub mod peer;
pub mod relay;
