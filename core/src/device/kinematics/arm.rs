//! Serial arm in space: three motors at its base, two links, the outer one held upright by a parallelogram.
//!
//! ```text
//!        y (axis 1, up)          side view, q₁ = 0
//!        ↑      ╷
//!        │      │  fore link l₂, q₃ from upright, whatever q₂ is
//!        │      │
//!        o──────P→ z (axis 2, away from the base), x (axis 0) toward the reader, origin at the hand's home
//!  base  upper link l₁, q₂ from level, both turned about y by q₁
//! ```
//!
//! x = r·sin q₁, y = l₂ − l₂·cos q₃ + l₁·sin q₂, z = r·cos q₁ − l₁, with the reach r = l₁·cos q₂ + l₂·sin q₃ (Çavuşoğlu, Feygin and
//! Tendick, "A critical study of the mechanical and electrical properties of the PHANToM haptic interface and improvements for
//! high-performance control", Presence 11(6), 2002, eq. 1). The Jacobian is its derivative; |det J| = r·l₁·l₂·cos(q₂ − q₃). Home, where the
//! joints are zero and the encoders are first read, has the upper link level and the fore link upright: J = diag(l₁, l₁, l₂).
//!
//! Units: joints rad, axes m, Jacobian m/rad. Keys: l₁ is `kinematics.proximal_m`, l₂ `kinematics.distal_m`.
//!
//! Limits: where both links are nearly in line (cos(q₂ − q₃) under [`MIN_SHARE`]) or the hand is nearly over the base (r under
//! [`MIN_SHARE`]·l₁) the pose is singular: the Jacobian is zero, and with it the velocities and the motor torques; a peer that renders in
//! more than one direction faults there. The position stays exact. A non-finite joint gives a non-finite position or a zero Jacobian. With
//! `kinematics.maths = "micromath"` the hand is off by up to 3 mm per m of link.

use crate::device::kinematics::{Kinematics, Maths, Pose};
use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::{Allowed, Refused, Settings};

/// Smallest cosine of q₂ − q₃, and smallest reach in lengths of the upper link; under either a pose is singular.
pub const MIN_SHARE: f64 = 0.05;
/// Smallest cosine of q₂ − q₃ that plausibility limits of encoder speed are computed for.
pub(crate) const MIN_ELBOW_COSINE: f64 = 0.25;

/// Lengths of the arm, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm<S> {
    maths: Maths,
    upper: S,
    fore: S,
    least_cosine: S,
    least_reach: S,
}

configured!([S: Scalar] Arm<S> { maths, upper, fore, least_cosine, least_reach });

impl<S: Scalar> Model<S> for Arm<S> {
    type State = ();

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        settings.within("axis.count", Allowed::Whole { min: 3, max: 3 })?;
        let kinematics = &settings.kinematics;
        Ok(Self {
            maths: kinematics.maths,
            upper: S::from_f64(kinematics.proximal_m),
            fore: S::from_f64(kinematics.distal_m),
            least_cosine: S::from_f64(MIN_SHARE),
            least_reach: S::from_f64(MIN_SHARE * kinematics.proximal_m),
        })
    }
}

impl<S: Scalar> Kinematics<S, 3> for Arm<S> {
    fn forward(&self, joints: [Motion<S>; 3]) -> Pose<S, 3> {
        let [(sin_1, cos_1), (sin_2, cos_2), (sin_3, cos_3)] = joints.map(|joint| self.maths.sin_cos(joint.position));
        // Along and up of each link; that up of the fore link is measured from its top.
        let (along, up) = (self.upper * cos_2, self.upper * sin_2);
        let (fore_along, fore_up) = (self.fore * sin_3, self.fore * cos_3);
        let reach = along + fore_along;
        let position = [reach * sin_1, (self.fore - fore_up) + up, reach * cos_1 - self.upper];
        let regular = cos_2 * cos_3 + sin_2 * sin_3 > self.least_cosine && reach > self.least_reach;
        if !regular {
            return Pose::moving(position, [[S::ZERO; 3]; 3], joints);
        }
        let jacobian = [
            [reach * cos_1, -(up * sin_1), fore_up * sin_1],
            [S::ZERO, along, fore_along],
            [-(reach * sin_1), -(up * cos_1), fore_up * cos_1],
        ];
        Pose::moving(position, jacobian, joints)
    }
}
