//! Peers in real time, over real sockets.
//!
//! | module | holds |
//! |---|---|
//! | [`court`] | a game of squash: its server, or one of its players |
//! | [`hub`] | where 2 to 16 peers hold one object |
//! | [`meet`] | a hub in real time on a UDP socket |
//! | [`pace`] | a 1 kHz beat from the operating system, with its misses counted |
//! | [`peer`] | a node in real time on a UDP socket |
//! | [`serve`] | a server of a static world |
//! | [`visit`] | a client of one or several servers |
//! | [`histogram`] | quantiles of times |
//! | [`post`] | the links of a game of squash, and who was there |
//! | [`relay`] | a bad network between two peers |
//! | `socket` | a UDP socket that is polled |

pub mod court;
pub mod histogram;
pub mod hub;
pub mod meet;
pub mod pace;
pub mod peer;
pub mod post;
pub mod relay;
pub mod serve;
pub(crate) mod socket;
pub mod visit;
