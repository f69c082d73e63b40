//! Addresses on loopback for processes that are told where to listen.

use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicU16, Ordering};

/// Ports that a system gives out by itself begin here (Linux from 32768, IANA from 49152): one that was free a moment ago may be anybody's by now.
const GIVEN_OUT: u16 = 32_768;
const FIRST: u16 = 12_288;

/// An address on loopback that nobody listens on, that no system gives out by itself, and that this program has not named before.
pub(crate) fn free() -> SocketAddr {
    static NAMED: AtomicU16 = AtomicU16::new(0);
    let ports = u32::from(GIVEN_OUT - FIRST);
    // Programs that run beside each other begin far apart.
    let begin = std::process::id().wrapping_mul(619) % ports;
    (0..ports)
        .map(|_| begin + u32::from(NAMED.fetch_add(1, Ordering::Relaxed)))
        .filter_map(|at| u16::try_from(at % ports).ok())
        .map(|at| SocketAddr::from(([127, 0, 0, 1], FIRST + at)))
        .find(|address| UdpSocket::bind(address).is_ok())
        .expect("a free port")
}
