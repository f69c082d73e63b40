//! Lifting: M ticks of one peer become one step, and the feedback of all M ticks is closed at once.
//!
//! With z_k = Aᵏ·z₀ + Σ_{l<k} A^(k−1−l)·B·u_l, the stacked outputs are Y = C·z₀ + D·U (paper (12)) and the stacked inputs
//! U = F·Y + G·U + H·s. Solved for U: (1 − G − F·D)·U = F·C·z₀ + H·s, put into z_M = Aᴹ·z₀ + [A^(M−1)·B … B]·U: this is
//! A_g = A_D + B_D·(1 − F_D·D_D)⁻¹·F_D·C_D of paper (24). No force acts before it is computed, so the system is block
//! triangular and solved from its first block row to its last: elimination with row exchange would lose the digits of
//! an unstable scene, whose inputs grow by ten orders of magnitude within a packet.
//!
//! Limit: what the open loop grows by within a packet is lost in digits, however stable the closed loop is. It grows where
//! forward Euler overshoots its own damping, b_O·T_c > 2·m_O; the driven matrix does not mind.

use super::peer::ConstructedPeer;
use crate::matrix::{Matrix, add_block, column_mut};

/// One packet period of one peer.
#[derive(Clone, Debug)]
pub(super) struct Period {
    /// State before → state after.
    pub state: Matrix,
    /// Held input → state after.
    pub held: Matrix,
}

/// Closes the loop over `ticks` ticks.
pub(super) fn close(peer: &ConstructedPeer, ticks: usize) -> Period {
    let (z, u, s) = (peer.a.nrows(), peer.b.ncols(), peer.h.ncols());
    // Aᵏ for k = 0…M, and AᵏB, F·AᵏB for k = 0…M−1.
    let mut powers = vec![Matrix::identity(z, z)];
    for k in 0..ticks {
        powers.push(&peer.a * &powers[k]);
    }
    let steered: Vec<Matrix> = powers[..ticks].iter().map(|power| power * &peer.b).collect();
    let looped: Vec<Matrix> = steered.iter().map(|steered| &peer.f * steered).collect();

    let mut algebraic = Matrix::identity(u, u);
    add_block(&mut algebraic, 0, 0, &peer.g, -1.0);
    let algebraic = algebraic.lu();
    let mut inputs: Vec<Matrix> = Vec::with_capacity(ticks);
    for k in 0..ticks {
        let mut right = Matrix::zeros(u, z + s);
        add_block(&mut right, 0, 0, &(&peer.f * &powers[k]), 1.0);
        add_block(&mut right, 0, z, &peer.h, 1.0);
        for (l, earlier) in inputs.iter().enumerate() {
            add_block(&mut right, 0, 0, &(&looped[k - 1 - l] * earlier), 1.0);
        }
        algebraic.solve_mut(&mut right);
        inputs.push(right);
    }

    let mut after = Matrix::zeros(z, z + s);
    add_block(&mut after, 0, 0, &powers[ticks], 1.0);
    for (k, inputs) in inputs.iter().enumerate() {
        add_block(&mut after, 0, 0, &(&steered[ticks - 1 - k] * inputs), 1.0);
    }
    let mut period = Period { state: after.columns(0, z).into_owned(), held: after.columns(z, s).into_owned() };
    if let Some(state) = peer.restarts {
        column_mut(&mut period.state, peer.at(state)).fill(0.0);
    }
    period
}
