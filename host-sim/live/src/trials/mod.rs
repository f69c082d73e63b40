//! What tries peers: forged datagrams, restarts.

pub mod flood;
pub mod restarts;
