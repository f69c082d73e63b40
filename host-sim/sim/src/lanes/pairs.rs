//! Pairs of peers of all lanes, and how such a peer is built: as each scene's alone, number by number.
//!
//! **Checked**: a peer hands over everything that it was built with ([`Configured`](cohold_core::num::Configured)). A lane stays only if
//! that is, in its bits, what its scene's peer hands over alone; so what is counted in whole numbers, or is another model, cannot pass for
//! what the others have. A law that does not hand over what it is has no lanes.

use std::array::from_fn;

use cohold_core::settings::Refused;

use super::device::Plants;
use super::kinds::is_one_network;
use super::mailbox::LaneMailbox;
use super::number::{F64s, LANES, leave, nobody_left, played, recorded, show};
use crate::network::link::Route;
use crate::pair::{HASH_SEED, Pair, PeerTick, Side};
use crate::peers::{Builds, DynPeer, mixed};
use crate::{AXES, plant::Plant, scene::Scene};

/// Pairs of peers side by side, one pair in each lane.
pub struct Pairs<const SHARED: usize = 1, const N: usize = AXES> {
    pair: Pair<F64s, Plants<N>, SHARED, N, LaneMailbox<SHARED>>,
    hashes: [u64; LANES],
    /// The numbers of a peer's state, while they are hashed.
    state: Vec<F64s>,
}

impl<const SHARED: usize, const N: usize> Pairs<SHARED, N>
where
    F64s: Builds<SHARED, N>,
{
    /// Pairs for these scenes of one kind, at most [`LANES`], all peers armed and at rest. [`super::number::lanes_left`] says
    /// which lanes have left, for one group of lanes a thread at a time. Lanes without a scene do what the last one does.
    ///
    /// # Errors
    /// The first key whose value is out of range or impossible beside the others.
    ///
    /// # Panics
    /// There is no scene.
    pub fn new(scenes: &[&Scene]) -> Result<Self, Refused<'static>> {
        nobody_left();
        let one = scenes.iter().all(|scene| is_one_network(scene, scenes[0]));
        let own = scenes;
        let scenes: [&Scene; LANES] = from_fn(|lane| scenes[lane.min(scenes.len() - 1)]);
        let side = |index, to| {
            // Moved by nothing, as those of a pair alone are: −0 m becomes 0 m.
            let plants: Vec<Plant<N>> = scenes.iter().map(|scene| Plant::build(scene, index).moved([0.0; N])).collect();
            let peer = peer(&scenes, &plants, index)?;
            let first = &scenes[0];
            let alike = scenes.iter().all(|scene| {
                let [one, other] = [*scene, *first].map(|scene| &scene.users[index]);
                one.settings == other.settings && one.trace == other.trace
            });
            let mailbox = LaneMailbox::new(own, index, one)?;
            Ok::<_, Refused<'static>>(Side::with_mailbox(first, peer, Plants::new(plants, alike), to, mailbox))
        };
        Ok(Self {
            // Where each lane has its own network, the mailboxes are these.
            pair: Pair::with_routes(scenes[0], [side(0, 1)?, side(1, 0)?], |direction| {
                if one { Route::of_scene(scenes[0], direction, 0) } else { Route::default() }
            }),
            hashes: [HASH_SEED; LANES],
            state: Vec::new(),
        })
    }
}

impl<const SHARED: usize, const N: usize> Pairs<SHARED, N> {
    /// [`Pair::packets_per_s`]; those that are there agree on it.
    pub(super) fn packets_per_s(&self) -> f64 {
        self.pair.packets_per_s()
    }

    /// Advances all lanes by one control period; `each` gets what every tick of either peer read and did.
    #[inline]
    pub fn step(&mut self, each: &mut impl FnMut(PeerTick<'_, F64s, SHARED, N>)) {
        self.pair.step_watched(each);
    }

    /// Continues the hash of each lane's states ([`Pair::hash`]).
    #[inline]
    pub fn hash(&mut self) {
        let Self { pair, hashes, state } = self;
        for side in pair.sides_mut() {
            // First they are gathered: a hash that waits for each number in memory waits longer than it takes.
            state.clear();
            side.peer.visit_state(&mut |number| state.push(*number));
            *hashes = state.iter().fold(*hashes, |hashes, number| {
                let bits = number.lanes().map(f64::to_bits);
                from_fn(|lane| mixed(hashes[lane], bits[lane]))
            });
        }
    }

    /// The hash of each lane so far.
    pub fn hashes(&self) -> [u64; LANES] {
        self.hashes
    }
}

/// A peer of all lanes; whose scene's alone would be another one leaves.
fn peer<const SHARED: usize, const N: usize>(
    scenes: &[&Scene; LANES],
    plants: &[Plant<N>],
    index: usize,
) -> Result<Box<dyn DynPeer<F64s, SHARED, N>>, Refused<'static>>
where
    F64s: Builds<SHARED, N>,
{
    let build = |lane: usize| scenes[lane].peer_from::<F64s, SHARED, N>(index, plants[lane].motions());
    let (mut numbers, mut alone): (Vec<Vec<f64>>, Vec<Option<u64>>) = Default::default();
    for lane in 0..LANES {
        if lane > 0 && std::ptr::eq(scenes[lane], scenes[lane - 1]) {
            numbers.push(numbers[lane - 1].clone());
            alone.push(alone[lane - 1]);
            continue;
        }
        let (peer, noted) = recorded(|| build(lane));
        numbers.push(noted);
        alone.push(configuration(&*peer?, 0));
    }
    let peer = played(numbers, || build(0))?;
    for (lane, alone) in alone.iter().enumerate() {
        if alone.is_none() || configuration(&*peer, lane) != *alone {
            leave(1 << lane);
        }
    }
    Ok(peer)
}

/// A hash of everything that a peer was built with, as this lane has it; none if its law does not say.
fn configuration<const SHARED: usize, const N: usize>(peer: &dyn DynPeer<F64s, SHARED, N>, lane: usize) -> Option<u64> {
    show(lane);
    let mut hash = HASH_SEED;
    peer.configuration(&mut |word| hash = mixed(hash, word)).then_some(hash)
}
