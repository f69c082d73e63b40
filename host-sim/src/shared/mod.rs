//! The architectures paper's shared environments (Buttolo, Oboe & Hannaford 1997).

pub mod collaborative;
pub mod cooperative;
pub mod squash;
pub mod visit;
pub mod world;
