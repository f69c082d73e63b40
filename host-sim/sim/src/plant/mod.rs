//! The software plant: one haptic device in the hand of its user.
//!
//! m·ẍ + b·ẋ + k·x = F_motor + F_user along every axis, advanced exactly (matrix exponential) for forces that are constant
//! in pieces: the old motor force for τ of a tick, then the new one; the user's force, sampled at the start of the tick,
//! for the whole tick. k and parts of m and b are the user's arm, when the scene has one. Always f64, whatever the peer
//! computes in: the world does not round.
//!
//! Imperfections, each only when the scene asks: Coulomb friction, encoder counts, motor duty and its saturation, PWM
//! steps. Mass and damping are the same along all axes and in every pose (a Cartesian device); a five-bar's joints are
//! found by inverse kinematics.

mod joints;
mod linear;

use haptic_core::device::{AXES, Reading};
use haptic_core::num::{Motion, Scalar};
use haptic_core::peer::{Actuators, Sensors};

use crate::{scene::Scene, user::User};
use joints::Joints;
pub use linear::Linear;

/// A device, its user's hand on it.
#[derive(Clone, Debug)]
pub struct Plant {
    user: User,
    /// +1 where toward the other peer is toward positive x.
    toward: f64,
    period_s: f64,
    linear: Linear,
    axes_in_use: usize,
    friction_n: f64,
    moving_mass_kg: f64,
    joints: Option<Joints>,
    driven_by_duty: bool,
    arm: bool,
    motions: [Motion<f64>; AXES],
    motor_before: [f64; AXES],
}

impl Plant {
    /// The device of peer `index` (0 or 1), at rest and just clear of the object.
    pub fn new(scene: &Scene, index: usize) -> Self {
        let user = scene.users[index].clone();
        let (device, profile, world) = (&scene.world.device, &user.settings.user, &scene.world);
        let toward = if index == 0 { 1.0 } else { -1.0 };
        let moving_mass_kg = device.mass_kg + profile.arm_mass_kg;
        Self {
            toward,
            period_s: scene.peer.timing.control_period_s,
            linear: Linear::new(
                moving_mass_kg,
                device.damping_n_s_per_m + profile.arm_damping_n_s_per_m,
                profile.arm_stiffness_n_per_m,
                device.force_delay_ticks,
                scene.peer.timing.control_period_s,
            ),
            axes_in_use: scene.peer.axis.count as usize,
            friction_n: world.plant.coulomb_n,
            moving_mass_kg,
            joints: (world.plant.encoder || world.plant.motor)
                .then(|| Joints::new(&scene.peers()[index], &world.plant)),
            driven_by_duty: world.plant.motor,
            arm: profile.arm_stiffness_n_per_m > 0.0 || profile.arm_damping_n_s_per_m > 0.0,
            motions: scene.start(index),
            motor_before: [0.0; AXES],
            user,
        }
    }

    /// Position and velocity of every axis.
    pub fn motions(&self) -> [Motion<f64>; AXES] {
        self.motions
    }

    /// The hand holds still, and the motors are off.
    pub fn rest(&mut self) {
        for motion in &mut self.motions {
            motion.velocity = 0.0;
        }
        self.motor_before = [0.0; AXES];
    }

    /// What the peer's sensors say now.
    pub fn sensors<S: Scalar>(&self) -> Sensors<S> {
        let reading = match &self.joints {
            Some(joints) if joints.encoder => Reading::Counts(joints.counts(self.motions)),
            _ => Reading::Exact(self.motions.map(|motion| Motion {
                position: S::from_f64(motion.position),
                velocity: S::from_f64(motion.velocity),
            })),
        };
        Sensors { reading, overrun: false }
    }

    /// One control period from `time_s` on, under what the peer commands.
    pub fn step<S: Scalar>(&mut self, time_s: f64, actuators: &Actuators<S>) {
        let commanded = actuators.forces.map(S::to_f64);
        let motor = match &self.joints {
            Some(joints) if self.driven_by_duty => joints.forces(self.motions, actuators.duties),
            _ => commanded,
        };
        let profile = &self.user.settings.user;
        let mut push = self.toward * self.user.force_n(time_s);
        if self.arm {
            let (wanted, wanted_speed) = self.user.wanted(time_s + 0.5 * self.period_s);
            push +=
                self.toward * (profile.arm_stiffness_n_per_m * wanted + profile.arm_damping_n_s_per_m * wanted_speed);
        }
        let pushes = [push, profile.side_push_n];
        for axis in 0..self.axes_in_use {
            let (before, now) = (self.motor_before[axis] + pushes[axis], motor[axis] + pushes[axis]);
            let mut next = self.linear.advance(self.motions[axis], before, now);
            if self.friction_n > 0.0 {
                // The impulse of friction brakes what moves and holds what it can stop within the tick.
                let brake = self.friction_n * self.period_s / self.moving_mass_kg;
                let taken = next.velocity.clamp(-brake, brake);
                next.velocity -= taken;
                next.position -= 0.5 * taken * self.period_s;
            }
            self.motions[axis] = next;
        }
        self.motor_before = motor;
    }

    /// State of the plant as the analyser needs it: motion of the free axis and the motor force of the tick before, N, which still
    /// acts.
    pub fn free_axis(&mut self) -> (&mut Motion<f64>, &mut f64) {
        (&mut self.motions[0], &mut self.motor_before[0])
    }
}
