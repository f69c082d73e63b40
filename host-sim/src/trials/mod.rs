//! What tries peers and servers: forged datagrams, restarts, very many clients.

pub(crate) mod beside;
pub(crate) mod crowd;
pub(crate) mod flood;
pub(crate) mod load;
pub mod restarts;
