//! The force that holds an axis on its line: a spring and a damper to position zero.
//!
//! Design: the papers' experiments are along one axis; a device that has two needs the other one held. The hold is a
//! proportional-derivative law, F = −(k·x + b·v), in the task's coordinates, so that it works through any mechanism.
//!
//! Units: m, m/s, N; k in N/m, b in N·s/m, both ≥ 0.
//!
//! Limits: sampled every T_c, without delay and on a mass m, it is stable exactly for k·T_c/2 < b < 2m/T_c; a delay
//! narrows that. The force is unlimited here, [`crate::safety`] limits it. NaN in, NaN out.

use crate::num::{Motion, Scalar};
use crate::settings::Settings;

/// A spring and a damper between an axis and position zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold<S> {
    stiffness_n_per_m: S,
    damping_n_s_per_m: S,
}

configured!([S: Scalar] Hold<S> { stiffness_n_per_m, damping_n_s_per_m });

impl<S: Scalar> Hold<S> {
    /// From `axis.hold_stiffness_n_per_m` and `axis.hold_damping_n_s_per_m`.
    pub fn build(settings: &Settings) -> Self {
        Self {
            stiffness_n_per_m: S::from_f64(settings.axis.hold_stiffness_n_per_m),
            damping_n_s_per_m: S::from_f64(settings.axis.hold_damping_n_s_per_m),
        }
    }

    /// Force on the axis, N, toward position zero and against the motion.
    #[inline]
    pub fn force(&self, at: Motion<S>) -> S {
        -(self.stiffness_n_per_m * at.position + self.damping_n_s_per_m * at.velocity)
    }
}
