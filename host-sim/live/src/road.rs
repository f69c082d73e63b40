//! A road of a line: what carries it over more than one path, under an endpoint's socket.
//!
//! What comes is sifted before an actor sees it, what an actor says goes where the road leads. The actor knows one address; `protocol/src/path.rs` and
//! everything above see no change of path. A road is given its time whenever the socket is emptied, which is at every tick.

use std::fmt::Debug;
use std::net::{SocketAddr, UdpSocket};
use std::time::Instant;

use cohold_protocol::key::Key;
use serde::Serialize;

use crate::Error;
use crate::batch::ReceivedBatch;
use crate::endpoint::Endpoint;

/// A road under an open socket.
pub trait Road: Debug + Send + Sync {
    /// The one address that an actor knows.
    fn address(&self) -> SocketAddr;

    /// Sends what it has to say by now.
    fn poll(&self, socket: &UdpSocket);

    /// Leaves in a batch what is for the link, as from its one address.
    fn sift(&self, came: &mut ReceivedBatch, socket: &UdpSocket);

    /// Adds to a batch what has waited for long enough, as far as there is room.
    fn release(&self, came: &mut ReceivedBatch);

    /// Where a datagram of the link's goes now; whether it goes anywhere.
    fn say(&self, datagram: &[u8], each: &mut dyn FnMut(SocketAddr, &[u8])) -> bool;

    /// The oldest change of path that was not taken yet.
    fn take_change(&self) -> Option<Change>;

    /// What there is to say of the paths.
    fn report(&self) -> PathReport;
}

/// How a road is come by: where both ends are met, and what of oneself is shown.
pub trait Roads: Debug + Send + Sync {
    /// The one address that an actor knows.
    fn place(&self) -> SocketAddr;

    /// An endpoint on a road: whatever is said to [`Roads::place`] goes to the other end by the best path, and what comes from there comes as from
    /// that address. Side 0 is peer 1's.
    ///
    /// # Errors
    /// No socket can be opened, or the system gives no random bytes.
    fn open(&self, listen: Option<SocketAddr>, key: Key, side: u8) -> Result<Endpoint, Error>;
}

/// Which way flow goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// There is no path yet, or none any more.
    #[default]
    Nowhere,
    /// By the meeting place; directly too, where that was possible a moment ago.
    Relayed,
    /// From end to end, the relay beside it for now.
    Both,
    /// From end to end.
    Direct,
}

impl Way {
    /// As a recording has it.
    pub fn number(self) -> u8 {
        self as u8
    }
}

/// What a path is like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PathFigures {
    /// Signals that measured it.
    pub signals: u64,
    /// Median round trip, ms.
    pub round_trip_ms: f64,
    /// Round trip that 99 % do not exceed, ms.
    pub p99_ms: f64,
    /// Longest round trip, ms.
    pub largest_ms: f64,
    /// Share of the other end's signals that did not come.
    pub lost: f64,
    /// Sealed datagrams that came first by it.
    pub datagrams: u64,
}

/// Flow has changed its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// When.
    pub at: Instant,
    /// From now on.
    pub way: Way,
    /// The direct path stays within a local network.
    pub lan: bool,
}

/// What a report says of the paths.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PathReport {
    /// Which way flow goes at last.
    pub way: Way,
    /// The direct path stays within a local network.
    pub lan: bool,
    /// The outer address that a router passes on to this end, as it was told to.
    pub mapped: Option<SocketAddr>,
    /// The path by the meeting place.
    pub relayed: PathFigures,
    /// The path from end to end.
    pub direct: PathFigures,
    /// How often flow changed its way.
    pub changes: u64,
    /// How often ICE began anew.
    pub restarts: u64,
    /// Datagrams that both paths brought: the second of each.
    pub copies: u64,
    /// Datagrams from elsewhere, or of no kind that is known.
    pub strangers: u64,
    /// Datagrams of the link that could not go, for there was no path.
    pub pathless: u64,
}
