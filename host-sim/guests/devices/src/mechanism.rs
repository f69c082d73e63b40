//! From turning motors to the hand, and from forces on it to their torques: the scene's `kinematics`, by the very code of a board
//! ([`cohold_core::device::kinematics`]), in f64.
//!
//! Angles are rad from the pose that the scene calls home, positions m from where the hand is then. A force F on the hand takes the torques
//! Jᵀ·F; where they are more than a motor may give, all of them become smaller together, so that the force keeps its direction.

use cohold_core::device::kinematics::{AnyKinematics, AnySpatial, KinematicsName};
use cohold_core::num::Motion;
use cohold_core::settings::Settings;

use cohold_live::Error;
use cohold_live::devices::AXES;

/// A scene's mechanism.
pub(super) enum Mechanism {
    /// One axis or two.
    Plane(AnyKinematics<f64>),
    /// Three.
    Space(AnySpatial<f64>),
}

/// Where the hand is, and how it moves with the joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    pub(super) position_m: [f64; AXES],
    pub(super) velocity_m_per_s: [f64; AXES],
    /// By axis and joint, m/rad; zero where the motors cannot push the hand along each axis.
    jacobian: [[f64; AXES]; AXES],
}

impl Mechanism {
    /// The mechanism of these settings, which so many motors drive.
    ///
    /// # Errors
    /// Another number of motors, a slide, or lengths with which it cannot be assembled.
    pub(super) fn build(settings: &Settings, motors: usize) -> Result<Self, Error> {
        let model = settings.kinematics.model;
        let needed = match model {
            KinematicsName::Direct => {
                return Err("kinematics.model is \"direct\", which is a slide: motors that turn need \"capstan\", \"five-bar\" or \"arm\"".into());
            }
            KinematicsName::Capstan => 1,
            KinematicsName::FiveBar => 2,
            KinematicsName::Arm => 3,
        };
        cohold_sim::refuse_if!(
            motors != needed,
            "{motors} motors are named, and this scene's mechanism (kinematics.model) has {needed}"
        );
        let refused = |cause: cohold_core::settings::Refused<'_>| Error::from(cause.to_string());
        Ok(match model {
            KinematicsName::Arm => Self::Space(AnySpatial::build(settings).map_err(refused)?),
            _ => Self::Plane(AnyKinematics::build(settings).map_err(refused)?),
        })
    }

    /// The pose of joints at these angles, rad, and speeds, rad/s; those that it has not are ignored.
    pub(super) fn pose(&self, angle_rad: [f64; AXES], speed_rad_per_s: [f64; AXES]) -> Pose {
        let joint = |at: usize| Motion::new(angle_rad[at], speed_rad_per_s[at]);
        let mut pose = Pose { position_m: [0.0; AXES], velocity_m_per_s: [0.0; AXES], jacobian: [[0.0; AXES]; AXES] };
        let mut take = |axes: &[Motion<f64>], rows: &[&[f64]]| {
            for (at, (axis, row)) in axes.iter().zip(rows).enumerate() {
                (pose.position_m[at], pose.velocity_m_per_s[at]) = (axis.position, axis.velocity);
                pose.jacobian[at][..row.len()].copy_from_slice(row);
            }
        };
        match self {
            Self::Plane(model) => {
                let found = model.forward([joint(0), joint(1)]);
                take(&found.axes, &found.jacobian.each_ref().map(|row| row.as_slice()));
            }
            Self::Space(model) => {
                let found = model.forward([joint(0), joint(1), joint(2)]);
                take(&found.axes, &found.jacobian.each_ref().map(|row| row.as_slice()));
            }
        }
        pose
    }
}

impl Pose {
    /// Whether the motors cannot push the hand here.
    pub(super) fn is_singular(&self) -> bool {
        self.jacobian.as_flattened().iter().all(|share| *share == 0.0)
    }

    /// The torques for a force on the hand, none above `most_nm`.
    pub(super) fn torques(&self, force_n: [f64; AXES], most_nm: f64) -> [f64; AXES] {
        let mut torques = [0.0; AXES];
        for (row, force) in self.jacobian.iter().zip(force_n) {
            for (torque, share) in torques.iter_mut().zip(row) {
                *torque += share * force;
            }
        }
        let largest = torques.iter().fold(0.0, |most: f64, torque| most.max(torque.abs()));
        let share = if largest > most_nm { most_nm / largest } else { 1.0 };
        torques.map(|torque| share * torque)
    }

    /// The force that these motors can give along each axis that they move, N.
    pub(super) fn weakest_n(&self, most_nm: f64) -> f64 {
        let largest = |row: &[f64; AXES]| row.iter().fold(0.0, |most: f64, share| most.max(share.abs()));
        self.jacobian
            .iter()
            .map(largest)
            .filter(|share| *share > 0.0)
            .map(|share| most_nm / share)
            .fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
#[path = "../tests/inside/mechanism.rs"]
mod tests;
