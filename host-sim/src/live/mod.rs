//! Peers in real time, over real sockets.
//!
//! | module | holds |
//! |---|---|
//! | [`court`] | a game of squash: its server, or one of its players |
//! | [`flood`] | forged datagrams by the hundred thousand against two nodes |
//! | [`flows`] | flow on its way between the wire and the core |
//! | [`hub`] | where 2 to 16 peers hold one object |
//! | [`key_file`] | the shared key, readable by its owner only |
//! | [`meet`] | a hub in real time on a UDP socket |
//! | [`node`] | one peer on a wire: the tick and exchange that fly, a simulated device, a sealed link |
//! | [`operator`] | a person's end of a board's command port |
//! | [`pace`] | a 1 kHz beat from the operating system, with its misses counted |
//! | [`peer`] | a node in real time on a UDP socket |
//! | [`serve`] | a server of a static world |
//! | [`visit`] | a client of one or several servers |
//! | [`crowd`] | very many clients at one server, to see where it bends |
//! | [`histogram`] | quantiles of times |
//! | [`post`] | the links of a game of squash, and who was there |
//! | [`recording`] | what a board's ticks did, as a table |
//! | [`relay`] | a bad network between two peers |
//! | [`restarts`] | two nodes in virtual time, one or the other restarting |
//! | `socket` | a UDP socket that is polled |

pub mod court;
pub mod crowd;
pub mod flood;
pub mod flows;
pub mod histogram;
pub mod hub;
pub mod key_file;
pub mod meet;
pub mod node;
pub mod operator;
pub mod pace;
pub mod peer;
pub mod post;
pub mod recording;
pub mod relay;
pub mod restarts;
pub mod serve;
mod socket;
pub mod visit;
