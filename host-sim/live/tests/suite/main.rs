//! Peers in real time: the runner of live actors, a flood, and restarts in virtual time.

mod endpoint;
mod flood;
mod fuzz;
mod key_file;
mod node;
mod restarts;
