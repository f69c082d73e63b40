//! What tries servers of a world: very many clients.

pub mod beside;
pub mod crowd;
pub mod load;
