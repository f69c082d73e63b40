//! The simulated device (plant): one haptic device in the hand of its user.
//!
//! m·ẍ + b·ẋ + k·x = F_motor + F_user along every axis, advanced exactly (matrix exponential) for forces that are constant
//! in pieces: the old motor force for τ of a tick, then the new one, which a longer delay holds back for whole ticks; the user's force, sampled at the start of the tick,
//! for the whole tick. k and parts of m and b are the user's arm, when the scene has one. Always f64, whatever the peer
//! computes in: the world does not round.
//!
//! Imperfections, each only when the scene asks: Coulomb friction, cogging, encoder counts, motor duty and its saturation, PWM
//! steps, windings behind a bridge (`drive`, `winding`): then the tick is advanced PWM period by PWM period, each with the
//! mean force that flowed, the back-EMF at its start, and the geometry of the tick's start. Damping is the same along all axes and in every
//! pose, and so is the mass (a Cartesian device).
//!
//! Cogging pushes the only joint with A·sin(2π·(q − q₀)/p): half of its impulse where a step begins, and half where it ends (the Verlet rule), so
//! that it keeps energy. Limits: the first harmonic, and steps of a small part of a period (50 µs with windings, else a control period).
//!
//! A five-bar and an arm live in their joints (`linkage`): what they cannot reach there is not, and forces go by the Jacobian. A capstan's
//! Jacobian is one constant, so that its joint is its axis. For the analysis of a linear scene ([`Scene::linear`]) a mechanism
//! is what it is at home, exact and linear, and what its joints weigh couples the axes (`principal`).

mod drive;
mod encoders;
mod joints;
mod linear;
mod linkage;
mod principal;
mod reach;
mod wall;
mod winding;

use std::{array::from_fn, collections::VecDeque, f64::consts::TAU};

use cohold_core::device::kinematics::{self, KinematicsName};
use cohold_core::device::{AXES, Reading, current::periods_per_tick, stage::Measured};
use cohold_core::num::{Motion, Scalar};
use cohold_core::peer::{Actuators, Sensors};
use cohold_core::settings::{Refused, Scale, Settings};
use encoders::Encoders;
use joints::{Joints, Pose};
use linkage::{Body, Linkage};
use principal::Principal;
use wall::{Moving, Wall};

use crate::device::Device;
use crate::scene::{PlantFault, PlantSettings, Scene};
use crate::user::User;

pub use drive::{Converter, Drive};
pub use linear::Linear;
pub(crate) use reach::{Beyond, beyond};
pub use winding::{Flow, Winding};

/// The motors of a device that has windings.
#[derive(Clone, Debug)]
struct Windings<const N: usize> {
    drives: [Drive; N],
    /// PWM periods in a control period.
    periods: u32,
    /// Joint positions that the last tick read, m or rad.
    seen: [f64; N],
    /// What the power stage measured in the last tick; none without a current loop.
    measured: Option<Measured<N>>,
    supply_counts: u16,
}

/// What stays as it is through a control period of a device with windings.
#[derive(Clone, Copy, Debug)]
pub struct Held<const N: usize = AXES> {
    /// Forces on the axes beside the motors', N.
    pushes: [f64; N],
    /// Of a device that does not live in its joints.
    pose: Option<Pose<N>>,
}

/// A device of `N` axes, its user's hand on it.
#[derive(Clone, Debug)]
pub struct Plant<const N: usize = AXES> {
    user: User,
    /// Where its forces point, as parts along the axes.
    direction: [f64; 3],
    /// +1 where toward the other peer is toward positive x.
    toward: f64,
    period_s: f64,
    /// What `linear` advances by: a control period, or a PWM period.
    step_s: f64,
    /// What advances each axis.
    pub(crate) linear: Linear,
    /// What advances all axes of a device whose mass couples them.
    principal: Option<Principal<N>>,
    /// The joints of a device that lives in them.
    linkage: Option<Linkage<N>>,
    wall: Option<Wall>,
    windings: Option<Windings<N>>,
    /// Number of axes that move.
    pub(crate) axes_in_use: usize,
    friction_n: f64,
    /// Largest change of velocity by half of a step's cogging (m/s), radians to a metre, and where it is zero, m.
    cogging: Option<[f64; 3]>,
    moving_mass_kg: f64,
    joints: Option<Joints>,
    encoders: Option<Encoders<N>>,
    /// What is going to go wrong, and when (s).
    fault: Option<(PlantFault, f64)>,
    held: bool,
    driven_by_duty: bool,
    arm: bool,
    /// What else pulls on each axis, N.
    pulls_n: [f64; N],
    motions: [Motion<f64>; N],
    motor_before: [f64; N],
    /// Motor forces that the device holds back for whole ticks, of which the first acts next.
    waiting: VecDeque<[f64; N]>,
    /// How much larger than the device the world is in which a peer reads and drives it exactly.
    scale: Scale,
}

impl Plant {
    /// The device of peer `index` (0 or 1), at rest and just clear of the object.
    pub fn new(scene: &Scene, index: usize) -> Self {
        Self::build(scene, index)
    }
}

impl<const N: usize> Plant<N> {
    /// [`Plant::new`], of any number of axes.
    pub fn build(scene: &Scene, index: usize) -> Self {
        let user = scene.users[index].clone();
        let (device, profile, world) = (&scene.devices()[index], &user.settings.user, &scene.world);
        let toward = if index == 0 { 1.0 } else { -1.0 };
        let moving_mass_kg = device.mass_kg + profile.arm_mass_kg;
        let settings = &scene.peers()[index];
        let turns = matches!(settings.kinematics.model, KinematicsName::FiveBar | KinematicsName::Arm);
        let joints = (world.plant.encoder || world.plant.motor).then(|| Joints::new(settings, &world.plant));
        let windings = (joints.as_ref()).filter(|_| world.plant.winding).map(|joints| Windings {
            drives: from_fn(|joint| {
                let seed = u64::from(world.network.seed) << 8 | (index * N + joint) as u64;
                Drive::new(settings, &world.plant, seed).expect("a scene that was checked")
            }),
            periods: periods_per_tick(settings).expect("a scene that was checked"),
            seen: if turns { [0.0; N] } else { joints.seen(scene.start(index)) },
            measured: None,
            supply_counts: world.plant.timer_counts(),
        });
        let period_s = scene.peer.timing.control_period_s;
        // With windings the steps are PWM periods, and nothing else is late.
        let (step_s, (waits, late)) = match &windings {
            Some(windings) => (period_s / f64::from(windings.periods), (0, 0.0)),
            None => (period_s, device.delay()),
        };
        let (damping, stiffness) =
            (device.damping_n_s_per_m + profile.arm_damping_n_s_per_m, profile.arm_stiffness_n_per_m);
        let wall = user.has_wall().then(|| {
            let place = (-toward, scene.start::<N>(index)[0].position - toward * profile.wall_m);
            let gains = [profile.wall_stiffness_n_per_m, profile.wall_damping_n_s_per_m];
            Wall::new(place, gains, &Moving { mass: moving_mass_kg, damping, stiffness }, (step_s, late))
        });
        let moving = |mass_kg| Linear::new(mass_kg, damping, stiffness, late, step_s);
        let linkage = (turns && !scene.at_home).then(|| {
            let body = Body {
                mass: moving_mass_kg,
                damping,
                stiffness,
                inertia: device.joint_inertia,
                friction: world.plant.coulomb_n,
            };
            Linkage::new(Joints::new(settings, &world.plant), body, scene.start(index), (step_s, late))
        });
        let principal = (device.joint_inertia > 0.0 && linkage.is_none()).then(|| {
            let inverse = Joints::new(settings, &world.plant).inverse_at_home();
            Principal::new(principal::in_the_task(inverse, moving_mass_kg, device.joint_inertia), moving)
        });
        Self {
            direction: user.direction(),
            toward,
            period_s,
            step_s,
            linear: moving(moving_mass_kg),
            principal,
            wall,
            windings,
            axes_in_use: scene.peer.axis.count as usize,
            friction_n: world.plant.coulomb_n,
            cogging: (world.plant.cogging_n_or_n_m > 0.0).then(|| {
                let (plant, per_m) = (&world.plant, kinematics::Joints::of(settings).usual_per_m);
                let kick = 0.5 * plant.cogging_n_or_n_m * per_m * step_s / moving_mass_kg;
                [kick, TAU / settings.motor.cogging_period_m_or_rad * per_m, plant.cogging_at_m_or_rad / per_m]
            }),
            moving_mass_kg,
            encoders: (joints.as_ref()).filter(|joints| joints.encoder).map(|joints| {
                let counts = linkage.as_ref().map_or_else(|| joints.counts(scene.start(index)), |_| [0; N]);
                joints.encoders(settings, counts)
            }),
            linkage,
            joints,
            fault: Some((world.plant.fault, world.plant.fault_at_s))
                .filter(|(fault, _)| index == 0 && *fault != PlantFault::None),
            held: false,
            driven_by_duty: world.plant.motor,
            arm: profile.arm_stiffness_n_per_m > 0.0 || profile.arm_damping_n_s_per_m > 0.0,
            pulls_n: [0.0; N],
            motions: scene.start(index),
            motor_before: [0.0; N],
            waiting: VecDeque::from(vec![[0.0; N]; waits]),
            scale: settings.scale,
            user,
        }
    }

    /// Neither joints nor windings, a scale, faults, friction, cogging, a wall, a clutch or whole ticks of delay: its peer reads and drives it exactly, and
    /// nothing else.
    pub(crate) fn is_bare(&self) -> bool {
        let profile = &self.user.settings.user;
        let exact = self.joints.is_none() && self.windings.is_none() && self.scale == Scale::default();
        exact
            && self.principal.is_none()
            && self.linkage.is_none()
            && self.fault.is_none()
            && self.friction_n == 0.0
            && self.cogging.is_none()
            && self.wall.is_none()
            && self.waiting.is_empty()
            && profile.clutch_for_s == 0.0
    }

    /// Position and velocity of every axis.
    pub fn motions(&self) -> [Motion<f64>; N] {
        self.motions
    }

    /// This device, displaced along each axis by so much, m.
    #[must_use]
    pub fn moved(mut self, by_m: [f64; N]) -> Self {
        for (motion, by_m) in self.motions.iter_mut().zip(by_m) {
            motion.position += by_m;
        }
        if let Some(linkage) = &mut self.linkage {
            linkage.displace(by_m);
            self.motions = linkage.hold();
            return self;
        }
        if let (Some(joints), Some(windings)) = (&self.joints, &mut self.windings) {
            windings.seen = joints.seen(self.motions);
        }
        if let (Some(joints), Some(encoders)) = (&self.joints, &mut self.encoders) {
            encoders.turn(joints.counts(self.motions));
            encoders.turn(joints.counts(self.motions));
        }
        self
    }

    /// From the next tick on these forces along the axes (N, toward positive x, y, z) act beside the user's: a hand that the scene knows
    /// nothing of.
    pub fn pull(&mut self, forces_n: [f64; N]) {
        self.pulls_n = forces_n;
    }

    /// Force of the wall that the device can meet (`user.….wall_m`), N; 0 without one.
    pub fn wall_n(&self) -> f64 {
        self.wall.as_ref().map_or(0.0, |wall| wall.force_n)
    }

    /// Stops the device, as a hand does that holds it still, with the motors off.
    pub fn rest(&mut self) {
        for motion in &mut self.motions {
            motion.velocity = 0.0;
        }
        self.motor_before = [0.0; N];
        self.waiting.iter_mut().for_each(|forces| *forces = [0.0; N]);
        self.drives().for_each(Drive::off);
    }

    /// Readings of the peer's sensors now.
    pub fn sensors<S: Scalar>(&self) -> Sensors<S, N> {
        let reading = match &self.encoders {
            Some(encoders) => Reading::Counts(encoders.counts()),
            None => Reading::Exact(self.motions.map(|motion| Motion {
                position: S::from_f64(self.scale.position * motion.position),
                velocity: S::from_f64(self.scale.position * motion.velocity),
            })),
        };
        let stage = self.windings.as_ref().and_then(|windings| windings.measured);
        let marks = self.encoders.as_ref().map(Encoders::marks);
        Sensors { stage, marks, ..Sensors::of(reading) }
    }

    /// Advances the device by one control period from `time_s` (s) on, under what the peer commands.
    pub fn step<S: Scalar>(&mut self, time_s: f64, actuators: &Actuators<S, N>) {
        self.fail_at(time_s);
        self.drive(self.pushes(time_s), actuators);
        self.turn();
    }

    fn fail_at(&mut self, time_s: f64) {
        if let Some((fault, _)) = self.fault.take_if(|(_, at_s)| time_s >= *at_s) {
            self.fail(fault);
        }
    }

    fn turn(&mut self) {
        if let (Some(joints), Some(encoders)) = (&self.joints, &mut self.encoders) {
            encoders.turn(match &mut self.linkage {
                Some(linkage) => {
                    linkage.put(self.motions);
                    joints.counted(linkage.turned.map(|joint| joint.position))
                }
                None => joints.counts(self.motions),
            });
        }
    }

    /// Begins a control period at `time_s` (s) of a device whose power stage is computed elsewhere, as on a virtual
    /// board: gives what is constant through it, for [`Plant::period`]. None without windings.
    pub fn begin(&mut self, time_s: f64) -> Option<Held<N>> {
        self.fail_at(time_s);
        let joints = self.joints.as_ref().filter(|_| self.windings.is_some())?;
        let pose = self.linkage.is_none().then(|| joints.pose(self.motions));
        Some(Held { pushes: self.pushes(time_s), pose })
    }

    /// One PWM period under these voltages (timer counts; none where a bridge is off): what the current converters
    /// read. Without [`Held`] from [`Plant::begin`] nothing moves.
    pub fn period(&mut self, held: Option<&Held<N>>, voltages: [Option<i32>; N]) -> [[u16; 2]; N] {
        let Some(mut windings) = self.windings.take() else { return [[0; 2]; N] };
        let speeds = held.map_or([0.0; N], |held| self.speeds(held.pose.as_ref()));
        let flows: [_; N] = from_fn(|joint| windings.drives[joint].flow(voltages[joint], speeds[joint]));
        if let Some(Held { pushes, pose }) = held {
            let joints = flows.map(|(_, force)| force);
            let motor = pose.map_or(joints, |pose| pose.forces(joints));
            self.advance(motor, motor, *pushes);
            self.turn();
        }
        self.windings = Some(windings);
        flows.map(|(reads, _)| reads)
    }

    /// Whether its first bridge gives what its inputs say even while it is not enabled.
    pub fn ignores_enable(&self) -> bool {
        self.windings.as_ref().is_some_and(|windings| windings.drives[0].ignores_enable())
    }

    /// Gives every current loop the gains that these settings say, which need not be those of the windings: a board knows what it was told.
    ///
    /// # Errors
    /// Settings that no loop can have.
    pub fn tune(&mut self, settings: &Settings, plant: &PlantSettings) -> Result<(), Refused<'static>> {
        self.drives().try_for_each(|drive| drive.tune(settings, plant))
    }

    fn drives(&mut self) -> impl Iterator<Item = &mut Drive> {
        self.windings.iter_mut().flat_map(|windings| &mut windings.drives)
    }

    /// Largest |current| through each winding since it was last asked for, A; 0 without windings.
    pub fn take_peaks_a(&mut self) -> [f64; N] {
        let windings = self.windings.as_mut();
        windings.map_or([0.0; N], |windings| windings.drives.each_mut().map(Drive::take_peak_a))
    }

    /// Supply of the bridges, V; none without windings.
    pub fn supply_v(&self) -> Option<f64> {
        self.windings.as_ref().map(|windings| windings.drives[0].supply_v())
    }

    /// The supply of the bridges is this from now on, V; nothing without windings.
    pub fn set_supply(&mut self, volts: f64) {
        self.drives().for_each(|drive| drive.set_supply(volts));
    }

    /// Makes the first joint fail in this way from now on.
    pub fn fail(&mut self, fault: PlantFault) {
        self.held |= fault == PlantFault::Held;
        if let Some(encoders) = &mut self.encoders {
            encoders.fail(fault);
        }
        if let Some(windings) = &mut self.windings {
            windings.drives[0].fail(fault);
        }
    }

    /// Forces on the axes beside the motors', N.
    #[inline]
    pub(crate) fn pushes(&self, time_s: f64) -> [f64; N] {
        let profile = &self.user.settings.user;
        let mut push = self.toward * self.user.force_n(time_s);
        if self.arm {
            let (wanted, wanted_speed) = self.user.wanted(time_s + 0.5 * self.period_s);
            push +=
                self.toward * (profile.arm_stiffness_n_per_m * wanted + profile.arm_damping_n_s_per_m * wanted_speed);
        }
        from_fn(|axis| {
            let pull = self.pulls_n[axis];
            self.direction[axis] * push + if axis == 0 { pull } else { profile.side_push_n + pull }
        })
    }

    /// Speeds of the joints, m/s or rad/s; none are known without a pose or joints of one's own.
    fn speeds(&mut self, pose: Option<&Pose<N>>) -> [f64; N] {
        match (&mut self.linkage, pose) {
            (Some(linkage), _) => {
                linkage.put(self.motions);
                linkage.turned.map(|joint| joint.velocity)
            }
            (None, Some(pose)) => pose.speeds(self.motions),
            (None, None) => [0.0; N],
        }
    }

    /// The hand and the motors, for a control period.
    fn drive<S: Scalar>(&mut self, pushes: [f64; N], actuators: &Actuators<S, N>) {
        let (Some(joints), Some(mut windings)) = (&self.joints, self.windings.take()) else {
            if let Some(linkage) = &mut self.linkage {
                linkage.put(self.motions);
            }
            let forces = actuators.forces.map(|force| force.to_f64() / self.scale.force);
            // Of a device that lives in its joints, torques.
            let motor = match (&self.joints, &self.linkage) {
                (Some(joints), Some(_)) if self.driven_by_duty => joints.torques(actuators.duties),
                (Some(joints), None) if self.driven_by_duty => {
                    joints.pose(self.motions).forces(joints.torques(actuators.duties))
                }
                (_, Some(linkage)) => linkage.torques(forces),
                (_, None) => forces,
            };
            let motor = match self.waiting.pop_front() {
                Some(acts) => {
                    self.waiting.push_back(motor);
                    acts
                }
                None => motor,
            };
            self.advance(self.motor_before, motor, pushes);
            self.motor_before = motor;
            return;
        };
        let before = windings.seen;
        let pose = match &mut self.linkage {
            Some(linkage) => {
                linkage.put(self.motions);
                windings.seen = joints.told(linkage.turned.map(|joint| joint.position));
                None
            }
            None => {
                windings.seen = joints.seen(self.motions);
                Some(joints.pose(self.motions))
            }
        };
        for (joint, drive) in windings.drives.iter_mut().enumerate() {
            if actuators.enable && !actuators.open {
                drive.command(actuators.duties[joint], (windings.seen[joint] - before[joint]) / self.period_s);
            } else {
                drive.open(actuators.duties[joint], actuators.enable);
            }
        }
        self.motor_before = [0.0; N];
        for _ in 0..windings.periods {
            let speeds = self.speeds(pose.as_ref());
            let joints = from_fn(|joint| windings.drives[joint].period(speeds[joint]));
            let motor = pose.map_or(joints, |pose| pose.forces(joints));
            self.advance(motor, motor, pushes);
            for (mean, force) in self.motor_before.iter_mut().zip(motor) {
                *mean += force / f64::from(windings.periods);
            }
        }
        windings.measured = drive::measured(&windings.drives, windings.supply_counts);
        self.windings = Some(windings);
    }

    /// Moves the axes by one step under the motors' forces before and now, and the user's. Of a device that lives in its joints the motors' are torques.
    fn advance(&mut self, before: [f64; N], now: [f64; N], pushes: [f64; N]) {
        if let Some(linkage) = &mut self.linkage {
            linkage.put(self.motions);
            self.motions =
                if self.held { linkage.hold() } else { linkage.advance(before, now, pushes, self.wall.as_ref()) };
            if let Some(wall) = &mut self.wall {
                wall.see(self.motions[0]);
            }
            return;
        }
        if let Some(principal) = self.principal.as_ref().filter(|_| !self.held) {
            let with = |forces: [f64; N]| from_fn(|axis| forces[axis] + pushes[axis]);
            self.motions = principal.advance(self.motions, with(before), with(now));
            return;
        }
        for axis in 0..self.axes_in_use {
            let (before, now) = (before[axis] + pushes[axis], now[axis] + pushes[axis]);
            let from = self.kicked(self.motions[axis]);
            let next = match &mut self.wall {
                Some(wall) if axis == 0 => wall.advance(from, before, now),
                _ => self.linear.advance(from, before, now),
            };
            let mut next = self.kicked(next);
            if self.friction_n > 0.0 {
                // The impulse of friction brakes what moves and holds what it can stop within the step.
                let brake = self.friction_n * self.step_s / self.moving_mass_kg;
                let taken = next.velocity.clamp(-brake, brake);
                next.velocity -= taken;
                next.position -= 0.5 * taken * self.step_s;
            }
            self.motions[axis] = if self.held { Motion::at(self.motions[axis].position) } else { next };
        }
    }

    /// This motion of the only axis after half of a step's impulse of cogging.
    fn kicked(&self, mut motion: Motion<f64>) -> Motion<f64> {
        if let Some([kick, per_m, at_m]) = self.cogging {
            motion.velocity += kick * libm::sin(per_m * (motion.position - at_m));
        }
        motion
    }

    /// State of the plant as the analyser needs it: motion of the free axis and the motor force of the tick before, N, which still
    /// acts; of windings, the mean force of the tick before, which is over.
    pub fn free_axis(&mut self) -> (&mut Motion<f64>, &mut f64) {
        (&mut self.motions[0], &mut self.motor_before[0])
    }

    /// Visits what this plant is along each of its first axes: position (m), velocity (m/s), the motor force of the tick before, and those
    /// that it holds back, of which the first acts next, N.
    pub fn visit_axes(&mut self, axes: usize, mut visit: impl FnMut(&mut f64)) {
        for axis in 0..axes.min(N) {
            let motion = &mut self.motions[axis];
            [&mut motion.position, &mut motion.velocity, &mut self.motor_before[axis]].into_iter().for_each(&mut visit);
            self.waiting.iter_mut().for_each(|forces| visit(&mut forces[axis]));
        }
    }

    /// Motion of every axis (m, m/s) and the motor force on it before (N), mutable.
    pub fn each_axis(&mut self) -> impl Iterator<Item = (&mut Motion<f64>, &mut f64)> {
        self.motions.iter_mut().zip(&mut self.motor_before)
    }
}

impl<S: Scalar, const N: usize> Device<S, N> for Plant<N> {
    #[inline]
    fn sensors(&self) -> Sensors<S, N> {
        self.sensors()
    }
    #[inline]
    fn step(&mut self, time_s: f64, actuators: &Actuators<S, N>) {
        self.step(time_s, actuators);
    }
    fn wait(&mut self, actuators: &Actuators<S, N>) {
        self.drive([0.0; N], actuators);
        self.turn();
    }
    #[inline]
    fn clutches(&self, time_s: f64) -> bool {
        self.user.clutches(time_s)
    }
    fn start(&self) -> [Motion<S>; N] {
        self.motions.map(|axis| Motion::at(S::from_f64(self.scale.position * axis.position)))
    }
    fn motions(&self) -> [Motion<f64>; N] {
        self.motions()
    }
    fn pull(&mut self, forces_n: [f64; N]) {
        self.pull(forces_n);
    }
    fn wall_n(&self) -> f64 {
        self.wall_n()
    }
}
