//! Ends of the shared environments in real time, each an actor on the one loop of [`cohold_live::endpoint`].

mod copies;
pub mod hub;
mod hub_watch;
mod links;
pub mod serve;
pub mod squash;
pub mod visit;
