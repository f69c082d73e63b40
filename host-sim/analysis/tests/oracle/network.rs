//! Two lifted peers and the packets between them: augmentation with the communication delay.
//!
//! The held input of a peer is the packet that arrives at the start of the period: the other peer's sent states n_t periods
//! ago, kept in a shift register. Order of the joint state: peer 1, peer 2, packets on their way to peer 1, to peer 2,
//! youngest first.

use cohold_sim::scene::Scene;

use super::lift::Period;
use super::peer::{ConstructedPeer, State};
use crate::lifted::Lifted;
use crate::matrix::{Matrix, add_block, column};

/// What a state of the pair is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// A state of a peer (0 or 1).
    Local { peer: usize, state: State },
    /// A sender's state on its way `to` a peer (0 or 1), for as many periods as `slot` says: 0 is the youngest.
    InFlight { to: usize, slot: usize, state: State },
}

/// The pair's lifted matrix, with the place of each of its states.
#[derive(Clone, Debug)]
pub(crate) struct Constructed {
    pub lifted: Lifted,
    pub places: Vec<Place>,
}

/// Joins the two peers, with so many whole packet periods of delay to each.
pub(super) fn join(
    scene: &Scene,
    peers: &[ConstructedPeer; 2],
    periods: &[Period; 2],
    delays: [usize; 2],
) -> Constructed {
    let mut places = Vec::new();
    for (peer, open) in peers.iter().enumerate() {
        places.extend(open.states.iter().map(|&state| Place::Local { peer, state }));
    }
    for (to, sender) in [(0, &peers[1]), (1, &peers[0])] {
        for slot in 0..delays[to] {
            places.extend(sender.sends.iter().map(|&state| Place::InFlight { to, slot, state }));
        }
    }
    let find = |place: Place| places.iter().position(|known| *known == place).unwrap_or(usize::MAX);
    let mut matrix = Matrix::zeros(places.len(), places.len());
    for (to, period) in periods.iter().enumerate() {
        let (from, start) = (1 - to, to * peers[0].states.len());
        add_block(&mut matrix, start, start, &period.state, 1.0);
        for (held, &state) in peers[from].sends.iter().enumerate() {
            let source = find(Place::Local { peer: from, state });
            let heard = match delays[to].checked_sub(1) {
                None => source,
                Some(slot) => find(Place::InFlight { to, slot, state }),
            };
            for (i, entry) in column(&period.held, held).iter().enumerate() {
                matrix[(start + i, heard)] += entry;
            }
            for slot in 0..delays[to] {
                let before = match slot.checked_sub(1) {
                    None => source,
                    Some(slot) => find(Place::InFlight { to, slot, state }),
                };
                matrix[(find(Place::InFlight { to, slot, state }), before)] = 1.0;
            }
        }
    }
    let rest_modes = rest_modes(scene, peers, &places);
    Constructed { lifted: Lifted { matrix, rest_modes }, places }
}

/// THEORY §3: in power the translation of the pair, otherwise each peer's own, where no arm holds it.
fn rest_modes(scene: &Scene, peers: &[ConstructedPeer; 2], places: &[Place]) -> Vec<Vec<f64>> {
    let translation = |moving: &[usize]| {
        let moves = |place: &Place| match place {
            Place::Local { peer, state } => moving.contains(peer) && is_position(*state),
            Place::InFlight { to, state, .. } => moving.contains(&(1 - to)) && is_position(*state),
        };
        places.iter().map(|place| f64::from(u8::from(moves(place)))).collect()
    };
    if scene.peer.coordination.comm == "power" {
        if peers.iter().all(|peer| peer.free) { vec![translation(&[0, 1])] } else { Vec::new() }
    } else {
        (0..2).filter(|&peer| peers[peer].free).map(|peer| translation(&[peer])).collect()
    }
}

fn is_position(state: State) -> bool {
    matches!(state, State::DevicePosition | State::ObjectPosition | State::DesiredPosition | State::LastReading)
}
