//! What tries peers and servers: forged datagrams, restarts, very many clients.

pub(crate) mod crowd;
pub(crate) mod flood;
pub mod restarts;
