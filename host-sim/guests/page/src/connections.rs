//! Who is connected: a bounded number of each kind, of which the newest is always let in.
//!
//! Connections that have shown no key are one kind, windows with the same rights another, each of this machine and of the local network
//! apart. Where a kind is full, one of the address that has most of it is closed, the one that has been silent longest: whoever says
//! nothing keeps nobody out, whoever has no key takes no place from one who has, and one address none from the others.

use std::collections::BTreeMap;
use std::net::{IpAddr, Shutdown, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::doors::Way;
use super::roles::Rights;

/// Connections at a time that have shown no key.
pub(super) const MOST_WITHOUT_KEY: usize = 64;
/// Windows at a time with the same rights.
pub(super) const MOST_ALIKE: usize = 16;

/// Everybody who is connected, and how many were so far.
#[derive(Debug, Default)]
pub(super) struct Connections(Mutex<(Vec<Connection>, u64)>);

/// The way in, and what was shown there; none before a key was.
type Kind = (Way, Option<Rights>);

#[derive(Debug)]
struct Connection {
    number: u64,
    kind: Kind,
    from: IpAddr,
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
    fn lock(&self) -> MutexGuard<'_, (Vec<Connection>, u64)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets a connection in that has shown no key; an error where it is gone already.
    pub(super) fn admit(self: &Arc<Self>, way: Way, stream: &TcpStream) -> std::io::Result<Pass> {
        self.admit_from(way, stream.peer_addr()?.ip(), stream.try_clone()?)
    }

    fn admit_from(self: &Arc<Self>, way: Way, from: IpAddr, stream: TcpStream) -> std::io::Result<Pass> {
        let mut locked = self.lock();
        let (all, count) = &mut *locked;
        let (number, kind) = (*count, (way, None));
        *count += 1;
        all.push(Connection { number, kind, from, heard: Instant::now(), stream });
        make_room(all, kind, MOST_WITHOUT_KEY);
        Ok(Pass { connections: Arc::clone(self), number })
    }
}

impl Pass {
    /// It has shown keys with these rights.
    pub(super) fn has(&self, rights: Rights) {
        let all = &mut self.connections.lock().0;
        let Some(own) = all.iter_mut().find(|connection| connection.number == self.number) else { return };
        (own.kind.1, own.heard) = (Some(rights), Instant::now());
        let kind = own.kind;
        make_room(all, kind, MOST_ALIKE);
    }

    /// It has said something.
    pub(super) fn speaks(&self) {
        let all = &mut self.connections.lock().0;
        if let Some(own) = all.iter_mut().find(|connection| connection.number == self.number) {
            own.heard = Instant::now();
        }
    }
}

impl Drop for Pass {
    fn drop(&mut self) {
        self.connections.lock().0.retain(|connection| connection.number != self.number);
    }
}

/// Closes one of a kind of which there are more than `most`: of the address that has most of them the one that has been silent longest.
fn make_room(all: &mut Vec<Connection>, kind: Kind, most: usize) {
    let alike = || all.iter().enumerate().filter(|(_, connection)| connection.kind == kind);
    if alike().count() <= most {
        return;
    }
    let mut of_address = BTreeMap::<IpAddr, usize>::new();
    alike().for_each(|(_, connection)| *of_address.entry(connection.from).or_default() += 1);
    let largest = of_address.values().max().copied();
    let crowded = alike().filter(|(_, connection)| of_address.get(&connection.from).copied() == largest);
    let silent = crowded.min_by_key(|(_, connection)| (connection.heard, connection.number)).map(|(at, _)| at);
    if let Some(at) = silent {
        // Its thread reads the end, and goes.
        let _ = all.swap_remove(at).stream.shutdown(Shutdown::Both);
    }
}

#[cfg(test)]
#[path = "../tests/inside/connections.rs"]
mod tests;
