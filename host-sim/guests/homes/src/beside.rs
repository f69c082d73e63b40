//! A board far away, reached through the PC beside it: on its own network the PC is the board's partner, outside it is an end that is met.
//!
//! [`Bridge`] says what passes, the carrier which way it goes; here are the two sockets. The board answers to the address that it was told
//! ([`PORT`] at both ends), so the one on its network has a fixed port; the other has any.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use crate::bridge::{Bridge, Counts};
use cohold_live::road::{PathReport, Roads as _};
use cohold_protocol::key::Key;
use cohold_sim::engine::{Actor, Out};
use serde::Serialize;

use crate::carried::{Meeting, canonical};
use cohold_live::Error;
use cohold_live::batch::ReceivedBatch;
use cohold_live::endpoint::{Endpoint, Live, Punctuality, Stop, Ticker};
use cohold_live::path_watch::PathWatch;
use cohold_live::tell::{Manner, Teller};

/// Port of a board's flow, at both ends.
pub const PORT: u16 = 7701;
/// How often the bridge looks: what it adds to the delay at the most.
const PERIOD: Duration = Duration::from_micros(200);

/// Which board, and whom it is to reach where.
#[derive(Clone, Debug)]
pub struct Ends {
    /// The board, and nobody else on its network.
    pub board: SocketAddr,
    /// Where the board sends to.
    pub listen: SocketAddr,
    /// Where the far end's datagrams come to; none, and it is any port.
    pub outside: Option<SocketAddr>,
    /// Which of the two the board is: 1 (left) or 2 (right).
    pub number: u8,
    /// The key that the board shares with the far end: it makes room and seat, and seals what the carriers say. The flow is not opened.
    pub key: Key,
    /// Where the two meet.
    pub meeting: Meeting,
}

/// What a bridge has done.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The board.
    pub board: SocketAddr,
    /// Where it was listened to.
    pub listened: SocketAddr,
    /// Datagrams.
    #[serde(flatten)]
    pub counts: Counts,
    /// Datagrams to the board that the system did not take.
    pub unsent: u64,
    /// Which way the flow went outside.
    pub path: PathReport,
    /// How punctually it looked.
    pub ticks: Punctuality,
}

struct Passes {
    outer: Endpoint,
    bridge: Bridge,
    watch: PathWatch,
    /// What whoever is met is called here.
    far: SocketAddr,
    came: ReceivedBatch,
    teller: Teller,
    end: Option<Result<(), Error>>,
}

impl Actor<SocketAddr> for Passes {
    type Packet = [u8];

    fn hear(&mut self, _: u64, from: SocketAddr, datagram: &mut [u8], _: &mut Out<'_, SocketAddr, [u8]>) {
        if self.bridge.hear_board(Instant::now(), from, datagram) {
            self.outer.send(self.far, datagram);
        }
    }

    fn act(&mut self, now_ns: u64, inner: &mut Out<'_, SocketAddr, [u8]>) {
        let Self { outer, bridge, came, .. } = self;
        let now = Instant::now();
        let heard = outer.drain(came, now + PERIOD / 2, |_, datagram| {
            if bridge.hear_far(now, datagram) {
                inner(bridge.board(), datagram);
            }
        });
        self.watch.look(now_ns, &self.teller);
        if let Some(there) = bridge.look(now) {
            let board = bridge.board();
            self.teller.words(match there {
                true => format!("the board at {board} is there"),
                false => format!(
                    "nothing comes from the board at {board} any more: it is off, unplugged or was told another partner"
                ),
            });
        }
        self.end = heard.is_err().then_some(heard);
    }
}

impl Live for Passes {
    fn end(&mut self) -> Option<Result<(), Error>> {
        self.end.take()
    }
}

/// A bridge whose two sockets are open.
pub struct Open {
    inner: Endpoint,
    passes: Passes,
}

impl Open {
    /// Opens both sockets; what happens is said in this manner.
    ///
    /// # Errors
    /// An address cannot be opened, the board cannot be reached from it, or the system gives no random bytes.
    pub fn new(ends: Ends, manner: Manner) -> Result<Self, Error> {
        let Ends { board, listen, outside, number, key, meeting } = ends;
        let inner = Endpoint::polled(listen)?;
        inner.reaches(board)?;
        let outer = meeting.open(outside, key, number - 1)?;
        let watch = PathWatch::new(outer.road().ok_or("this end meets nobody")?);
        let (bridge, teller, came) = (Bridge::new(board, Instant::now()), Teller::new(manner), Default::default());
        let far = canonical(meeting.place);
        Ok(Self { inner, passes: Passes { outer, bridge, watch, far, came, teller, end: None } })
    }

    /// Where the board is listened to.
    pub fn address(&self) -> SocketAddr {
        self.inner.address
    }

    /// Carries for `seconds`, or until it is stopped.
    ///
    /// # Errors
    /// A socket failed.
    pub fn run(self, seconds: f64, stop: &Stop) -> Result<Report, Error> {
        let Self { inner, mut passes } = self;
        let ticks = inner.run(Ticker::realtime(PERIOD).lasting(seconds), f64::MAX, stop, &mut passes)?;
        let Passes { bridge, watch, .. } = passes;
        let (board, listened, unsent) = (bridge.board(), inner.address, inner.unsent.into_inner());
        Ok(Report { board, listened, counts: bridge.counts, unsent, path: watch.report(), ticks })
    }
}
