//! Lossless node: N wave lines that meet in one point and share its velocity (THEORY §5, last bullet).
//!
//! With u_i the wave that comes out of line i, its impedance b_i and no force left over at the point,
//!
//! > v = Σ√(2b_i)·u_i / Σb_i,   w_i = √(2b_i)·v − u_i
//!
//! go back into the lines, in O(N). Σw_i² = Σu_i²: the node stores and makes no energy, so N lines that are passive make a
//! passive whole. (THEORY writes w_i with the other sign; here it is u_in of the line, as a peer takes it in: two lines of
//! equal impedance are simply joined, w_1 = u_2.) A port of impedance 0 is closed: nothing comes out of it.
//!
//! **Limits**: lossless to rounding, a few ulp of Σu². A wave held through a loss is no longer the line's: a node keeps to
//! networks of constant delay without loss.

use cohold_core::num::Scalar;

/// The node in which up to `N` lines meet.
#[derive(Clone, Copy, Debug)]
pub struct Node<S, const N: usize> {
    /// √(2b_i).
    roots: [S; N],
    /// 1/Σb_i; 0 where all ports are closed.
    inverse_sum: S,
}

/// Answer of the node to the incoming waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered<S, const N: usize> {
    /// Velocity that all lines share at the node, m/s.
    pub velocity: S,
    /// Waves back into the lines, √W.
    pub back: [S; N],
}

impl<S: Scalar, const N: usize> Node<S, N> {
    /// A node of lines with these impedances, N·s/m, none negative; 0 closes the port.
    pub fn new(impedances_n_s_per_m: [f64; N]) -> Self {
        let sum: f64 = impedances_n_s_per_m.iter().sum();
        Self {
            roots: impedances_n_s_per_m.map(|b| S::from_f64(libm::sqrt(2.0 * b))),
            inverse_sum: S::from_f64(if sum > 0.0 { 1.0 / sum } else { 0.0 }),
        }
    }

    /// One packet period: the velocity of the node and the waves back into the lines, from the wave out of each line, √W.
    pub fn scatter(&self, waves: [S; N]) -> Scattered<S, N> {
        let sum = self.roots.iter().zip(waves).fold(S::ZERO, |sum, (root, wave)| sum + *root * wave);
        let velocity = sum * self.inverse_sum;
        let mut back = self.roots;
        for (back, wave) in back.iter_mut().zip(waves) {
            *back = *back * velocity - if *back == S::ZERO { S::ZERO } else { wave };
        }
        Scattered { velocity, back }
    }
}
