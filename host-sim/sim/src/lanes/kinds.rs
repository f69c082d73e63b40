//! Which scenes can be stepped side by side.

use std::sync::Arc;

use haptic_core::contact::RenderingName;

use super::number::LANES;
use crate::{of_axes, plant::Plant, scene::Scene};

/// Whether scenes like this one are stepped in lanes at all.
fn suits(scene: &Scene) -> bool {
    let impulsive = scene.peer.contact.rendering == RenderingName::Impulsive;
    !impulsive && of_axes!(scene, is_bare(scene))
}

/// Whether both devices are read and driven exactly, and nothing else.
fn is_bare<const SHARED: usize, const N: usize>(scene: &Scene) -> bool {
    (0..2).all(|index| Plant::<N>::build(scene, index).is_bare())
}

/// Whether the packets of both come together, and their peers may be alike.
fn of_one_kind(one: &Scene, other: &Scene) -> bool {
    let same_trace = match (&one.network_trace, &other.network_trace) {
        (None, None) => true,
        (Some(one), Some(other)) => Arc::ptr_eq(one, other),
        _ => false,
    };
    let [here, there] = [one, other].map(|scene| (&scene.peer.timing, scene.peer.coordination.comm, scene.peer.axis));
    same_trace && here == there && one.world.network == other.world.network
}

/// These scenes in groups of at most [`LANES`] of one kind, by their places, and those that no lanes suit.
pub(super) fn kinds(scenes: &[Scene]) -> (Vec<Vec<usize>>, Vec<usize>) {
    let (mut groups, mut alone): (Vec<Vec<usize>>, Vec<usize>) = Default::default();
    for (at, scene) in scenes.iter().enumerate() {
        if !suits(scene) {
            alone.push(at);
            continue;
        }
        let open = |group: &&mut Vec<usize>| group.len() < LANES && of_one_kind(&scenes[group[0]], scene);
        match groups.iter_mut().rev().find(open) {
            Some(group) => group.push(at),
            None => groups.push(vec![at]),
        }
    }
    (groups, alone)
}
