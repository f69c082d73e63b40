//! Each joint is an axis: the Jacobian is the identity.
//!
//! Units: joints and axes m, m/s. For slides, and for simulated devices.

use crate::device::AXES;
use crate::device::kinematics::{Kinematics, Pose};
use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};

/// No mechanism between joints and axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Direct;

impl<S: Scalar> Model<S> for Direct {
    type State = ();
    fn build(_: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self)
    }
}

impl<S: Scalar> Kinematics<S> for Direct {
    #[inline]
    fn forward(&self, joints: [Motion<S>; AXES]) -> Pose<S> {
        Pose::direct(joints)
    }
}
