//! Peers in real time: the runner of live actors, and restarts in virtual time.

mod bridge;
mod endpoint;
mod fuzz;
mod invitation;
mod mapping;
mod restarts;
mod two_homes;
mod world;
