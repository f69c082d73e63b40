//! What tries peers: forged datagrams.

pub mod flood;
