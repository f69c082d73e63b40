//! The network between peers: what becomes of each packet, and what is on its way.
//!
//! | module | holds |
//! |---|---|
//! | [`rule`] | what becomes of each packet: seeded from the scene, read from a trace, or any closure |
//! | [`link`] | one way of a network, and which of what has come the receiver takes |
//! | [`mesh`] | several peers: their clocks, and a line from each to each other |

pub mod link;
pub mod mesh;
pub mod rule;

use link::{Inbox, Link, Numbered, Route};
use rule::Direction;

use crate::scene::Scene;

/// One direction of the network, of packets that a peer asks for once each packet period.
pub struct Way<P: Copy> {
    link: Link<Numbered<P>>,
    inbox: Inbox<P>,
    packet_ns: u64,
}

impl<P: Copy> Way<P> {
    /// The direction's network as the scene describes it, on line `line` of several.
    pub fn new(scene: &Scene, direction: Direction, line: u32) -> Self {
        Self {
            link: Link::new(Route::of_scene(scene, direction, line)),
            inbox: Inbox::new(scene),
            packet_ns: scene.peer.timing.packet_period_ns(),
        }
    }

    fn ns(&self, packets: f64) -> u64 {
        (packets * self.packet_ns as f64).round() as u64
    }

    /// Takes a packet that the sender sends at `now`, in packet periods.
    pub fn send(&mut self, now: f64, packet: P) {
        let (now_ns, number) = (self.ns(now), self.link.counts().taken);
        self.link.send(now_ns, &Numbered { number, what: packet });
    }

    /// The newest packet that has arrived by `now`, in packet periods, and was not overtaken.
    pub fn take(&mut self, now: f64) -> Option<P> {
        let now_ns = self.ns(now);
        while let Some((due_ns, packet)) = self.link.take(now_ns) {
            self.inbox.put(due_ns, packet);
        }
        self.inbox.take(now_ns)
    }

    /// Packets sent so far.
    pub fn sent(&self) -> u64 {
        self.link.counts().taken
    }
}
