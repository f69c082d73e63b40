//! The device down to its joints: encoder counts from where the axes are, axis forces from motor duties.
//!
//! Inverse kinematics by Newton's method on the peer's own forward kinematics in f64, from the last pose on.

use haptic_core::device::kinematics::{self, AnyKinematics, KinematicsName};
use haptic_core::device::motor::{Duty, Motor};
use haptic_core::{device::AXES, num::Motion, settings::Settings};

use super::encoders::Encoders;
use crate::scene::PlantSettings;

/// Joints of a simulated device.
#[derive(Clone, Debug)]
pub(super) struct Joints {
    /// The peer reads counts.
    pub(super) encoder: bool,
    kinematics: AnyKinematics<f64>,
    motor: Motor<f64>,
    /// Signed counts per metre or radian.
    counts_per_unit: f64,
    /// Longest step of Newton's method, m or rad: a five-bar's is kept near where its Jacobian holds.
    longest: f64,
    /// Duty codes in one PWM step.
    duty_step: f64,
}

impl Joints {
    pub(super) fn new(settings: &Settings, plant: &PlantSettings) -> Self {
        let counts = kinematics::Joints::of(settings).counts_per_unit;
        Self {
            encoder: plant.encoder,
            kinematics: AnyKinematics::build(settings).expect("a scene that was checked"),
            motor: Motor::build(settings),
            counts_per_unit: if settings.encoder.reversed { -counts } else { counts },
            longest: if settings.kinematics.model == KinematicsName::FiveBar { 0.3 } else { f64::MAX },
            duty_step: match plant.pwm_steps {
                0 => 1.0,
                steps => f64::from(Duty::FULL_SCALE) / f64::from(steps),
            },
        }
    }

    /// Joint positions at which the axes are where `axes` says.
    fn inverse(&self, axes: [Motion<f64>; AXES]) -> [f64; AXES] {
        let mut joints = [0.0; AXES];
        for _ in 0..30 {
            let pose = self.kinematics.forward(joints.map(Motion::at));
            let error = [0, 1].map(|axis: usize| axes[axis].position - pose.axes[axis].position);
            let step = solve(pose.jacobian, error);
            for (joint, step) in joints.iter_mut().zip(step) {
                *joint += step.clamp(-self.longest, self.longest);
            }
            if step.iter().all(|step| step.abs() < 1e-13) {
                break;
            }
        }
        joints
    }

    /// Where the encoders are, counts; from 0 where the device is built.
    pub(super) fn counts(&self, axes: [Motion<f64>; AXES]) -> [i64; AXES] {
        self.inverse(axes).map(|joint| (joint * self.counts_per_unit).floor() as i64)
    }

    /// The encoders of a device that is built here.
    pub(super) fn encoders(&self, settings: &Settings, axes: [Motion<f64>; AXES]) -> Encoders {
        Encoders::new(settings, self.counts_per_unit, self.counts(axes))
    }

    /// Forces on the axes (N) that the duties give.
    pub(super) fn forces(&self, axes: [Motion<f64>; AXES], duties: [Duty; AXES]) -> [f64; AXES] {
        let torques = duties.map(|duty| {
            let stepped = (f64::from(duty.0) / self.duty_step).round() * self.duty_step;
            self.motor.joint_force(Duty(stepped as i16))
        });
        self.pose(axes).forces(torques)
    }

    /// How joints and axes move each other where the axes are now.
    pub(super) fn pose(&self, axes: [Motion<f64>; AXES]) -> Pose {
        Pose(self.kinematics.forward(self.inverse(axes).map(Motion::at)).jacobian)
    }

    /// Positions of the joints (m or rad) as the peer knows them.
    pub(super) fn seen(&self, axes: [Motion<f64>; AXES]) -> [f64; AXES] {
        let joints = self.inverse(axes);
        if !self.encoder {
            return joints;
        }
        joints.map(|joint| (joint * self.counts_per_unit).floor() / self.counts_per_unit)
    }
}

/// The Jacobian of one pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose([[f64; AXES]; AXES]);

impl Pose {
    /// Speeds of the joints, m/s or rad/s, of axes that move: J·q̇ = ẋ solved for q̇.
    pub(super) fn speeds(&self, axes: [Motion<f64>; AXES]) -> [f64; AXES] {
        solve(self.0, axes.map(|axis| axis.velocity))
    }

    /// Forces on the axes (N) that those of the joints give: Jᵀ·F = τ solved for F.
    pub(super) fn forces(&self, joints: [f64; AXES]) -> [f64; AXES] {
        let [[a, b], [c, d]] = self.0;
        solve([[a, c], [b, d]], joints)
    }
}

/// Solves a 2×2 system; a direction that the matrix does not reach gets 0.
fn solve([[a, b], [c, d]]: [[f64; 2]; 2], [e, f]: [f64; 2]) -> [f64; 2] {
    let determinant = a * d - b * c;
    if determinant != 0.0 {
        [(e * d - b * f) / determinant, (a * f - e * c) / determinant]
    } else if a != 0.0 {
        [e / a, 0.0]
    } else {
        [0.0, 0.0]
    }
}
