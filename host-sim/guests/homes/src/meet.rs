//! The meeting place as a server: [`Place`] on an endpoint that answers, in batches as they come.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use crate::place::{Counts, Place};
use cohold_protocol::key::Key;
use cohold_sim::engine::{Actor, Out};
use serde::Serialize;

use crate::carried::{canonical, written};
use cohold_live::endpoint::{Endpoint, Live, Stop, Ticker};
use cohold_live::{Error, key_file::entropy};

/// Between two looks at whether it is to end.
const PERIOD: Duration = Duration::from_millis(100);

/// What a meeting place has done.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Report {
    /// Where it listened.
    pub listened: SocketAddr,
    /// Rooms with somebody in them, in the end.
    pub rooms: usize,
    /// Datagrams.
    #[serde(flatten)]
    pub counts: Counts,
}

struct Server {
    place: Place,
    /// The socket writes IPv4 addresses as IPv6's.
    mapped: bool,
}

impl Actor<SocketAddr> for Server {
    type Packet = [u8];

    fn hear(&mut self, _: u64, from: SocketAddr, datagram: &mut [u8], out: &mut Out<'_, SocketAddr, [u8]>) {
        let mapped = self.mapped;
        self.place.hear(Instant::now(), canonical(from), datagram, &mut |to, bytes| out(written(to, mapped), bytes));
    }

    fn act(&mut self, _: u64, _: &mut Out<'_, SocketAddr, [u8]>) {}
}

impl Live for Server {}

/// A meeting place that is open.
#[derive(Debug)]
pub struct Meet(Endpoint);

impl Meet {
    /// Opens one there; on `[::]` it is of both families.
    ///
    /// # Errors
    /// The address cannot be opened.
    pub fn open(listen: SocketAddr) -> Result<Self, Error> {
        Endpoint::answering(listen).map(Self)
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.0.address
    }

    /// Serves for `seconds`, or until it is stopped.
    ///
    /// # Errors
    /// The socket failed, or the system gives no random bytes.
    pub fn run(&self, seconds: f64, stop: &Stop) -> Result<Report, Error> {
        let mapped = self.0.address.is_ipv6() && self.0.address.ip().is_unspecified();
        let mut server = Server { place: Place::new(&Key::new(entropy()?), Instant::now()), mapped };
        self.0.run(Ticker::realtime(PERIOD).lasting(seconds), f64::MAX, stop, &mut server)?;
        let Server { place, .. } = server;
        Ok(Report { listened: self.0.address, rooms: place.rooms(), counts: place.counts })
    }
}
