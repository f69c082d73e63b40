//! A static environment: servers that hold a world and clients that visit it, without sockets and clocks, so that the same
//! lines run in simulated time and over UDP.
//!
//! | module | holds |
//! |---|---|
//! | [`host`] | a server: one sealed link for each client, answers at once |
//! | [`visitor`] | a client: links to one or several servers, what it knows, and the force from it |

pub mod host;
pub mod visitor;

/// Packet period of every link, µs: 125 Hz.
pub const PACKET_US: u64 = 8_000;
/// Control periods in a packet period.
pub const TICKS_PER_PACKET: u32 = 8;
/// The peer number of every client.
pub const CLIENT: u8 = 0;

/// What both ends must have been told alike.
///
/// # Panics
/// Never: there is room for one table.
pub fn parameters() -> haptic_protocol::parameters::Parameters {
    use haptic_protocol::parameters::{Parameters, Table};
    let mut parameters = Parameters::new();
    // One table of the 16 that there is room for.
    let _ = parameters.add(Table::new("static").number("packet_period_s", 1e-6 * PACKET_US as f64));
    parameters
}
