//! What every world has: how much it holds, its periods, the links over which it is sent.

use cohold_protocol::link::{Config, Error, Link};
use cohold_protocol::parameters::{Parameters, Table};
use cohold_protocol::wire::{Greeting, Header, PeerId};
use cohold_protocol::{ends::Ends, key::Key};

use crate::{records::Scope, roles::static_scene::Download};

/// Most objects in a world file.
pub const OBJECTS: usize = 1024;

/// A world as a server holds it.
pub type World = crate::records::Database<OBJECTS>;

/// How often local rendering computes a force, s: contact with a strip is stable or not by this period.
pub const CONTROL_PERIOD_S: f64 = 0.001;
/// Packet period of every link, µs: 125 Hz.
pub const PACKET_US: u64 = 8_000;
/// Control periods in a packet period.
pub const TICKS_PER_PACKET: u32 = 8;
/// The peer number of every client.
pub const CLIENT: u8 = 0;

/// The link from the first of two peer numbers to the second; both ends must have the same packet period.
pub fn open_link(key: Key, [local, remote]: [u8; 2], entropy: [u8; Key::LEN]) -> Result<Link, crate::Error> {
    let mut parameters = Parameters::new();
    // One table of the 16 that there is room for.
    let _ = parameters.add(Table::new("static").number("packet_period_s", 1e-6 * PACKET_US as f64));
    let ends = Ends { local: PeerId(local), remote: PeerId(remote) };
    let config = Config { key, ends, packet_period_us: PACKET_US as u32, parameters, entropy };
    Ok(Link::new(config)?)
}

/// The line that a greeting names, or that a sealed datagram's session is of.
pub fn line_of(datagram: &mut [u8], of_session: impl FnOnce(u32) -> Option<u32>) -> Result<u32, Error> {
    if datagram.get(1).is_some_and(|kind| Greeting::is_kind(*kind)) {
        return Ok(Greeting::parse(datagram)?.0.line);
    }
    of_session(Header::parse(datagram)?.0.session).ok_or(Error::NoSession)
}

/// Asks for what is within `radius` around here, anew when a quarter of that has been crossed, m.
pub fn look_around<const N: usize>(download: &mut Download<N>, [x, y]: [f32; 2], radius: f32) {
    let near = matches!(download.scope(), Scope::Around { x: at_x, y: at_y, .. } if (x - at_x).hypot(y - at_y) <= 0.25 * radius);
    if !near {
        download.look(Scope::Around { x, y, radius });
    }
}
