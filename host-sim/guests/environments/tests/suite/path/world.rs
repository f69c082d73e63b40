//! Two peers, or a hub and two peers, every end with a clock of its own, and what lies between them: a millisecond of it at a time.

use cohold_core::safety::Mode;
use cohold_environments::cooperative::hub::{Hub, number_on};
use cohold_live::node::{Line, Node};
use cohold_live::start::AFTER_US;
use cohold_protocol::key::Key;
use cohold_protocol::link::Notice;
use cohold_sim::scene::Scene;

use super::end::{Clock, End, Limits, Seen};
use super::{Planted, Setup};
use crate::on_path::{Fate, Path};

/// Each peer's way out and its way in; without a hub the way out of one is the way into the other.
pub(super) const WAYS: usize = 4;

pub(super) struct World {
    planted: Planted,
    pub(super) nodes: [Node; 2],
    hub: Option<Box<Hub<usize>>>,
    pub(super) path: Path<WAYS>,
    /// Of the peers, and then of the hub's lines.
    pub(super) ends: Vec<End>,
    pub(super) clocks: [Clock; 3],
    limits: Limits,
    /// Silence fades what the peers do.
    fades: bool,
    pub(super) now_ms: u64,
    /// When the first hand moved.
    pub(super) moved_ms: Option<u64>,
    /// Since then an end has faded, or let go.
    pub(super) faded: bool,
}

impl World {
    /// Everybody calls; clocks of the peers and of the hub.
    pub(super) fn new(setup: &Setup, scene: &Scene, clocks: [Clock; 3], path: Path<WAYS>) -> Self {
        let key = Key::new([0x5a; Key::LEN]);
        let nodes = [1, 2].map(|line| {
            let key = if setup.hub { key.line(line) } else { key.clone() };
            let node = <Node>::build(scene, number_on(line), key, [line as u8; Key::LEN]).expect("a peer");
            node.beginning_after(AFTER_US)
        });
        let mut drawn = 100;
        let entropy = || {
            drawn += 1;
            Ok([drawn; Key::LEN])
        };
        let hub = setup.hub.then(|| Box::new(Hub::new(scene, 2, &key, entropy).expect("a hub")));
        // Peers are next to each other, or each to its line of the hub.
        let next_to: &[(usize, usize)] = if setup.hub { &[(0, 2), (1, 3), (2, 0), (2, 1)] } else { &[(0, 1), (1, 0)] };
        let ends = next_to.iter().map(|(clock, partner)| End::new(*clock, *partner)).collect();
        Self {
            planted: setup.planted,
            nodes,
            hub,
            path,
            ends,
            clocks,
            limits: Limits::of(scene),
            fades: !scene.law().own_time,
            now_ms: 0,
            moved_ms: None,
            faded: false,
        }
    }

    fn now_us(&self, clock: usize) -> u64 {
        self.clocks[clock].us(self.now_ms)
    }

    /// A millisecond, datagrams meeting the fate that this says by way and length; what was broken, if anything.
    pub(super) fn step(&mut self, fate: impl Fn(usize, usize) -> Fate + Copy) -> Result<(), String> {
        self.now_ms += 1;
        for peer in 0..2 {
            self.hear(peer);
            let mut said = Vec::new();
            let (now_us, node) = (self.now_us(peer), &mut self.nodes[peer]);
            if self.planted == Planted::OwnEndIsEnough {
                // Said long ago, whatever else was heard.
                node.line.start.hear(1, true);
            }
            let _ = node.tick(now_us, |bytes| said.push(bytes.to_vec()));
            self.say(2 * peer, &said, fate);
        }
        let now_us = self.now_us(2);
        let mut said = [Vec::new(), Vec::new()];
        if let Some(hub) = &mut self.hub {
            for from in 0..2 {
                for mut datagram in self.path.come(self.now_ms, 2 * from) {
                    hub.receive(now_us, from, &mut datagram, |to, bytes| said[to].push(bytes.to_vec()));
                }
            }
            hub.tick(now_us, |to, bytes| said[to].push(bytes.to_vec()));
        }
        for (peer, said) in said.iter().enumerate() {
            self.say(2 * peer + 1, said, fate);
        }
        // What takes no time has come before anybody's next period.
        (0..2).for_each(|peer| self.hear(peer));
        self.look()
    }

    fn hear(&mut self, peer: usize) {
        let way = if self.hub.is_some() { 2 * peer + 1 } else { 2 * (1 - peer) };
        let now_us = self.now_us(peer);
        for mut datagram in self.path.come(self.now_ms, way) {
            let _ = self.nodes[peer].receive(now_us, &mut datagram);
        }
    }

    /// What is not held takes no time at all, so that the two ways can be as unlike as ways can be.
    fn say(&mut self, way: usize, said: &[Vec<u8>], fate: impl Fn(usize, usize) -> Fate + Copy) {
        said.iter().for_each(|datagram| self.path.say(self.now_ms - 1, way, datagram, fate));
    }

    /// What is seen of every end, in their order.
    fn seen(&self) -> Vec<(Seen, &Line)> {
        let peers = self.nodes.iter().map(|node| {
            let engaged = node.peer.is_engaged();
            let whole = engaged && (node.peer.is_whole() || !self.fades);
            (Seen { engaged, whole, says: node.peer.mode() == Mode::Armed, moves: node.armed_ticks > 0 }, &node.line)
        });
        let lines = self.hub.iter().flat_map(|hub| {
            hub.lines().enumerate().map(|(at, (end, port))| {
                let (engaged, says) = (port.is_engaged(), hub.packets.is_some());
                (Seen { engaged, whole: engaged && hub.junction.is_whole(at), says, moves: false }, &end.line)
            })
        });
        peers.chain(lines).collect()
    }

    /// Every promise, now.
    fn look(&mut self) -> Result<(), String> {
        let mut ends = std::mem::take(&mut self.ends);
        let seen = self.seen();
        let now_us = self.clocks.map(|clock| clock.us(self.now_ms));
        let moves = seen.iter().any(|(seen, _)| seen.moves);
        let fades = seen.iter().any(|(seen, _)| !seen.whole);
        ends.iter_mut().zip(&seen).for_each(|(end, (seen, _))| end.see(self.now_ms, *seen));
        let mut kept = Ok(());
        for at in 0..ends.len() {
            let partner = ends[at].partner;
            let of_partner = ends[partner].said;
            let others = (0..ends.len()).filter(|other| *other != at).all(|other| ends[other].said.live_ms.is_some());
            let stands = [now_us[ends[at].clock], now_us[ends[partner].clock]];
            let (seen, line) = seen[at];
            let end = &mut ends[at];
            let all = end
                .consents(self.now_ms, seen, of_partner, &self.limits)
                .and_then(|()| end.begins(self.now_ms, seen, of_partner, others, &self.limits))
                .and_then(|()| end.knows_the_clock(line, stands, self.planted));
            kept = kept.and(all.map_err(|why| format!("{} ms: end {at}: {why}", self.now_ms)));
        }
        drop(seen);
        self.ends = ends;
        if moves {
            self.moved_ms.get_or_insert(self.now_ms);
            self.faded |= fades;
        }
        kept
    }

    /// Whether somebody could read at an end, from a second before hands began to move, that the other end fell silent or went, or that
    /// motors went off.
    pub(super) fn tells(&self) -> bool {
        let since_ms = self.moved_ms.unwrap_or_default().saturating_sub(1_000);
        let told = |((_, line), end): ((Seen, &Line), &End)| {
            let since_us = self.clocks[end.clock].us(since_ms);
            let bad = |notice: &Notice| matches!(notice, Notice::Fading | Notice::Disengaged | Notice::Lost);
            line.notices.iter().any(|(at_us, notice)| *at_us >= since_us && bad(notice))
        };
        let faulted = |node: &Node| matches!(node.peer.mode(), Mode::Faulted(_));
        self.seen().into_iter().zip(&self.ends).any(told) || self.nodes.iter().any(faulted)
    }

    /// The motors of a peer are off from now on.
    pub(super) fn halt(&mut self, peer: usize) {
        self.nodes[peer].halt(true);
        self.ends[peer].said.halted_ms = Some(self.now_ms);
    }

    /// How far the copies of the peers are apart, m.
    pub(super) fn apart_m(&self) -> f64 {
        let [one, two] = self.nodes.each_ref().map(|node| f64::from(node.observed().object.position));
        one - two
    }
}
