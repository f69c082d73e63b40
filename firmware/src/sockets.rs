//! UDP sockets that never wait for somebody who is not there.

use core::{future::poll_fn, task::Poll};

use embassy_futures::poll_once;
use embassy_net::udp::{PacketMetadata, UdpSocket};
use embassy_net::{IpEndpoint, Stack};
use embassy_time::{Duration, Instant};
use firmware_parts::image::SHARED;
use static_cell::ConstStaticCell;

/// Memory for datagrams that wait, those that came in and those that go out. Apart from each other: bytes begin as zeros and
/// take no room in the image, headers do not.
macro_rules! buffers {
    () => {{
        // Records of several shared axes come several a tick.
        const SHARE: usize = if SHARED > 1 { 3 } else { 1 };
        static HEADERS: ConstStaticCell<[[PacketMetadata; 8 * SHARE]; 2]> =
            ConstStaticCell::new([[PacketMetadata::EMPTY; 8 * SHARE]; 2]);
        static BYTES: ConstStaticCell<[[u8; 1024 * SHARE]; 2]> = ConstStaticCell::new([[0; 1024 * SHARE]; 2]);
        (HEADERS.take(), BYTES.take())
    }};
}

/// The socket of the flow, which receives and sends.
pub(crate) fn socket(stack: Stack<'static>, port: u16) -> UdpSocket<'static> {
    let ([rx_headers, tx_headers], [rx, tx]) = buffers!();
    bound(UdpSocket::new(stack, rx_headers, rx, tx_headers, tx), port)
}

/// The sockets of the operator's port, one that receives and one that sends: dropping answers that nobody takes must not
/// drop orders that came in.
pub(crate) fn pair(stack: Stack<'static>, port: u16) -> (UdpSocket<'static>, Sender) {
    let ([rx_headers, tx_headers], [rx, tx]) = buffers!();
    let receiving = bound(UdpSocket::new(stack, rx_headers, rx, &mut [], &mut []), port);
    let sending = bound(UdpSocket::new(stack, &mut [], &mut [], tx_headers, tx), port);
    (receiving, Sender { socket: sending, port, waiting_since: None })
}

/// The socket on its port. What comes in for a port goes to the socket that was bound to it first.
fn bound(mut socket: UdpSocket<'static>, port: u16) -> UdpSocket<'static> {
    bind(&mut socket, port);
    socket
}

fn bind(socket: &mut UdpSocket<'_>, port: u16) {
    if socket.bind(port).is_err() {
        defmt::panic!("port {=u16} cannot be bound", port);
    }
}

/// Hands a datagram to the stack if it takes it now.
pub(crate) async fn send_now(socket: &UdpSocket<'_>, bytes: &[u8], to: IpEndpoint) -> bool {
    poll_fn(|cx| Poll::Ready(matches!(socket.poll_send_to(bytes, to, cx), Poll::Ready(Ok(()))))).await
}

/// A socket that only sends, to whoever asks.
///
/// The stack sends a socket's datagrams in order, and keeps one whose receiver does not answer ARP for ever: a single
/// stranger would silence the port. So what has waited for [`Sender::PATIENCE`] is thrown away, with all behind it.
///
/// Limit: after it looked for a stranger in vain the stack keeps the socket silent for up to a second.
pub(crate) struct Sender {
    socket: UdpSocket<'static>,
    port: u16,
    waiting_since: Option<Instant>,
}

impl Sender {
    const PATIENCE: Duration = Duration::from_millis(50);

    /// Throws away what has waited too long; call now and then.
    pub(crate) fn tend(&mut self) {
        if poll_once(self.socket.flush()).is_ready() {
            self.waiting_since = None;
        } else if self.waiting_since.get_or_insert_with(Instant::now).elapsed() > Self::PATIENCE {
            self.socket.close();
            bind(&mut self.socket, self.port);
            self.waiting_since = None;
        }
    }

    /// Hands a datagram to the stack if it takes it now.
    pub(crate) async fn send(&mut self, bytes: &[u8], to: IpEndpoint) -> bool {
        self.tend();
        send_now(&self.socket, bytes, to).await
    }
}
