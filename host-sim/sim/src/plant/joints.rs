//! The device down to its joints: encoder counts from where the axes are, axis forces from motor duties.
//!
//! Inverse kinematics by Newton's method on the peer's own forward kinematics in f64, from the last pose on.

use std::array::from_fn;

use cohold_core::device::kinematics::{self, AnyKinematics, AnySpatial, KinematicsName};
use cohold_core::device::motor::{Duty, Motor};
use cohold_core::{num::Motion, settings::Settings};

use super::encoders::Encoders;
use crate::scene::PlantSettings;

/// Joints of a simulated device.
#[derive(Clone, Debug)]
pub(super) struct Joints {
    /// The peer reads counts.
    pub(super) encoder: bool,
    kinematics: Mechanism,
    motor: Motor<f64>,
    /// Signed counts per metre or radian.
    counts_per_unit: f64,
    /// Longest step of Newton's method, m or rad: that of links is kept near where their Jacobian holds.
    longest: f64,
    /// Duty codes in one PWM step.
    duty_step: f64,
}

impl Joints {
    pub(super) fn new(settings: &Settings, plant: &PlantSettings) -> Self {
        let counts = kinematics::Joints::of(settings).counts_per_unit;
        Self {
            encoder: plant.encoder,
            kinematics: Mechanism::new(settings),
            motor: Motor::build(settings),
            counts_per_unit: if settings.encoder.reversed { -counts } else { counts },
            longest: match settings.kinematics.model {
                KinematicsName::FiveBar | KinematicsName::Arm => 0.3,
                KinematicsName::Direct | KinematicsName::Capstan => f64::MAX,
            },
            duty_step: match plant.pwm_steps {
                0 => 1.0,
                steps => f64::from(Duty::FULL_SCALE) / f64::from(steps),
            },
        }
    }

    /// Where the hand is with the joints there (m or rad), m from where it is at home, and how they move each other.
    pub(super) fn at<const N: usize>(&self, joints: [f64; N]) -> ([f64; N], Pose<N>) {
        let (hand, jacobian) = self.kinematics.forward(joints);
        (hand, Pose(jacobian))
    }

    /// Joint positions at which the axes are where `axes` says.
    fn inverse<const N: usize>(&self, axes: [Motion<f64>; N]) -> [f64; N] {
        self.inverse_from([0.0; N], axes)
    }

    /// Joint positions at which the axes are where `axes` says, looked for from those positions on.
    pub(super) fn inverse_from<const N: usize>(&self, mut joints: [f64; N], axes: [Motion<f64>; N]) -> [f64; N] {
        for _ in 0..30 {
            let (hand, jacobian) = self.kinematics.forward(joints);
            let step = solve(jacobian, from_fn(|axis| axes[axis].position - hand[axis]));
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
    pub(super) fn counts<const N: usize>(&self, axes: [Motion<f64>; N]) -> [i64; N] {
        self.counted(self.inverse(axes))
    }

    /// [`Joints::counts`] of joints that are there, m or rad.
    pub(super) fn counted<const N: usize>(&self, joints: [f64; N]) -> [i64; N] {
        joints.map(|joint| (joint * self.counts_per_unit).floor() as i64)
    }

    /// The encoders of a device whose joints are at these counts.
    pub(super) fn encoders<const N: usize>(&self, settings: &Settings, at: [i64; N]) -> Encoders<N> {
        Encoders::new(settings, self.counts_per_unit, at)
    }

    /// Forces of the joints (N or N·m) that the duties give.
    pub(super) fn torques<const N: usize>(&self, duties: [Duty; N]) -> [f64; N] {
        duties.map(|duty| {
            let stepped = (f64::from(duty.0) / self.duty_step).round() * self.duty_step;
            self.motor.joint_force(Duty(stepped as i16))
        })
    }

    /// J⁻¹, `[joint][axis]`, where every joint is zero.
    pub(super) fn inverse_at_home<const N: usize>(&self) -> [[f64; N]; N] {
        let (_, jacobian) = self.kinematics.forward([0.0; N]);
        let columns: [[f64; N]; N] = from_fn(|axis| solve(jacobian, from_fn(|row| f64::from(u8::from(row == axis)))));
        from_fn(|joint| columns.map(|column| column[joint]))
    }

    /// How joints and axes move each other where the axes are now.
    pub(super) fn pose<const N: usize>(&self, axes: [Motion<f64>; N]) -> Pose<N> {
        Pose(self.kinematics.forward(self.inverse(axes)).1)
    }

    /// Positions of the joints (m or rad) as the peer knows them.
    pub(super) fn seen<const N: usize>(&self, axes: [Motion<f64>; N]) -> [f64; N] {
        self.told(self.inverse(axes))
    }

    /// [`Joints::seen`] of joints that are there, m or rad.
    pub(super) fn told<const N: usize>(&self, joints: [f64; N]) -> [f64; N] {
        if !self.encoder {
            return joints;
        }
        joints.map(|joint| (joint * self.counts_per_unit).floor() / self.counts_per_unit)
    }
}

/// The Jacobian of one pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose<const N: usize>([[f64; N]; N]);

impl<const N: usize> Pose<N> {
    /// Speeds of the joints, m/s or rad/s, of axes that move: J·q̇ = ẋ solved for q̇.
    pub(super) fn speeds(&self, axes: [Motion<f64>; N]) -> [f64; N] {
        solve(self.0, axes.map(|axis| axis.velocity))
    }

    /// Forces on the axes (N) that those of the joints give: Jᵀ·F = τ solved for F.
    pub(super) fn forces(&self, joints: [f64; N]) -> [f64; N] {
        solve(from_fn(|row| from_fn(|column| self.0[column][row])), joints)
    }

    /// Forces of the joints that act on the axes like these (N): τ = Jᵀ·F.
    pub(super) fn torques(&self, forces: [f64; N]) -> [f64; N] {
        from_fn(|joint| (0..N).map(|axis| self.0[axis][joint] * forces[axis]).sum())
    }

    /// Velocities of the axes (m/s) that joints at these speeds give: ẋ = J·q̇.
    pub(super) fn velocities(&self, joints: [f64; N]) -> [f64; N] {
        self.0.map(|row| row.iter().zip(&joints).map(|(share, speed)| share * speed).sum())
    }

    /// Accelerations of joints of this inertia under these forces, with a mass (kg) at the hand: (J_m·1 + m·Jᵀ·J)·q̈ = τ solved for q̈.
    pub(super) fn accelerations(&self, mass: f64, inertia: f64, torques: [f64; N]) -> [f64; N] {
        let weighs = |row: usize, column: usize| {
            let at_hand: f64 = (0..N).map(|axis| self.0[axis][row] * self.0[axis][column]).sum();
            mass * at_hand + if row == column { inertia } else { 0.0 }
        };
        solve(from_fn(|row| from_fn(|column| weighs(row, column))), torques)
    }

    /// Whether the mechanism reports that its pose is singular: then no direction is reached.
    pub(super) fn is_singular(&self) -> bool {
        self.0.as_flattened().iter().all(|share| *share == 0.0)
    }
}

/// The peer's own forward kinematics, of as many axes as the device has.
#[derive(Clone, Copy, Debug)]
enum Mechanism {
    Plane(AnyKinematics<f64>),
    Space(AnySpatial<f64>),
}

impl Mechanism {
    fn new(settings: &Settings) -> Self {
        let checked = "a scene that was checked";
        if settings.axis.count > 2 {
            Self::Space(AnySpatial::build(settings).expect(checked))
        } else {
            Self::Plane(AnyKinematics::build(settings).expect(checked))
        }
    }

    /// Where the axes are with the joints there, and the Jacobian.
    fn forward<const N: usize>(&self, joints: [f64; N]) -> ([f64; N], [[f64; N]; N]) {
        fn wide<const N: usize, const M: usize>(joints: [f64; N]) -> [Motion<f64>; M] {
            from_fn(|joint| Motion::at(joints.get(joint).copied().unwrap_or_default()))
        }
        let gather = |axes: &[Motion<f64>], rows: &dyn Fn(usize, usize) -> f64| {
            (from_fn(|axis| axes[axis].position), from_fn(|axis| from_fn(|joint| rows(axis, joint))))
        };
        match self {
            Self::Plane(mechanism) => {
                let pose = mechanism.forward(wide(joints));
                gather(&pose.axes, &|axis, joint| pose.jacobian[axis][joint])
            }
            Self::Space(mechanism) => {
                let pose = mechanism.forward(wide(joints));
                gather(&pose.axes, &|axis, joint| pose.jacobian[axis][joint])
            }
        }
    }
}

/// Solves a 2×2 or 3×3 system by Cramer's rule. A direction that the matrix does not reach gets 0.
fn solve<const N: usize>(matrix: [[f64; N]; N], right: [f64; N]) -> [f64; N] {
    let mut solution = [0.0; N];
    match (matrix.as_flattened(), right.as_slice(), solution.as_mut_slice()) {
        (&[a, b, c, d], &[e, f], [x, y]) => {
            let determinant = a * d - b * c;
            (*x, *y) = if determinant != 0.0 {
                ((e * d - b * f) / determinant, (a * f - e * c) / determinant)
            } else if a != 0.0 {
                (e / a, 0.0)
            } else {
                (0.0, 0.0)
            };
        }
        (rows, right, solution) if N == 3 => {
            let row = |at: usize| [rows[3 * at], rows[3 * at + 1], rows[3 * at + 2]];
            let cross = |[a, b, c]: [f64; 3], [d, e, f]: [f64; 3]| [b * f - c * e, c * d - a * f, a * e - b * d];
            // The columns of the inverse times the determinant.
            let columns = [cross(row(1), row(2)), cross(row(2), row(0)), cross(row(0), row(1))];
            let determinant: f64 = (0..3).map(|at| row(0)[at] * columns[0][at]).sum();
            if determinant != 0.0 {
                for (at, unknown) in solution.iter_mut().enumerate() {
                    *unknown =
                        (0..3).map(|equation| columns[equation][at] * right[equation]).sum::<f64>() / determinant;
                }
            }
        }
        _ => unreachable!("a device has two axes or three"),
    }
    solution
}
