//! Peers in real time: the runner of live actors, a flood, and restarts in virtual time.

mod bridge;
mod endpoint;
mod flood;
mod fuzz;
mod invitation;
mod key_file;
mod mapping;
mod node;
mod restarts;
mod two_homes;
mod world;
