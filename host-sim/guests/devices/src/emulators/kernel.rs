//! The buses whose messages are the kernel's frames: a Unix socket and a CAN interface. Both need Linux.
//!
//! Elsewhere no adapter opens either of them, and macOS lacks three things that this relies on. Its Unix sockets have no SOCK_SEQPACKET.
//! It opens no socket with CLOEXEC, so a child could inherit one and keep it open. It sends nothing with NOSIGNAL, so a client that has
//! gone would raise SIGPIPE, which ends a process that does not ignore it.

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::fs::FileTypeExt as _;
use std::path::Path;
use std::sync::{Arc, Mutex};

use rustix::net::{
    AddressFamily, RecvFlags, SendFlags, SocketAddrUnix, SocketFlags, SocketType, accept_with, bind, connect, listen,
    recv, send, socket_with,
};

use super::carrier::{LATE, Served, clear};
use super::{locked, motors::Fault, motors::World};

/// Flag of an identifier of 29 bits, and the identifiers' bits.
const EXTENDED: u32 = 1 << 31;
const ID: u32 = (1 << 29) - 1;
/// Largest identifier of 11 bits.
const STANDARD: u32 = 0x7ff;
/// Bytes of a frame with flexible data rate, and where the data of either kind begins.
const FD_LEN: usize = 72;
const DATA: usize = 8;

fn seqpacket() -> io::Result<OwnedFd> {
    Ok(socket_with(AddressFamily::UNIX, SocketType::SEQPACKET, SocketFlags::CLOEXEC, None)?)
}

pub(crate) fn socket(
    at: &Path,
    world: Arc<Mutex<World>>,
    mut answers: impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)> + Send + 'static,
) -> io::Result<Served> {
    let address = SocketAddrUnix::new(at)?;
    let (listener, probe) = (seqpacket()?, seqpacket()?);
    clear(at, |at| {
        at.metadata().is_ok_and(|file| file.file_type().is_socket())
            && connect(&probe, &address) == Err(rustix::io::Errno::CONNREFUSED)
    })?;
    bind(&listener, &address).and_then(|()| listen(&listener, 4))?;
    std::thread::spawn(move || {
        while let Ok(client) = accept_with(&listener, SocketFlags::CLOEXEC) {
            serve_messages(&client, &world, &mut answers);
        }
    });
    Ok(Served { at: at.to_owned(), made: Some(at.to_owned()) })
}

pub(crate) fn interface(
    name: &str,
    world: Arc<Mutex<World>>,
    mut answers: impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)> + Send + 'static,
) -> io::Result<Served> {
    use socketcan::Socket as _;
    let bus = socketcan::CanFdSocket::open(name)?;
    std::thread::spawn(move || {
        // Who unplugs a bus that others are on only hears and says nothing more.
        loop {
            serve_messages(&bus, &world, &mut answers);
            std::thread::sleep(LATE);
        }
    });
    Ok(Served { at: name.into(), made: None })
}

/// Until the client has gone, or the bus.
fn serve_messages(
    client: impl AsFd,
    world: &Mutex<World>,
    answers: &mut impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)>,
) {
    let mut message = [0; FD_LEN];
    while let Ok((_, len)) = recv(&client, &mut message, RecvFlags::empty()) {
        let fault = locked(world).fault;
        if len == 0 || fault == Fault::Unplugged {
            return;
        }
        let id = u32::from_ne_bytes([message[0], message[1], message[2], message[3]]);
        if fault == Fault::Flexible && len != FD_LEN {
            continue;
        }
        let Some(data) = message.get(DATA..DATA + usize::from(message[4])) else { continue };
        let reply = answers(id & ID, data);
        if fault == Fault::Late {
            std::thread::sleep(LATE);
        }
        let Some((to, data)) = reply.filter(|_| fault != Fault::Silent) else { continue };
        let mut answer = [0; FD_LEN];
        answer[..4].copy_from_slice(&(to | if to > STANDARD { EXTENDED } else { 0 }).to_ne_bytes());
        answer[4] = data.len() as u8;
        answer[DATA..DATA + data.len()].copy_from_slice(&data);
        // As long as the question's: of both kinds there is one length.
        let _ = send(&client, &answer[..len], SendFlags::NOSIGNAL);
    }
}
