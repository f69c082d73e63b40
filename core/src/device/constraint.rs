//! The force that holds an axis on its line: a spring and a damper to position zero.
//!
//! Design: the papers' experiments are along one axis; a device that has two needs the other one held. The hold is a
//! proportional-derivative law, F = −(k·x + b·v), in the task's coordinates, so that it works through any mechanism.
//!
//! Units: m, m/s, N; k in N/m, b in N·s/m, both ≥ 0.
//!
//! Limits: sampled every T_c, without delay and on a mass m, it is stable exactly for k·T_c/2 < b < 2m/T_c; a delay
//! narrows that. The force is unlimited here; where [`crate::safety`] limits it, the line slips and comes back, as the contact with the object
//! does ([`crate::contact::grip`]). NaN in, NaN out.

use crate::contact::Grip;
use crate::num::{Motion, Scalar};
use crate::settings::Settings;

/// A spring and a damper between an axis and position zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold<S> {
    stiffness_n_per_m: S,
    damping_n_s_per_m: S,
    period_s: S,
}

configured!([S: Scalar] Hold<S> { stiffness_n_per_m, damping_n_s_per_m, period_s });

impl<S: Scalar> Hold<S> {
    /// From `axis.hold_stiffness_n_per_m` and `axis.hold_damping_n_s_per_m`.
    pub fn build(settings: &Settings) -> Self {
        Self {
            stiffness_n_per_m: S::from_f64(settings.axis.hold_stiffness_n_per_m),
            damping_n_s_per_m: S::from_f64(settings.axis.hold_damping_n_s_per_m),
            period_s: S::from_f64(settings.timing.control_period_s),
        }
    }

    /// Force on the axis, N, toward position zero and against the motion.
    #[inline]
    pub fn force(&self, at: Motion<S>) -> S {
        -(self.stiffness_n_per_m * at.position + self.damping_n_s_per_m * at.velocity)
    }

    /// [`Hold::force`] on an axis whose line has slipped, and goes back.
    pub(crate) fn gripped(&self, grip: &mut Grip<S>, at: Motion<S>) -> S {
        if !grip.is_firm() {
            grip.recover(at.position, self.stiffness_n_per_m, self.period_s);
        }
        self.force(Motion { position: at.position - grip.slip_m(), ..at })
    }

    /// The line slips: of the push against it as much is missing as `missing`, and `given` is what is left, N.
    #[inline(always)]
    pub(crate) fn slide(&self, grip: &mut Grip<S>, missing: S, given: S) {
        let impedance = self.stiffness_n_per_m * self.period_s + self.damping_n_s_per_m;
        grip.slide(missing, given, impedance, self.period_s);
    }
}
