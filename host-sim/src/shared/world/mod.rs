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
//! Every key but `id` has a default; `host-sim world` lists them. What is wrong is one error that names file and line, object,
//! key, value and what is allowed.

mod file;
pub mod host;
pub mod picture;
pub mod render;
pub mod solid;
pub mod stroke;
pub mod visitor;

use haptic_protocol::parameters::{Parameters, Table};

pub use file::{OWN_KEYS, WorldError, load, parse};

/// Most objects in a world file.
pub const OBJECTS: usize = 1024;

/// A world as a server holds it.
pub type World = haptic_protocol::world::Database<OBJECTS>;

/// How often local rendering computes a force, s: contact with a strip is stable or not by this period.
pub const CONTROL_PERIOD_S: f64 = 0.001;

/// Packet period of every link, µs: 125 Hz.
pub const PACKET_US: u64 = 8_000;
/// Control periods in a packet period.
pub const TICKS_PER_PACKET: u32 = 8;
/// The peer number of every client.
pub const CLIENT: u8 = 0;

/// What both ends must have been told alike.
pub fn parameters() -> Parameters {
    let mut parameters = Parameters::new();
    // One table of the 16 that there is room for.
    let _ = parameters.add(Table::new("static").number("packet_period_s", 1e-6 * PACKET_US as f64));
    parameters
}
