//! A device that lives in its joints: what a five-bar or an arm can reach is all that there is.
//!
//! The state are the joints' angles q and their speeds; where the hand is comes from the peer's own forward kinematics, x = x(q), ẋ = J·q̇,
//! and every force at the hand goes by the Jacobian, τ = Jᵀ·F. With the mass m at the hand and J_m at every joint,
//!
//! > (J_m·1 + m·Jᵀ·J)·q̈ = τ_motor + Jᵀ·(F_user − b·ẋ − k·x − m·J̇·q̇)
//!
//! by the classical Runge-Kutta rule of fourth order, in substeps of a twentieth of the fastest of √(m/k) and m/b: energy is kept to 10⁻⁹ a second. The
//! motors' torques are constant through a step, as a bridge's are; forces that a peer commands along the axes become torques in the pose in
//! which the step begins.
//!
//! **Ends of the workspace.** Where the links are nearly in line or meet no more the mechanism reports a singular pose. There is a stop: a substep that
//! would end in one is not taken, and the joints stand. Coulomb friction is along the axes of the task, as without a mechanism, and
//! a wall of the room pushes the hand. Units: rad, N·m, m, N.

use std::array::from_fn;

use cohold_core::num::Motion;

use super::joints::{Joints, Pose};
use super::wall::Wall;

/// Share of the fastest time constant that a substep takes.
const SUBSTEP: f64 = 0.05;
/// Most substeps in a step of the plant.
const MOST: f64 = 2000.0;
/// Time over which J̇ is a difference, s.
const APART_S: f64 = 1e-5;

/// What the hand of a device moves: mass (kg), damping (N·s/m), stiffness (N/m), what turns at each joint (kg·m²), and Coulomb friction (N).
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub(super) mass: f64,
    pub(super) damping: f64,
    pub(super) stiffness: f64,
    pub(super) inertia: f64,
    pub(super) friction: f64,
}

/// Joints in motion.
#[derive(Clone, Debug)]
pub(super) struct Linkage<const N: usize> {
    joints: Joints,
    body: Body,
    /// Where the hand is when every joint is zero, m.
    origin: [f64; N],
    /// Positions and speeds of the joints, rad and rad/s.
    pub(super) turned: [Motion<f64>; N],
    /// The hand as it came of that.
    hand: [Motion<f64>; N],
    substep_s: f64,
    /// Substeps in a step, and in how many of them the motors' torques of the step before still act.
    substeps: u32,
    late: f64,
}

impl<const N: usize> Linkage<N> {
    /// Every joint at zero, with the hand here, for steps of `step_s` of which the torque before still acts for a share `late`.
    pub(super) fn new(joints: Joints, body: Body, at: [Motion<f64>; N], (step_s, late): (f64, f64)) -> Self {
        let fastest = (body.stiffness / body.mass).sqrt().max(body.damping / body.mass);
        let substeps = (step_s * fastest / SUBSTEP).ceil().clamp(1.0, MOST);
        Self {
            joints,
            body,
            origin: at.map(|axis| axis.position),
            turned: [Motion::REST; N],
            hand: at,
            substep_s: step_s / substeps,
            substeps: substeps as u32,
            late: late * substeps,
        }
    }

    /// The whole device, moved along each axis by so much, m.
    pub(super) fn displace(&mut self, by_m: [f64; N]) {
        for ((origin, hand), by_m) in self.origin.iter_mut().zip(&mut self.hand).zip(by_m) {
            *origin += by_m;
            hand.position += by_m;
        }
    }

    /// The hand is where somebody else has put it, who is asked to put it where it can be.
    pub(super) fn put(&mut self, hand: [Motion<f64>; N]) {
        if hand == self.hand {
            return;
        }
        let from = self.turned.map(|joint| joint.position);
        let to = from_fn(|axis| Motion::at(hand[axis].position - self.origin[axis]));
        let positions = self.joints.inverse_from(from, to);
        let speeds = self.joints.at(positions).1.speeds(hand);
        self.turned = from_fn(|joint| Motion::new(positions[joint], speeds[joint]));
        self.hand = hand;
    }

    /// Torques (N·m) at the joints that act on the hand as these forces (N) do, where it is.
    pub(super) fn torques(&self, forces: [f64; N]) -> [f64; N] {
        self.joints.at(self.turned.map(|joint| joint.position)).1.torques(forces)
    }

    /// Moves the joints by one step under the motors' torques before and now (N·m) and forces at the hand (N): the motion of the hand.
    pub(super) fn advance(
        &mut self,
        before: [f64; N],
        now: [f64; N],
        pushes: [f64; N],
        wall: Option<&Wall>,
    ) -> [Motion<f64>; N] {
        // A wall is met in a substep: as fine as it looks without a mechanism.
        let finer = wall.map_or(1, |_| (self.substep_s / super::wall::LOOK_S).ceil() as u32);
        let step_s = self.substep_s / f64::from(finer);
        for substep in 0..self.substeps * finer {
            let old = (self.late - f64::from(substep) / f64::from(finer)).clamp(0.0, 1.0);
            let motor = from_fn(|joint| old * before[joint] + (1.0 - old) * now[joint]);
            let next = self.rubbed(self.stepped(step_s, motor, pushes, wall), step_s);
            let positions = next.map(|joint| joint.position);
            let (place, pose) = self.joints.at(positions);
            if pose.is_singular() || positions.iter().any(|position| !position.is_finite()) {
                self.hold();
                continue;
            }
            self.turned = next;
            let velocity = pose.velocities(next.map(|joint| joint.velocity));
            self.hand = from_fn(|axis| Motion::new(self.origin[axis] + place[axis], velocity[axis]));
        }
        self.hand
    }

    /// The joints stand, and the hand with them.
    pub(super) fn hold(&mut self) -> [Motion<f64>; N] {
        self.turned = self.turned.map(|joint| Motion::at(joint.position));
        self.hand = self.hand.map(|axis| Motion::at(axis.position));
        self.hand
    }

    /// The joints after so long, without friction.
    fn stepped(&self, step_s: f64, motor: [f64; N], pushes: [f64; N], wall: Option<&Wall>) -> [Motion<f64>; N] {
        let rate = |at: [Motion<f64>; N]| self.acceleration(at, motor, pushes, wall);
        let after = |of_speed: [f64; N], of_rate: [f64; N], step_s: f64| {
            from_fn(|joint| Motion {
                position: self.turned[joint].position + step_s * of_speed[joint],
                velocity: self.turned[joint].velocity + step_s * of_rate[joint],
            })
        };
        let speeds = |at: [Motion<f64>; N]| at.map(|joint| joint.velocity);
        let one = (speeds(self.turned), rate(self.turned));
        let at = after(one.0, one.1, 0.5 * step_s);
        let two = (speeds(at), rate(at));
        let at = after(two.0, two.1, 0.5 * step_s);
        let three = (speeds(at), rate(at));
        let at = after(three.0, three.1, step_s);
        let four = (speeds(at), rate(at));
        let mean = |one: [f64; N], two: [f64; N], three: [f64; N], four: [f64; N]| {
            from_fn(|joint| (one[joint] + 2.0 * (two[joint] + three[joint]) + four[joint]) / 6.0)
        };
        after(mean(one.0, two.0, three.0, four.0), mean(one.1, two.1, three.1, four.1), step_s)
    }

    /// q̈ of joints in this motion, rad/s².
    fn acceleration(&self, at: [Motion<f64>; N], motor: [f64; N], pushes: [f64; N], wall: Option<&Wall>) -> [f64; N] {
        let Body { mass, damping, stiffness, inertia, .. } = self.body;
        let speeds = at.map(|joint| joint.velocity);
        let ahead = |time_s: f64| {
            let positions = from_fn(|joint| at[joint].position + time_s * speeds[joint]);
            self.joints.at(positions).1.velocities(speeds)
        };
        let (place, pose) = self.joints.at(at.map(|joint| joint.position));
        let (velocity, later, before) = (pose.velocities(speeds), ahead(APART_S), ahead(-APART_S));
        let force: [f64; N] = from_fn(|axis| {
            let hand = Motion::new(self.origin[axis] + place[axis], velocity[axis]);
            let turning = (later[axis] - before[axis]) / (2.0 * APART_S);
            let met = wall.filter(|_| axis == 0).map_or(0.0, |wall| wall.push(hand));
            pushes[axis] + met - damping * hand.velocity - stiffness * hand.position - mass * turning
        });
        let at_hand = pose.torques(force);
        pose.accelerations(mass, inertia, from_fn(|joint| motor[joint] + at_hand[joint]))
    }

    /// These joints, after Coulomb's friction has braked the hand along each axis, and held what it can stop within the substep.
    fn rubbed(&self, next: [Motion<f64>; N], step_s: f64) -> [Motion<f64>; N] {
        if self.body.friction == 0.0 {
            return next;
        }
        let pose: Pose<N> = self.joints.at(next.map(|joint| joint.position)).1;
        let brake = self.body.friction * step_s / self.body.mass;
        let taken = pose.velocities(next.map(|joint| joint.velocity)).map(|speed| speed.clamp(-brake, brake));
        let taken = pose.speeds(taken.map(|velocity| Motion::new(0.0, velocity)));
        from_fn(|joint| Motion {
            position: next[joint].position - 0.5 * step_s * taken[joint],
            velocity: next[joint].velocity - taken[joint],
        })
    }
}
