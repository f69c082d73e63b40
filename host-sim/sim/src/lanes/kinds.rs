//! Which scenes can be stepped side by side.

use std::sync::Arc;

use cohold_core::contact::RenderingName;

use super::number::LANES;
use crate::peers::Builds;
use crate::scene::{Network, Scene};
use crate::{of_axes, plant::Plant};

/// Whether scenes like this one are stepped in lanes at all.
fn suits(scene: &Scene) -> bool {
    let impulsive = scene.peer.contact.rendering == RenderingName::Impulsive;
    !impulsive && of_axes!(scene, is_bare(scene))
}

/// Whether both devices are read and driven exactly, and nothing else.
fn is_bare<const SHARED: usize, const N: usize>(scene: &Scene) -> bool {
    (0..2).all(|index| Plant::<N>::build(scene, index).is_bare())
}

/// Whether the same happens to the packets of both: nothing that is drawn from their seeds differs.
pub(super) fn is_one_network(one: &Scene, other: &Scene) -> bool {
    one.world.network.seed == other.world.network.seed || !one.draws_packets()
}

/// Whether the laws of both peers only hold packets, which are then read as they come.
fn holds_packets(scene: &Scene) -> bool {
    scene.world.network.playout_packets == 0 && of_axes!(scene, laws_only_hold(scene))
}

fn laws_only_hold<const SHARED: usize, const N: usize>(scene: &Scene) -> bool
where
    f64: Builds<SHARED, N>,
{
    (0..2).all(|index| scene.peer_from::<f64, SHARED, N>(index, scene.start(index)).is_ok_and(|peer| peer.only_holds()))
}

/// Scenes that are stepped side by side.
struct Group {
    /// Their places.
    members: Vec<usize>,
    /// Whether the packets of one may be lost where those of another come, if that has been asked.
    holds: Option<bool>,
}

impl Group {
    /// Whether this scene is of their kind: their peers may be alike, and their packets leave together.
    fn takes(&mut self, scenes: &[Scene], scene: &Scene) -> bool {
        let first = &scenes[self.members[0]];
        let same_trace = match (&first.network_trace, &scene.network_trace) {
            (None, None) => true,
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            _ => false,
        };
        let of = |scene: &Scene| {
            let oldest_ns = scene.peers().map(|peer| peer.safety.max_delay_ns());
            (scene.peer.timing, scene.peer.coordination.comm, scene.peer.axis, oldest_ns)
        };
        let network = Network { seed: first.world.network.seed, ..scene.world.network };
        same_trace
            && of(first) == of(scene)
            && first.world.network == network
            && (is_one_network(first, scene) || *self.holds.get_or_insert_with(|| holds_packets(first)))
    }
}

/// These scenes in groups of at most [`LANES`] of one kind, by their places, and those that no lanes suit.
pub(super) fn kinds(scenes: &[Scene]) -> (Vec<Vec<usize>>, Vec<usize>) {
    let (mut groups, mut alone): (Vec<Group>, Vec<usize>) = Default::default();
    for (at, scene) in scenes.iter().enumerate() {
        if !suits(scene) {
            alone.push(at);
            continue;
        }
        let mut open = groups.iter_mut().rev().filter(|group| group.members.len() < LANES);
        match open.find_map(|group| group.takes(scenes, scene).then_some(group)) {
            Some(group) => group.members.push(at),
            None => groups.push(Group { members: vec![at], holds: None }),
        }
    }
    (groups.into_iter().map(|group| group.members).collect(), alone)
}
