//! The network between peers: what becomes of each packet, and what is on its way.

pub mod link;
pub mod rule;
pub mod trace;
