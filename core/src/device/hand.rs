//! The device in a hand: what it senses and how far that is believed, the limits of what it gives, and what its motors are told.
//!
//! A [`crate::peer::Peer`] has one, tells it what is felt along the shared axes, and is told where the device is. Whatever is wrong with
//! the device ends in [`Hand::trip`], which turns the motors off.

use super::constraint::Hold;
use super::encoder::{Encoder, EncoderState, Marks, Shown};
use super::envelope::{self, Envelope, Load};
use super::kinematics::{Kinematics, Pose};
use super::motor::{self, Duty, Motor};
use super::probe::{End, Probing, Push};
use super::stage::Measured;
use super::stage_watch::{Driven, StageState, StageWatch};
use super::velocity::AnyVelocity;
use super::watch::{Still, Watch};
use super::{AXES, Reading};
use crate::contact::Grip;
use crate::num::{Motion, Scalar};
use crate::safety::{Fault, Guard, Mode, Patience};
use crate::settings::{Refused, Settings};

/// What a tick commands. Forces are in the shared world's units ([`crate::device::scale`]), duties in the device's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuators<S, const N: usize = AXES> {
    /// Force on every axis of the task, N; finite, within the limits, 0 unless armed (a probe knows duties only).
    pub forces: [S; N],
    /// The forces as motor duties, one for every joint.
    pub duties: [Duty; N],
    /// Whether the hardware enable line of the motor bridges is on.
    pub enable: bool,
    /// Whether duties are voltages, as fractions of the supply, with no loop closed around the currents. They are
    /// written to the bridges' inputs even while `enable` is low, when none of them may come out. Only a probe sets
    /// this, and only where there is a current loop.
    pub open: bool,
}

/// Motors off: zero force, zero duty, bridges disabled.
impl<S: Scalar, const N: usize> Default for Actuators<S, N> {
    fn default() -> Self {
        Self { forces: [S::ZERO; N], duties: [Duty::OFF; N], enable: false, open: false }
    }
}

/// What is sensed at one joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joint<S: Scalar> {
    pub(crate) encoder: EncoderState,
    pub(crate) velocity: AnyVelocity<S>,
}

/// The device of a peer that shares the first `SHARED` of its `N` axes; the others are held on their line.
// Laid out as written: what every tick reads or writes as a float comes first.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Hand<S: Scalar, const SHARED: usize, const N: usize, K> {
    /// Where the axes are.
    pub(crate) device: [Motion<S>; N],
    /// On the axes, N.
    pub(crate) forces: [S; N],
    pub(crate) load: Load<S>,
    /// Where the axes are when the encoders read zero, m.
    home: [S; N],
    encoder: Encoder<S>,
    pub(crate) guard: Guard<S>,
    watch: Watch<S>,
    pub(crate) envelope: Envelope<S>,
    hold: Hold<S>,
    motor: Motor<S>,
    pub(crate) joints: [Joint<S>; N],
    kinematics: K,
    /// Axes, and joints, in use. Per-tick loops still run over all `N`: a run-time bound makes the compiler spill
    /// poses and forces to memory.
    pub(crate) axes: usize,
    pub(crate) mode: Mode,
    /// Since it was made.
    pub(crate) ticks: u32,
    saturated: Patience,
    /// What the last tick asked of the motors.
    pub(crate) asked: [Duty; N],
    still: [Still; N],
    pub(crate) stage_watch: StageWatch<S>,
    pub(crate) stage: StageState<S, N>,
    pub(crate) probing: Probing<S>,
    /// What has slipped of the axes that are held.
    pub(crate) grips: [Grip<S>; N],
    /// Nothing of the device or of what it renders is near a limit, or has slipped: the next tick computes contact and coordination alone.
    pub(crate) fast_path: bool,
}

configured!([S: Scalar] Joint<S> { velocity; encoder });
configured!([S: Scalar, const SHARED: usize, const N: usize, K: crate::num::Configured] Hand<S, SHARED, N, K> {
    device, home, encoder, guard, watch, envelope, hold, motor, joints, kinematics, axes, stage_watch;
    forces, load, mode, ticks, saturated, asked, still, stage, probing, fast_path, grips
});

impl<S: Scalar, const SHARED: usize, const N: usize, K: Kinematics<S, N>> Hand<S, SHARED, N, K> {
    /// Motors off, with the device there; `settings` as they were given.
    ///
    /// # Errors
    /// The first key whose value is impossible beside the others.
    // Into the peer that has it: a copy of it on the way would be on the stack.
    #[inline(always)]
    pub(crate) fn build(settings: &Settings, device: [Motion<S>; N]) -> Result<Self, Refused<'static>> {
        // Errors name values as they were set.
        K::build(settings)?;
        motor::check(settings)?;
        let world = &settings.in_the_world();
        let kinematics = K::build(world)?;
        let mut velocity = AnyVelocity::build(world)?;
        Ok(Self {
            home: device.map(|axis| axis.position),
            joints: device.map(|at| {
                velocity.start(at);
                Joint { encoder: EncoderState::default(), velocity }
            }),
            device,
            forces: [S::ZERO; N],
            load: Load::default(),
            encoder: Encoder::build(world),
            guard: Guard::build(world),
            watch: Watch::build(world),
            envelope: Envelope::build(world),
            hold: Hold::build(world),
            motor: Motor::build(world),
            kinematics,
            axes: settings.axis.count as usize,
            mode: Mode::Disarmed,
            ticks: 0,
            saturated: Patience::default(),
            asked: [Duty::OFF; N],
            still: [Still::default(); N],
            stage_watch: StageWatch::build(settings)?,
            stage: StageState::default(),
            probing: Probing::default(),
            fast_path: false,
            grips: [Grip::default(); N],
        })
    }

    /// Goes into a mode.
    pub(crate) fn enter(&mut self, mode: Mode) {
        (self.mode, self.fast_path) = (mode, false);
    }

    /// From no force: nothing has slipped, and no motor was asked for anything.
    pub(crate) fn start(&mut self) {
        self.forces = [S::ZERO; N];
        self.grips = [Grip::default(); N];
        self.saturated = Patience::default();
        self.still = [Still::default(); N];
        self.start_stage();
    }

    /// No motor has been asked for anything yet.
    pub(crate) fn start_stage(&mut self) {
        self.asked = [Duty::OFF; N];
        self.stage_watch.start(&mut self.stage);
    }

    /// Trips on a fault that the power stage shows. Not inlined: a peer without a stage would pay for its registers.
    #[inline(never)]
    pub(crate) fn judge(&mut self, measured: &Measured<N>) {
        let driven = match self.mode {
            Mode::Armed if self.has_encoders() => Driven::Whole,
            Mode::Armed => Driven::Alone,
            Mode::Probing => Driven::Probed,
            _ => Driven::Off,
        };
        let joints = &self.joints;
        let counts = || joints.each_ref().map(|joint| joint.encoder.total);
        // A thermistor that was warm until now: this tick gives the force back.
        let before = self.stage.thermistor;
        if let Some(fault) = self.stage_watch.step(&mut self.stage, measured, self.asked, driven, counts) {
            self.trip(fault);
        }
        if before | self.stage.thermistor > 0 || self.stage.warmth > S::from_f64(envelope::NEAR) {
            self.fast_path = false;
        }
    }

    /// One tick of a probe; disarmed when it is over.
    #[cold]
    pub(crate) fn push(&mut self, stage: Option<&Measured<N>>) -> Actuators<S, N> {
        match self.probing.tick(self.joints.iter().map(|joint| joint.encoder.total), stage) {
            Some(Push { duties, enable, open }) => Actuators { duties, enable, open, ..Actuators::default() },
            None => {
                self.enter(Mode::Disarmed);
                Actuators::default()
            }
        }
    }

    /// The pose of the device, or the fault that leaves it unknown.
    // On a PC a call costs 30 instructions, on a board none.
    #[cfg_attr(target_pointer_width = "32", inline)]
    #[cfg_attr(target_pointer_width = "64", inline(always))]
    pub(crate) fn sense(&mut self, reading: Reading<S, N>, shown: Shown<'_, N>) -> Result<Pose<S, N>, Fault> {
        let pose = match reading {
            Reading::Exact(mut axes) => {
                for (at, (axis, joint)) in axes.iter_mut().zip(&mut self.joints).enumerate() {
                    if at < self.axes {
                        if !axis.is_finite() {
                            return Err(Fault::NonFiniteInput);
                        }
                        axis.velocity = joint.velocity.step(*axis);
                    }
                }
                Pose::direct(axes)
            }
            Reading::Counts(counts) => {
                let mut joints = [Motion::REST; N];
                let each = joints.iter_mut().zip(&mut self.joints).zip(counts);
                for (at, ((motion, joint), counts)) in each.enumerate() {
                    if at < self.axes {
                        let first = !joint.encoder.primed;
                        let position = self.encoder.step(&mut joint.encoder, counts).ok_or(Fault::EncoderJump)?;
                        *motion = Motion::at(position);
                        if first {
                            joint.velocity.start(*motion);
                        }
                        motion.velocity = joint.velocity.step(*motion);
                    }
                }
                let encoders = self.joints.each_ref().map(|joint| &joint.encoder);
                if let Some(marks) = Encoder::<S>::heeds(encoders, shown) {
                    self.heed(marks)?;
                }
                let Pose { mut axes, jacobian } = self.kinematics.forward(joints);
                for (axis, home) in axes.iter_mut().zip(&self.home) {
                    axis.position = axis.position + *home;
                }
                Pose { axes, jacobian }
            }
        };
        for (at, (axis, home)) in pose.axes.iter().zip(&self.home).enumerate() {
            // No number passes neither comparison.
            if at < self.axes
                && !(axis.velocity.abs() <= self.guard.max_speed
                    && (axis.position - *home).abs() <= self.guard.workspace)
            {
                self.doubt(pose.axes)?;
                break;
            }
        }
        if SHARED > 1 && self.mode == Mode::Armed && pose.is_singular() {
            // Who renders in more than one direction has to be able to push in all of them.
            return Err(Fault::OutOfWorkspace);
        }
        Ok(pose)
    }

    /// Checks what encoders show beside their counts; while disarmed, the index sets where the joint is.
    #[inline(never)]
    fn heed(&mut self, marks: &[Marks; N]) -> Result<(), Fault> {
        let may_move = self.mode == Mode::Disarmed;
        for (joint, marks) in self.joints.iter_mut().zip(marks).take(self.axes) {
            if self.encoder.heed(&mut joint.encoder, marks, may_move)? {
                joint.velocity.start(Motion::at(self.encoder.position(&joint.encoder)));
            }
        }
        Ok(())
    }

    /// The fault of axes of which one is too fast, too far from home or no number. Too fast or too far is no fault while nothing is
    /// rendered; a probe has limits of its own. An axis that is fast brakes in this tick.
    #[cold]
    fn doubt(&mut self, axes: [Motion<S>; N]) -> Result<(), Fault> {
        for (axis, home) in axes.iter().zip(&self.home).take(self.axes) {
            if !axis.is_finite() {
                return Err(Fault::NonFiniteInput);
            }
            if self.mode == Mode::Armed && axis.velocity.abs() > self.guard.fastest {
                return Err(Fault::Overspeed);
            }
            if self.mode == Mode::Armed && (axis.position - *home).abs() > self.guard.workspace {
                return Err(Fault::OutOfWorkspace);
            }
        }
        self.fast_path = false;
        Ok(())
    }

    /// The reaction of the contact on the shared axes and the hold of the others, within the limits.
    #[inline(always)]
    pub(crate) fn actuate(&mut self, pose: &Pose<S, N>, felt: [S; SHARED]) -> Actuators<S, N> {
        let mut wanted = [S::ZERO; N];
        for (force, felt) in wanted.iter_mut().zip(&felt) {
            *force = -*felt;
        }
        // Not `skip(1)`: the call behind it costs more than the hold itself.
        for (at, (force, motion)) in wanted.iter_mut().zip(&pose.axes).enumerate() {
            if at >= SHARED && at < self.axes {
                *force = self.held(at, *motion);
            }
        }
        let mut forces = self.forces;
        for (at, (last, wanted)) in forces.iter_mut().zip(&wanted).enumerate() {
            if at < self.axes {
                *last = if self.guard.limits.is_free(*wanted) { *wanted } else { self.limited(at, *last, *wanted) };
            }
        }
        // What a limit of force cuts off, the object does not get either: that may last. What a duty cuts off, it gets.
        let mut clips = false;
        let mut duties = [Duty::OFF; N];
        let mut driven = forces;
        if self.motor.eases {
            let at = self.joints.first().and_then(|joint| self.encoder.absolute(&joint.encoder));
            self.motor.eased(&mut driven, &pose.axes, at);
        }
        for (at, (duty, joint_force)) in duties.iter_mut().zip(&pose.joint_forces(driven)).enumerate() {
            if at < self.axes {
                let (value, clipped) = self.motor.duty(*joint_force);
                *duty = value;
                clips |= clipped;
            }
        }
        if self.saturated.spent(clips, self.guard.saturated_ticks) {
            self.trip(Fault::ForceSaturated);
            return Actuators::default();
        }
        let power = envelope::power(forces, pose.axes);
        if self.envelope.nears(&mut self.load, forces, power) {
            // The next tick may have less force.
            self.fast_path = false;
            if let Some(fault) = self.load.fault() {
                self.trip(fault);
                return Actuators::default();
            }
        }
        if self.has_encoders() {
            if self.watch.is_too_much(power) {
                self.trip(Fault::Runaway);
                return Actuators::default();
            }
            if Watch::<S>::looks(self.ticks) && self.is_stuck(duties) {
                self.trip(Fault::EncoderStuck);
                return Actuators::default();
            }
        }
        self.forces = forces;
        self.asked = duties;
        Actuators { forces, duties, enable: true, open: false }
    }

    /// The force (N) that an axis has after `last` where `wanted` is asked of it; where the axis is held, its line slips for what is cut.
    #[cold]
    #[inline(never)]
    fn limited(&mut self, at: usize, last: S, wanted: S) -> S {
        let given = self.guard.limits.limit(last, wanted);
        if at >= SHARED
            && given != wanted
            && let Some(grip) = self.grips.get_mut(at)
        {
            self.fast_path = false;
            self.hold.slide(grip, given - wanted, -given);
        }
        given
    }

    /// The force that holds an axis which may have slipped, N.
    #[inline]
    fn held(&mut self, at: usize, motion: Motion<S>) -> S {
        self.grips.get_mut(at).map_or(S::ZERO, |grip| self.hold.gripped(grip, motion))
    }

    /// Where the watch looks: whether a joint's encoder does not count.
    #[inline(always)]
    fn is_stuck(&mut self, duties: [Duty; N]) -> bool {
        for (at, ((joint, still), duty)) in self.joints.iter().zip(&mut self.still).zip(duties).enumerate() {
            if at < self.axes && self.watch.is_stuck(still, joint.encoder.total, duty) {
                return true;
            }
        }
        false
    }

    /// Exact readings have no encoder to doubt.
    #[inline]
    fn has_encoders(&self) -> bool {
        self.joints.first().is_some_and(|joint| joint.encoder.primed)
    }

    /// Turns the motors off and latches the fault; the first one stays.
    pub(crate) fn trip(&mut self, fault: Fault) {
        if !matches!(self.mode, Mode::Faulted(_)) {
            self.enter(Mode::Faulted(fault));
        }
        self.forces = [S::ZERO; N];
        self.probing.end(End::Stopped);
    }
}
