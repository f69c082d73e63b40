//! The network between peers: what becomes of each packet, and what is on its way.
//!
//! | module | holds |
//! |---|---|
//! | [`rule`] | what becomes of each packet: seeded from the scene, read from a trace, or any closure |
//! | [`trace`] | the same written down, in a file |
//! | [`link`] | one way of a network, and which of what has come the receiver takes |

pub mod link;
pub mod rule;
pub mod trace;
