//! One motor turns a paddle through a capstan drive: the "haptic paddle".
//!
//! x = (r/N)·q: the hand at distance r from the paddle's axis, N motor turns per paddle turn. x is measured along the
//! arc, so the Jacobian is the constant r/N and no angle enters. The second joint is ignored, the second axis is at
//! rest.
//!
//! Units: q in rad, x in m. Limits: no cable stretch, no slip. A positive motor angle is a positive x; turn it with
//! `encoder.reversed` and `motor.reversed`.

use crate::device::kinematics::{Kinematics, Pose};
use crate::num::{Motion, Scalar};
use crate::settings::{Allowed, Refused, Settings};
use crate::{device::AXES, model::Model};

/// Metres along the arc per radian of the motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capstan<S> {
    m_per_rad: S,
}

configured!([S: Scalar] Capstan<S> { m_per_rad });

impl<S: Scalar> Model<S> for Capstan<S> {
    type State = ();
    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        settings.within("axis.count", Allowed::Whole { min: 1, max: 1 })?;
        let kinematics = &settings.kinematics;
        Ok(Self { m_per_rad: S::from_f64(kinematics.paddle_radius_m / kinematics.capstan_ratio) })
    }
}

impl<S: Scalar> Kinematics<S> for Capstan<S> {
    #[inline]
    fn forward(&self, [motor, _]: [Motion<S>; AXES]) -> Pose<S> {
        let arc = Motion { position: self.m_per_rad * motor.position, velocity: self.m_per_rad * motor.velocity };
        Pose { axes: [arc, Motion::REST], jacobian: [[self.m_per_rad, S::ZERO], [S::ZERO, S::ZERO]] }
    }
}
