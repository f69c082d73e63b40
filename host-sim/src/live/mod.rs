//! Peers in real time, over real sockets.
//!
//! | module | holds |
//! |---|---|
//! | [`key_file`] | the shared key, readable by its owner only |
//! | [`pace`] | a 1 kHz beat from the operating system, with its misses counted |
//! | [`peer`] | one peer: the same tick and exchange, a simulated device, a sealed link |
//! | [`serve`] | a server of a static world |
//! | [`visit`] | a client of one or several servers |
//! | [`crowd`] | very many clients at one server, to see where it bends |
//! | [`histogram`] | quantiles of times |
//! | [`relay`] | a bad network between two peers |

pub mod crowd;
pub mod histogram;
pub mod key_file;
pub mod pace;
pub mod peer;
pub mod relay;
pub mod serve;
pub mod visit;
