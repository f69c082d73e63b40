//! Datagrams in batches: one system call for as many as have come, and one for as many as are to go.
//!
//! On Linux these are `recvmmsg` and `sendmmsg`; elsewhere datagrams come and go one by one, behind the same names. Nobody waits
//! for a batch to fill: what is there is taken, and what was said is sent when its sender says so.

use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

/// Most datagrams of one system call: few enough that the first of them is not held up by the last.
pub const MOST: usize = if cfg!(target_os = "linux") { 32 } else { 1 };
/// Room for a datagram, bytes; of a longer one the rest is lost.
const ROOM: usize = 2048;
/// Nothing waits longer in a socket that is looked at.
#[cfg(target_os = "linux")]
const MOST_WAITED: Duration = Duration::from_secs(1);

/// What came with one system call.
pub struct ReceivedBatch {
    room: Box<[[u8; ROOM]; MOST]>,
    /// Where each came from, and its length.
    from: Vec<(SocketAddr, usize)>,
    /// How long each had waited in the socket when it was taken, oldest first; 0 where the system does not tell
    /// ([`super::endpoint::Endpoint`] asks for it).
    pub waited: Vec<Duration>,
    #[cfg(target_os = "linux")]
    headers: nix::sys::socket::MultiHeaders<nix::sys::socket::SockaddrStorage>,
}

impl Default for ReceivedBatch {
    fn default() -> Self {
        Self {
            room: Box::new([[0; ROOM]; MOST]),
            from: Vec::with_capacity(MOST),
            waited: Vec::with_capacity(MOST),
            #[cfg(target_os = "linux")]
            headers: nix::sys::socket::MultiHeaders::preallocate(
                MOST,
                Some(nix::cmsg_space!(nix::sys::time::TimeSpec)),
            ),
        }
    }
}

impl ReceivedBatch {
    /// Takes what has come, up to a batch of it; with nothing there, waits as long as the socket's timeout says.
    #[cfg(target_os = "linux")]
    pub(super) fn take(&mut self, socket: &UdpSocket) -> io::Result<()> {
        use nix::sys::socket::{ControlMessageOwned, MsgFlags, SockaddrStorage, recvmmsg};
        use std::time::{SystemTime, UNIX_EPOCH};
        use std::{io::IoSliceMut, os::fd::AsRawFd};

        self.clear();
        let address = |at: SockaddrStorage| {
            let v4 = at.as_sockaddr_in().map(|at| SocketAddr::V4((*at).into()));
            v4.or_else(|| at.as_sockaddr_in6().map(|at| SocketAddr::V6((*at).into())))
        };
        let mut room = self.room.each_mut().map(|room| [IoSliceMut::new(room)]);
        // It waits for the first only.
        let flags = MsgFlags::MSG_WAITFORONE;
        let came = recvmmsg(socket.as_raw_fd(), &mut self.headers, room.iter_mut(), flags, None)?;
        // Both families of UDP give an address with each.
        let nowhere = SocketAddr::from(([0, 0, 0, 0], 0));
        // Both clocks are the system's; one that was set meanwhile gives nothing that is believed.
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        for came in came {
            self.from.push((came.address.and_then(address).unwrap_or(nowhere), came.bytes.min(ROOM)));
            let at = came.cmsgs().ok().and_then(|mut control| {
                control.find_map(
                    |control| if let ControlMessageOwned::ScmTimestampns(at) = control { Some(at) } else { None },
                )
            });
            let waited = at.and_then(|at| now.checked_sub(at.into())).filter(|waited| *waited < MOST_WAITED);
            self.waited.push(waited.unwrap_or_default());
        }
        Ok(())
    }

    /// Takes what has come first; with nothing there, waits as long as the socket's timeout says.
    #[cfg(not(target_os = "linux"))]
    pub(super) fn take(&mut self, socket: &UdpSocket) -> io::Result<()> {
        self.clear();
        let (length, from) = socket.recv_from(&mut self.room[0])?;
        self.from.push((from, length));
        self.waited.push(Duration::ZERO);
        Ok(())
    }

    pub(super) fn clear(&mut self) {
        self.from.clear();
        self.waited.clear();
    }

    /// Leaves what somebody who looks at each, and at how long it has waited, says is to stay, and where he says that it came from.
    pub fn sift(&mut self, mut stays: impl FnMut(SocketAddr, &[u8], Duration) -> Option<SocketAddr>) {
        let mut kept = 0;
        for at in 0..self.from.len() {
            let (from, length) = self.from[at];
            if let Some(from) = stays(from, &self.room[at][..length], self.waited[at]) {
                self.room.swap(kept, at);
                self.waited.swap(kept, at);
                self.from[kept] = (from, length);
                kept += 1;
            }
        }
        self.from.truncate(kept);
        self.waited.truncate(kept);
    }

    /// Whether one more can be added.
    pub fn has_room(&self) -> bool {
        self.from.len() < MOST
    }

    /// Adds what came before and was kept, as far as there is room.
    pub fn add(&mut self, from: SocketAddr, datagram: &[u8]) {
        if let Some(room) = self.room.get_mut(self.from.len()) {
            let length = datagram.len().min(ROOM);
            room[..length].copy_from_slice(&datagram[..length]);
            self.from.push((from, length));
            self.waited.push(Duration::ZERO);
        }
    }

    /// What came, oldest first, and where from.
    pub fn each(&mut self) -> impl ExactSizeIterator<Item = (SocketAddr, &mut [u8])> {
        self.from.iter().zip(self.room.iter_mut()).map(|((from, length), room)| (*from, &mut room[..*length]))
    }
}

/// Datagrams that go out with one system call.
#[derive(Debug, Default)]
pub struct OutgoingBatch {
    bytes: Vec<u8>,
    /// Where each is to go, and where it ends.
    to: Vec<(SocketAddr, usize)>,
}

impl OutgoingBatch {
    pub(super) fn add(&mut self, to: SocketAddr, datagram: &[u8]) {
        self.bytes.extend_from_slice(datagram);
        self.to.push((to, self.bytes.len()));
    }

    pub(super) fn is_full(&self) -> bool {
        self.to.len() >= MOST
    }

    fn each(&self) -> impl ExactSizeIterator<Item = (SocketAddr, &[u8])> {
        let begins = |at: usize| at.checked_sub(1).map_or(0, |before| self.to[before].1);
        self.to.iter().enumerate().map(move |(at, (to, end))| (*to, &self.bytes[begins(at)..*end]))
    }

    /// Hands all of it to the system, in order; how many it did not take.
    pub(super) fn send(&mut self, socket: &UdpSocket) -> u64 {
        let unsent = if self.to.len() < 2 { self.one_by_one(socket) } else { self.at_once(socket) };
        self.bytes.clear();
        self.to.clear();
        unsent
    }

    fn one_by_one(&self, socket: &UdpSocket) -> u64 {
        self.each().filter(|(to, datagram)| socket.send_to(datagram, to).is_err()).count() as u64
    }

    #[cfg(target_os = "linux")]
    fn at_once(&self, socket: &UdpSocket) -> u64 {
        use rustix::net::addr::SocketAddrArg;
        use rustix::net::{MMsgHdr, SendAncillaryBuffer, SendFlags, sendmmsg};
        use std::io::IoSlice;

        let parts: Vec<_> = self.each().map(|(to, datagram)| (to.as_any(), [IoSlice::new(datagram)])).collect();
        let mut nothing: Vec<_> = parts.iter().map(|_| SendAncillaryBuffer::default()).collect();
        let messages = parts.iter().zip(&mut nothing);
        let mut messages: Vec<_> =
            messages.map(|((to, part), nothing)| MMsgHdr::new_with_addr(to, part, nothing)).collect();
        let (mut unsent, mut rest) = (0, &mut messages[..]);
        while !rest.is_empty() {
            // An error is about the first of the rest.
            let done = sendmmsg(socket, rest, SendFlags::empty()).unwrap_or_default();
            unsent += u64::from(done == 0);
            rest = &mut rest[done.max(1)..];
        }
        unsent
    }

    #[cfg(not(target_os = "linux"))]
    fn at_once(&self, socket: &UdpSocket) -> u64 {
        self.one_by_one(socket)
    }
}

#[cfg(test)]
#[path = "../tests/inside/batch.rs"]
mod tests;
