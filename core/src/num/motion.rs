//! Position and velocity of one degree of freedom.

use super::scalar::Scalar;
use super::vector::StateVector;

/// Position (m) and velocity (m/s) along one axis; for a joint that turns, rad and rad/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion<S> {
    /// Position, m.
    pub position: S,
    /// Velocity, m/s.
    pub velocity: S,
}

impl<S: Scalar> Motion<S> {
    /// At rest at the origin.
    pub const REST: Self = Self { position: S::ZERO, velocity: S::ZERO };

    /// At rest at `position` (m).
    pub fn at(position: S) -> Self {
        Self { position, velocity: S::ZERO }
    }

    /// Both components finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.position.is_finite() && self.velocity.is_finite()
    }
}

impl<S> StateVector<S> for Motion<S> {
    #[inline]
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        each(&mut self.position);
        each(&mut self.velocity);
    }
}
