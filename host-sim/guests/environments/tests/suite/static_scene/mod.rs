//! A static environment: world files, local rendering, clients and servers over a simulated bad network.

mod host;
mod network;
mod render;
mod sim;
mod springs;
mod stroke;
mod world_file;
