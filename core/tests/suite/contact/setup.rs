//! Random numbers from a seed, and sums over bodies in f64, whatever they compute in.

use cohold_core::contact::impact::Body;
use cohold_core::num::{Motion, Scalar};

/// splitmix64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform.
    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Uniform in the logarithm.
    pub(crate) fn scale(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.unit())
    }
}

pub(crate) fn body<S: Scalar, const D: usize>(x: [f64; D], v: [f64; D], radius: f64, mass: f64) -> Body<S, D> {
    let mut axes = [Motion::REST; D];
    for (axis, (x, v)) in axes.iter_mut().zip(x.into_iter().zip(v)) {
        *axis = Motion { position: S::from_f64(x), velocity: S::from_f64(v) };
    }
    Body { axes, radius: S::from_f64(radius), inverse_mass: S::from_f64(1.0 / mass) }
}

/// Mass, as the body has it.
pub(crate) fn mass<S: Scalar, const D: usize>(body: &Body<S, D>) -> f64 {
    1.0 / body.inverse_mass.to_f64()
}

pub(crate) fn energy<S: Scalar, const D: usize>(bodies: &[Body<S, D>]) -> f64 {
    let squares = |body: &Body<S, D>| body.axes.iter().map(|axis| axis.velocity.to_f64().powi(2)).sum::<f64>();
    bodies.iter().map(|body| 0.5 * mass(body) * squares(body)).sum()
}

/// Momentum along one axis, and the sum of its parts without their signs: what rounding is relative to.
pub(crate) fn momentum<S: Scalar, const D: usize>(bodies: &[Body<S, D>], axis: usize) -> (f64, f64) {
    bodies.iter().fold((0.0, 0.0), |(sum, all), body| {
        let part = mass(body) * body.axes[axis].velocity.to_f64();
        (sum + part, all + part.abs())
    })
}
