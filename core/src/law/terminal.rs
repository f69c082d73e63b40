//! The end of a wave line behind the coordination spring, as a port of the object (THEORY §7).
//!
//! With s = x_d − x_o as the tick begins, w the mean velocity of x_d, v that of the copy, κ = K_T·T_c/2 + B_T:
//!
//! > F_T = K_T·s + κ·(w − v),   b·w + F_T = √(2b)·u_in,   u_out = (b·w − F_T)/√(2b)
//!
//! so that the line's end and the spring in a row are f = K_T·s + κ·(√(2b)·u_in − K_T·s)/(b + κ), z = κ·b/(b + κ). An end
//! that stands (w = 0, [`Terminal::solve_grounded`]) is the spring to a wall: f = K_T·s, z = κ.

use super::Spring;
use crate::num::Scalar;
use crate::object::{Port, Solve};
use crate::settings::Settings;

/// Spring and line in a row.
#[derive(Clone, Copy, Debug)]
pub struct Terminal<S> {
    /// The coordination spring.
    pub spring: Spring<S>,
    /// κ, N·s/m.
    kappa: S,
    /// Wave scale √(2b), √(N·s/m).
    pub root: S,
    /// 1/(b + κ).
    inverse_sum: S,
    /// κ/(b + κ), the part of the drive that reaches the object.
    share: S,
    /// z, N·s/m.
    impedance: S,
    /// √(b/2), the part of u_out that is velocity.
    velocity_to_wave: S,
    /// 1/√(2b), the part of u_out that is force.
    force_to_wave: S,
}

configured!([S: Scalar] Terminal<S> { spring, kappa, root, inverse_sum, share, impedance, velocity_to_wave, force_to_wave });

/// What came of a tick at the end of a line.
#[derive(Clone, Copy, Debug)]
pub struct TerminalState<S> {
    /// Mean velocity w of the line's end, m/s.
    pub velocity: S,
    /// Mean velocity v of the copy, m/s.
    pub copy: S,
    /// F_T on the copy, N.
    pub force: S,
}

impl<S: Scalar> Terminal<S> {
    /// The end of a line with the scene's b, K_T and B_T.
    pub fn build(settings: &Settings) -> Self {
        let kappa = Spring::<S>::impedance(settings);
        let impedance = settings.coordination.wave_impedance_n_s_per_m;
        let root = libm::sqrt(2.0 * impedance);
        Self {
            spring: Spring::build(settings),
            kappa: S::from_f64(kappa),
            root: S::from_f64(root),
            inverse_sum: S::from_f64(1.0 / (impedance + kappa)),
            share: S::from_f64(kappa / (impedance + kappa)),
            impedance: S::from_f64(impedance * kappa / (impedance + kappa)),
            velocity_to_wave: S::from_f64(libm::sqrt(impedance / 2.0)),
            force_to_wave: S::from_f64(1.0 / root),
        }
    }

    /// What the spring pulls with from this stretch (m) while nothing moves, N.
    #[inline]
    pub fn spring_force(&self, stretch: S) -> S {
        self.spring.stiffness * stretch
    }

    /// A tick with a wave coming in, √W, in which the spring begins with this pull, N.
    #[inline]
    pub fn solve(&self, pull: S, wave_in: S, solve: impl Solve<S>) -> TerminalState<S> {
        // b·w = drive − κ·(w − v): what is left of the wave's push once the spring has taken its part.
        let drive = self.root * wave_in - pull;
        let port = Port::new(pull + self.share * drive, self.impedance);
        let mean = solve.velocity(port);
        let velocity = (drive + self.kappa * mean) * self.inverse_sum;
        TerminalState { velocity, copy: mean, force: port.at(mean) }
    }

    /// A tick in which the line's end stands, behind a spring of this pull (N) and impedance (N·s/m).
    #[inline]
    pub fn solve_grounded(pull: S, impedance: S, solve: impl Solve<S>) -> TerminalState<S> {
        let port = Port::new(pull, impedance);
        let mean = solve.velocity(port);
        TerminalState { velocity: S::ZERO, copy: mean, force: port.at(mean) }
    }

    /// Outgoing wave u_out, √W.
    #[inline]
    pub fn wave_out(&self, velocity: S, force: S) -> S {
        self.velocity_to_wave * velocity - self.force_to_wave * force
    }
}
