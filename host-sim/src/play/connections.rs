//! Who is connected: a bounded number of each kind, of which the newest is always let in.
//!
//! Connections that have shown no key are one kind, windows with the same rights another. Where a kind is full, the one that has
//! been silent longest is closed: whoever says nothing keeps nobody out, and whoever has no key takes no place from one who has.

use std::net::{Shutdown, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::roles::Rights;

/// Connections at a time that have shown no key.
pub(super) const MOST_WITHOUT_KEY: usize = 64;
/// Windows at a time with the same rights.
pub(super) const MOST_ALIKE: usize = 16;

/// Everybody who is connected.
#[derive(Debug, Default)]
pub(super) struct Connections(Mutex<Vec<Connection>>);

#[derive(Debug)]
struct Connection {
    number: u64,
    /// None before it has shown a key.
    rights: Option<Rights>,
    heard: Instant,
    stream: TcpStream,
}

/// A place among the connections, until it is dropped.
#[derive(Debug)]
pub(super) struct Pass {
    connections: Arc<Connections>,
    number: u64,
}

impl Connections {
    fn lock(&self) -> MutexGuard<'_, Vec<Connection>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets a connection in that has shown no key, whose number is greater than any before; an error where it is gone already.
    pub(super) fn admit(self: &Arc<Self>, number: u64, stream: &TcpStream) -> std::io::Result<Pass> {
        let mut all = self.lock();
        all.push(Connection { number, rights: None, heard: Instant::now(), stream: stream.try_clone()? });
        make_room(&mut all, None, MOST_WITHOUT_KEY);
        Ok(Pass { connections: Arc::clone(self), number })
    }
}

impl Pass {
    /// It has shown keys with these rights.
    pub(super) fn has(&self, rights: Rights) {
        let mut all = self.connections.lock();
        if let Some(own) = all.iter_mut().find(|connection| connection.number == self.number) {
            (own.rights, own.heard) = (Some(rights), Instant::now());
        }
        make_room(&mut all, Some(rights), MOST_ALIKE);
    }

    /// It has said something.
    pub(super) fn speaks(&self) {
        if let Some(own) = self.connections.lock().iter_mut().find(|connection| connection.number == self.number) {
            own.heard = Instant::now();
        }
    }
}

impl Drop for Pass {
    fn drop(&mut self) {
        self.connections.lock().retain(|connection| connection.number != self.number);
    }
}

/// Closes the one that has been silent longest of a kind of which there are more than `most`.
fn make_room(all: &mut Vec<Connection>, rights: Option<Rights>, most: usize) {
    let alike = || all.iter().enumerate().filter(|(_, connection)| connection.rights == rights);
    if alike().count() <= most {
        return;
    }
    let silent = alike().min_by_key(|(_, connection)| (connection.heard, connection.number)).map(|(at, _)| at);
    if let Some(at) = silent {
        // Its thread reads the end, and goes.
        let _ = all.swap_remove(at).stream.shutdown(Shutdown::Both);
    }
}
