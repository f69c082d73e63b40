//! What tries peers and servers: forged datagrams, restarts, very many clients.

pub mod crowd;
pub mod flood;
pub mod restarts;
