//! Lifting: M ticks of one peer become one step, and the feedback of all M ticks is closed at once.
//!
//! With z_k = Aᵏ·z₀ + Σ_{l<k} A^(k−1−l)·B·u_l, the stacked outputs are Y = C·z₀ + D·U (paper (12)) and the stacked inputs
//! U = F·Y + G·U + H·s. Solved for U: (1 − G − F·D)·U = F·C·z₀ + H·s, put into z_M = Aᴹ·z₀ + [A^(M−1)·B … B]·U: this is
//! A_g = A_D + B_D·(1 − F_D·D_D)⁻¹·F_D·C_D of paper (24). The system is solved as a whole, not tick by tick.

use super::super::super::matrix::Matrix;
use super::peer::Peer;

/// One packet period of one peer.
#[derive(Clone, Debug)]
pub struct Period {
    /// State before → state after.
    pub state: Matrix,
    /// Held input → state after.
    pub held: Matrix,
}

/// Closes the loop over `ticks` ticks.
pub fn close(peer: &Peer, ticks: usize) -> Period {
    let (z, u, s) = (peer.a.rows(), peer.b.columns(), peer.h.columns());
    // Aᵏ for k = 0…M, and AᵏB, F·AᵏB for k = 0…M−1.
    let mut powers = vec![Matrix::identity(z)];
    for k in 0..ticks {
        powers.push(peer.a.times(&powers[k]));
    }
    let steered: Vec<Matrix> = powers[..ticks].iter().map(|power| power.times(&peer.b)).collect();
    let looped: Vec<Matrix> = steered.iter().map(|steered| peer.f.times(steered)).collect();

    let mut loop_matrix = Matrix::identity(u * ticks);
    let mut inputs = Matrix::zeros(u * ticks, z + s);
    for k in 0..ticks {
        loop_matrix.add_block(u * k, u * k, &peer.g, -1.0);
        for l in 0..k {
            loop_matrix.add_block(u * k, u * l, &looped[k - 1 - l], -1.0);
        }
        inputs.add_block(u * k, 0, &peer.f.times(&powers[k]), 1.0);
        inputs.add_block(u * k, z, &peer.h, 1.0);
    }
    loop_matrix.solve_into(&mut inputs);

    let mut reach = Matrix::zeros(z, u * ticks);
    for k in 0..ticks {
        reach.add_block(0, u * k, &steered[ticks - 1 - k], 1.0);
    }
    let after = reach.times(&inputs);
    let mut period = Period { state: powers[ticks].clone(), held: Matrix::zeros(z, s) };
    for j in 0..z {
        for i in 0..z {
            period.state[(i, j)] += after[(i, j)];
        }
    }
    for j in 0..s {
        period.held.column_mut(j).copy_from_slice(after.column(z + j));
    }
    period
}
