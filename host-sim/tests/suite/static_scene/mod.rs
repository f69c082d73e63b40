//! A static environment: world files, local rendering, clients and servers over a simulated bad network, and as processes.

mod host;
mod network;
mod processes;
mod render;
mod sim;
mod stroke;
mod world_file;

pub(crate) use world_file::TWO_ROOMS;
