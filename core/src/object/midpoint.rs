//! The implicit midpoint rule: one solve a tick for everything that pushes on the copy.
//!
//! With every push a [`Port`], F = f − z·v, the mean velocity of the tick is
//!
//! > v = (2m_O/T_c·ẋ_o + Σf)/(2m_O/T_c + b_O + Σz),   x_o ← x_o + T_c·v,   ẋ_o ← 2v − ẋ_o
//!
//! (THEORY §7). ½·m_O·ẋ_o² changes by exactly T_c·(ΣF·v − b_O·v²): what no damper takes is neither made nor lost, at any
//! stiffness. Computed as the change 2(v − ẋ_o), which is small where v itself is not, and summed with its rounding.
//!
//! [`super::backward_euler`] is the same solve with other numbers: m_O/T_c for 2m_O/T_c, and ẋ_o ← v.

use super::Integrator;
use super::port::Port;
use crate::model::Model;
use crate::names::Decode;
use crate::num::{Carry, Motion, Scalar};
use crate::settings::{Allowed, Refused, Settings};

/// A mass that is moved by ports, by the midpoint rule or by backward Euler.
#[derive(Clone, Copy, Debug)]
pub struct Midpoint<S> {
    period: S,
    /// m_O/(θ·T_c), N·s/m: 2m_O/T_c.
    inertia: S,
    /// b_O, N·s/m.
    damping: S,
    /// 1/θ: change of velocity over v − ẋ_o, which is half of it.
    whole: S,
}

configured!([S: Scalar] Midpoint<S> { period, inertia, damping, whole });

/// Rounding errors that position and velocity still owe; no state of the object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Carries<S> {
    position: Carry<S>,
    velocity: Carry<S>,
}

visited!([S: Scalar] Carries<S> {});

impl<S: Scalar> Midpoint<S> {
    /// Half of the velocity change of a tick under these ports, v − ẋ_o, m/s: mean velocity less the one that the
    /// tick begins with. The whole change with backward Euler.
    #[inline]
    pub fn half_change(&self, velocity: S, ports: Port<S>) -> S {
        let resistance = self.damping + ports.impedance;
        (ports.force - resistance * velocity).ratio(self.inertia + resistance)
    }

    /// The motion one control period later, after this half change.
    #[inline]
    pub fn advance(&self, carries: &mut Carries<S>, motion: Motion<S>, half_change: S) -> Motion<S> {
        Motion {
            position: carries.position.add(motion.position, self.period * (motion.velocity + half_change)),
            velocity: carries.velocity.add(motion.velocity, self.whole * half_change),
        }
    }
}

impl<S: Scalar> Model<S> for Midpoint<S> {
    type State = Carries<S>;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let (period, object) = (settings.timing.control_period_s, &settings.object);
        let needs = |name, what| Err(settings.refuses(name, Allowed::Only(what)));
        if settings.coordination.decode != Decode::Implicit {
            return needs(
                "coordination.decode",
                "\"implicit\" where object.integrator is \"midpoint\" or \"backward-euler\": one solve decodes and moves",
            );
        }
        if object.force_delay_ticks != 0.0 {
            return needs(
                "object.force_delay_ticks",
                "0 where object.integrator is \"midpoint\" or \"backward-euler\": forces act in the tick they are solved for",
            );
        }
        let part = object.integrator.part_of_tick();
        Ok(Self {
            period: S::from_f64(period),
            inertia: S::from_f64(object.mass_kg / part / period),
            damping: S::from_f64(object.damping_n_s_per_m),
            whole: S::from_f64(1.0 / part),
        })
    }
}

/// Under a force that does not depend on the copy.
impl<S: Scalar> Integrator<S> for Midpoint<S> {
    #[inline]
    fn step(&self, carries: &mut Carries<S>, motion: Motion<S>, force: S) -> Motion<S> {
        self.advance(carries, motion, self.half_change(motion.velocity, Port::of_force(force)))
    }
}
