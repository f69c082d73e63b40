//! Worlds: what a server of a static environment holds, from a TOML file to the database that travels.
//!
//! ```toml
//! version = 1
//! margin_m = 0.1          # how far beyond its region a server knows
//!
//! [[region]]              # none: one server holds everything
//! server = 1
//! from_x_m = -1.0
//! from_y_m = -1.0
//! to_x_m = 0.0
//! to_y_m = 1.0
//!
//! [[wall]]                # also [[body]], [[strip]] and [[block]]
//! id = 1
//! from_x_m = -0.5
//! # …
//! ```
//!
//! [`host`] is a server that holds one, [`visitor`] a client of one or several servers, both without sockets and clocks, so that the
//! same lines run in simulated time and over UDP.
//!
//! Every key but `id` has a default; `cohold shared world show --keys` lists them. What is wrong is one error that names file and line, object,
//! key, value and what is allowed.

mod file;
pub mod host;
mod parameters;
pub mod picture;
pub mod render;
mod solid;
pub mod springs;
pub mod stroke;
pub mod visitor;

pub use file::own_keys;
pub use file::{load, parse};
pub use parameters::{CLIENT, CONTROL_PERIOD_S, PACKET_US, TICKS_PER_PACKET, line_of, look_around, open_link};
pub use parameters::{OBJECTS, World};
pub use solid::corners;
