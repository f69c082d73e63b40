//! The lifted matrix built as the cooperation paper builds it (§4), from the equations and from nothing of `cohold_core`.
//!
//! | step | paper | here |
//! |---|---|---|
//! | continuous open loop of device and object, discretised | (8)–(11) | [`hold`] |
//! | augmented with x_d, ẋ_d, waves, filter, delayed inputs | (13)–(19), (22)–(23) | [`peer`]: A, B |
//! | forces and decoded velocity as feedback of states | F_D, (3)–(7) | [`peer`], `law`: F, G, H |
//! | lifted over the M ticks of a packet, loop closed | (12), (24) | [`lift`] |
//! | packets and communication delay | last paragraph of §4.2 | [`network`] |
//!
//! Only the parameters are shared with [`crate::lifted::driven`]. A law, integrator or estimator whose equations are not written
//! here gives `None`: core's lists may grow, this file need not.

mod agreement;
mod hold;
mod law;
mod lift;
mod network;
mod peer;
mod tests;

use cohold_sim::scene::Scene;

use crate::lifted::delay::delays_ticks;
use crate::matrix::Matrix;

use network::{Constructed, Place};
use peer::State;

/// Builds the pair from the linear scene of each peer ([`Scene::linear`]), without using symmetry; `None` where the scene
/// names a model that this construction has no equations for, and where
/// packets are heard between two exchanges.
fn construct([first, second]: [&Scene; 2]) -> Option<Constructed> {
    let (delays, packet) = (delays_ticks(first), first.peer.timing.ticks_per_packet as usize);
    if delays.iter().any(|ticks| ticks % packet != 0) {
        return None;
    }
    let peers = [peer::ConstructedPeer::new(first, 0)?, peer::ConstructedPeer::new(second, 1)?];
    let periods = peers.each_ref().map(|peer| lift::close(peer, packet));
    Some(network::join(first, &peers, &periods, delays.map(|ticks| ticks / packet)))
}

/// A matrix from its rows.
pub(crate) fn rows<const ROWS: usize, const COLUMNS: usize>(rows: [[f64; COLUMNS]; ROWS]) -> Matrix {
    Matrix::from_fn(ROWS, COLUMNS, |i, j| rows[i][j])
}
