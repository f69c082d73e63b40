//! Parameters of every world: how much it holds, its periods, and what both ends must have been told alike.

use haptic_protocol::parameters::{Parameters, Table};

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
