//! A UDP socket that is polled, and emptied in bounded time.

use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::time::Instant;

/// A socket that is polled.
///
/// # Errors
/// It cannot be opened, in one line.
pub(crate) fn open(listen: SocketAddr) -> Result<UdpSocket, String> {
    let socket = UdpSocket::bind(listen).map_err(|cause| format!("cannot listen on {listen}: {cause}"))?;
    socket.set_nonblocking(true).map_err(|cause| format!("cannot poll the socket: {cause}"))?;
    Ok(socket)
}

/// Takes what has come until there is nothing left or it is `until`, oldest first.
pub(crate) fn drain(socket: &UdpSocket, until: Instant, mut each: impl FnMut(SocketAddr, &mut [u8])) {
    let mut came = [0; 2048];
    // An error other than "nothing there" is about one datagram, or about one that was sent: the next may be good.
    while Instant::now() < until {
        match socket.recv_from(&mut came) {
            Ok((len, from)) => each(from, &mut came[..len]),
            Err(cause) if cause.kind() == ErrorKind::WouldBlock => break,
            Err(_) => {}
        }
    }
}
