//! Static: a world that clients download, whole or around where they are, and feel from what they have (architectures
//! paper §3.1).
//!
//! Information about the world flows from server to client only, and the client drives it: it asks for what it lacks,
//! and again for what has not come, so a server remembers nothing about anybody's download. That makes it resumable by
//! itself: after a broken session, another server or another version of the world, only what is missing or has changed is
//! asked for. Nobody waits: forces come from what is there, whatever the network does.

mod board;
mod download;
mod roam;
mod server;

pub use board::Board;
pub use download::{Download, Taken};
pub use roam::Roam;
pub use server::{BURST, Server};
