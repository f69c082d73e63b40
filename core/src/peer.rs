//! One haptic peer at run time: [`tick`] every control period, [`exchange`] every packet period, and nothing else.
//!
//! **Deadline**: the board calls [`tick`] from its highest interrupt once every T_c (1 ms); a tick that is late is
//! reported to the next one ([`Sensors::overrun`]), which turns the motors off.
//! **Total**: no panic, no allocation, no lock, no clock. Whatever comes in, the forces that come out are finite and
//! within the scene's limits.
//!
//! Order of tick n (THEORY §2), so that independent implementations agree: (a) if [`State::packet_due`], [`exchange`];
//! (b) contact force from x_h\[n\], x_o\[n\]; (c) decode, coordination force, outgoing wave; (d) the object advances.

use crate::contact::{Impacts, Rendering, Strikes};
use crate::device::encoder::EncoderState;
use crate::device::kinematics::{Kinematics, Pose};
use crate::device::motor::Duty;
use crate::device::probe::{End, Outcome, Probe, Probing};
use crate::device::velocity::VelocityEstimator;
use crate::device::watch::Still;
use crate::device::{AXES, Reading};
use crate::law::ladder::Engagement;
use crate::law::ledger::Ledger;
use crate::law::{Coupled, Law, Packet};
use crate::model::Model;
use crate::num::{Motion, Scalar, StateVector};
use crate::object::Integrator;
use crate::safety::{Command, Fault, Mode, Patience};
use crate::scene::{Models, Scene};

/// What the tick reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors<S> {
    /// Where the device is.
    pub reading: Reading<S>,
    /// The last tick had not ended when this one was due.
    pub overrun: bool,
}

/// What the tick commands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actuators<S> {
    /// Force on every axis of the task, N; finite, within the limits, 0 unless armed (a probe knows duties only).
    pub forces: [S; AXES],
    /// The same as motor duties, one for every joint.
    pub duties: [Duty; AXES],
    /// The hardware enable line of the motor bridges.
    pub enable: bool,
}

/// What a tick saw and did, for telemetry, reports and tests.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observed<S> {
    /// Device motion x_h on the free axis.
    pub device: Motion<S>,
    /// The local copy x_o as the forces of this tick saw it.
    pub object: Motion<S>,
    /// The decoded remote copy x_d as F_T of this tick used it.
    pub desired: Motion<S>,
    /// F_LC on the object, N.
    pub contact_force: S,
    /// F_T on the object, N.
    pub coordination_force: S,
}

/// One joint's sensing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Joint<V> {
    encoder: EncoderState,
    velocity: V,
}

/// Everything about a peer that changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<M: Models> {
    mode: Mode,
    until_packet: u32,
    joints: [Joint<<M::Velocity as Model<M::Scalar>>::State>; AXES],
    /// Where the axes are when the encoders read zero, m.
    home: [M::Scalar; AXES],
    device: [Motion<M::Scalar>; AXES],
    object: Motion<M::Scalar>,
    strikes: Strikes<M::Scalar>,
    integrator: <M::Integrator as Model<M::Scalar>>::State,
    law: <M::Law as Model<M::Scalar>>::State,
    forces: [M::Scalar; AXES],
    ledger: Ledger<M::Scalar>,
    saturated: Patience,
    engagement: Engagement,
    probing: Probing<M::Scalar>,
    still: [Still; AXES],
    /// The packet that stands.
    standing: Packet<M::Scalar>,
    observed: Observed<M::Scalar>,
}

impl<M: Models> State<M> {
    /// Disarmed, with the object just clear of the device. `device` (m, m/s) is where the device is when its encoders
    /// are first read: they count from there, so that two peers agree on where the shared object is.
    pub fn new(scene: &Scene<M>, device: [Motion<M::Scalar>; AXES]) -> Self {
        let joint = Joint { encoder: EncoderState::default(), velocity: scene.velocity.initial() };
        let mut state = Self {
            mode: Mode::Disarmed,
            until_packet: 0,
            joints: [joint; AXES],
            home: device.map(|axis| axis.position),
            device,
            object: Motion::REST,
            strikes: Strikes::default(),
            integrator: scene.integrator.initial(),
            law: scene.law.initial(),
            forces: [M::Scalar::ZERO; AXES],
            ledger: Ledger::default(),
            saturated: Patience::default(),
            engagement: scene.ladder.engaged(),
            probing: Probing::default(),
            still: Default::default(),
            standing: Packet::default(),
            observed: Observed::default(),
        };
        for (joint, at) in state.joints.iter_mut().zip(device) {
            scene.velocity.start(&mut joint.velocity, at);
        }
        state.engage(scene);
        state
    }

    /// Puts the object at rest, clear of the device, and starts the coordination from there.
    fn engage(&mut self, scene: &Scene<M>) {
        let [free, ..] = self.device;
        self.object = Motion::at(scene.contact.clear_of(free.position));
        self.strikes = Strikes::default();
        self.integrator = scene.integrator.initial();
        self.law = scene.law.initial();
        scene.law.start(&mut self.law, self.object);
        self.forces = [M::Scalar::ZERO; AXES];
        self.ledger = Ledger::default();
        self.saturated = Patience::default();
        self.engagement = scene.ladder.engaged();
        self.standing = Packet::default();
        self.still = Default::default();
    }

    /// Carries out an operator's command; arming starts from rest and from zero force.
    pub fn command(&mut self, scene: &Scene<M>, command: Command) {
        let before = self.mode;
        self.mode = before.after(command);
        if self.mode != Mode::Probing {
            self.probing.end(End::Stopped);
        }
        if command == Command::Clear && matches!(before, Mode::Faulted(_)) {
            // What an encoder says after a jump is taken as where the joint was: the only reference there is. And what an
            // estimator remembers may be no number.
            for (joint, at) in self.joints.iter_mut().zip(self.device) {
                joint.encoder.primed = false;
                scene.velocity.start(&mut joint.velocity, at);
            }
        }
        if before != Mode::Armed && self.mode == Mode::Armed {
            self.engage(scene);
        }
    }

    /// Begins a probe, if disarmed; otherwise nothing changes.
    pub fn probe(&mut self, probe: Probe<M::Scalar>) {
        if self.mode == Mode::Disarmed {
            self.mode = Mode::Probing;
            self.probing = Probing::of(probe);
        }
    }

    /// What came of the last probe.
    pub fn probed(&self) -> Outcome {
        self.probing.outcome()
    }

    /// Lets go of the other peer, which is known not to be there, or no longer the one it was: the peer renders alone until
    /// a packet comes, which starts the coordination anew from no force, step by step. Without this a peer that is armed
    /// takes the first packet in full: both were at rest where they met.
    pub fn part(&mut self) {
        self.engagement.part();
    }

    /// The mode, with the fault that latched.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Whether the coordination acts: armed, and the other peer neither silent for too long nor parted from.
    pub fn is_engaged(&self) -> bool {
        self.mode == Mode::Armed && self.engagement.is_engaged()
    }

    /// Whether [`exchange`] is due before the next [`tick`].
    pub fn packet_due(&self) -> bool {
        self.until_packet == 0
    }

    /// What the last tick saw and did.
    pub fn observed(&self) -> &Observed<M::Scalar> {
        &self.observed
    }

    /// Energy that crossed the network port since arming.
    pub fn ledger(&self) -> &Ledger<M::Scalar> {
        &self.ledger
    }

    /// Impacts since arming, where contact is impulsive.
    pub fn impacts(&self) -> Impacts<M::Scalar> {
        self.strikes.impacts()
    }

    /// Turns the motors off and latches the fault; the first one stays.
    fn trip(&mut self, fault: Fault) {
        if !matches!(self.mode, Mode::Faulted(_)) {
            self.mode = Mode::Faulted(fault);
        }
        self.forces = [M::Scalar::ZERO; AXES];
        self.probing.end(End::Stopped);
    }
}

/// The dynamic state: object, integrator, coordination law and velocity estimators, in this order.
impl<M: Models> StateVector<M::Scalar> for State<M> {
    fn visit(&mut self, each: &mut impl FnMut(&mut M::Scalar)) {
        self.object.visit(each);
        self.integrator.visit(each);
        self.law.visit(each);
        for joint in &mut self.joints {
            joint.velocity.visit(each);
        }
    }
}

/// What [`exchange`] would send now. Only a network without delay needs to ask beforehand.
pub fn outgoing<M: Models>(scene: &Scene<M>, state: &State<M>) -> Packet<M::Scalar> {
    let packet = Packet { energy_j: state.ledger.sent_j().to_f64(), ..scene.law.send(&state.law, state.object) };
    // At rest where it stands: a wave line ends in its own impedance and takes everything in.
    let resting = Packet { motion: Motion::at(state.object.position), wave: M::Scalar::ZERO, ..packet };
    match (state.is_engaged(), packet.is_finite()) {
        (true, true) => packet,
        (false, true) => resting,
        (_, false) => Packet { energy_j: 0.0, wave_integral: 0.0, ..resting },
    }
}

/// One packet period: takes in what the network brought (nothing: what came before still stands) and gives what to send.
///
/// Due before every M-th tick, when [`State::packet_due`].
pub fn exchange<M: Models>(
    scene: &Scene<M>,
    state: &mut State<M>,
    incoming: Option<Packet<M::Scalar>>,
) -> Packet<M::Scalar> {
    let packet = outgoing(scene, state);
    if incoming.is_some_and(|incoming| !incoming.is_finite()) {
        state.trip(Fault::NonFiniteInput);
        return packet;
    }
    if state.mode == Mode::Armed {
        if scene.ladder.step(&mut state.engagement, incoming.is_some()) {
            scene.law.start(&mut state.law, state.object);
        }
        if let Some(incoming) = incoming {
            state.standing = incoming;
        }
        if incoming.is_some() || state.engagement.is_fading() {
            let faded = scene.ladder.faded(&state.engagement, state.standing, state.object);
            scene.law.receive(&mut state.law, faded);
        }
        if state.engagement.silent() >= scene.guard.silent_packets {
            state.trip(Fault::PeerLost);
        }
    }
    packet
}

/// One control period: sensors in, forces out.
pub fn tick<M: Models>(scene: &Scene<M>, state: &mut State<M>, sensors: &Sensors<M::Scalar>) -> Actuators<M::Scalar> {
    state.until_packet = match state.until_packet {
        0 => scene.ticks_per_packet - 1,
        more => more - 1,
    };
    let pose = match sense(scene, state, sensors) {
        Ok(pose) => pose,
        Err(fault) => {
            state.trip(fault);
            return Actuators::default();
        }
    };
    state.device = pose.axes;
    let [free, ..] = pose.axes;
    if state.mode != Mode::Armed {
        let object = Motion::at(state.object.position);
        state.observed = Observed { device: free, object, desired: object, ..Observed::default() };
        return if state.mode == Mode::Probing { probe(state) } else { Actuators::default() };
    }

    let [commanded, ..] = state.forces;
    let mut object = state.object;
    let touch = scene.contact.touch(&mut state.strikes, free, &mut object, commanded);
    let contact_force = touch.felt;
    let coupled = if state.engagement.is_engaged() {
        scene.law.couple(&mut state.law, object)
    } else {
        Coupled { desired: object, ..Coupled::default() }
    };
    state.ledger.book(&coupled, scene.period);
    let next = scene.integrator.step(&mut state.integrator, object, touch.pushing + coupled.force);
    state.observed =
        Observed { device: free, object, desired: coupled.desired, contact_force, coordination_force: coupled.force };
    if !(next.is_finite() && coupled.is_finite()) {
        state.trip(Fault::Diverged);
        return Actuators::default();
    }
    state.object = next;
    actuate(scene, state, &pose, contact_force)
}

/// One tick of a probe; disarmed when it is over.
#[cold]
fn probe<M: Models>(state: &mut State<M>) -> Actuators<M::Scalar> {
    match state.probing.step(state.joints.iter().map(|joint| joint.encoder.total)) {
        Some(duties) => Actuators { duties, enable: true, ..Actuators::default() },
        None => {
            state.mode = Mode::Disarmed;
            Actuators::default()
        }
    }
}

/// Where the device is on its axes, or why that cannot be said.
#[inline]
fn sense<M: Models>(
    scene: &Scene<M>,
    state: &mut State<M>,
    sensors: &Sensors<M::Scalar>,
) -> Result<Pose<M::Scalar>, Fault> {
    if sensors.overrun {
        return Err(Fault::TickOverrun);
    }
    let pose = match sensors.reading {
        Reading::Exact(mut axes) => {
            for (axis, joint) in axes.iter_mut().zip(&mut state.joints).take(scene.axes) {
                if !axis.is_finite() {
                    return Err(Fault::NonFiniteInput);
                }
                axis.velocity = scene.velocity.step(&mut joint.velocity, *axis);
            }
            Pose::direct(axes)
        }
        Reading::Counts(counts) => {
            let mut joints = [Motion::REST; AXES];
            for ((motion, joint), counts) in joints.iter_mut().zip(&mut state.joints).zip(counts).take(scene.axes) {
                let first = !joint.encoder.primed;
                let position = scene.encoder.step(&mut joint.encoder, counts).map_err(|_| Fault::EncoderJump)?;
                *motion = Motion::at(position);
                if first {
                    scene.velocity.start(&mut joint.velocity, *motion);
                }
                motion.velocity = scene.velocity.step(&mut joint.velocity, *motion);
            }
            let mut pose = scene.kinematics.forward(joints);
            for (axis, home) in pose.axes.iter_mut().zip(state.home) {
                axis.position = axis.position + home;
            }
            pose
        }
    };
    for axis in pose.axes.iter().take(scene.axes) {
        if !axis.is_finite() {
            return Err(Fault::NonFiniteInput);
        }
        if scene.guard.max_speed < axis.velocity.abs() {
            return Err(Fault::Overspeed);
        }
    }
    Ok(pose)
}

/// The reaction of the contact on the free axis and the hold of the others, within the limits.
#[inline]
fn actuate<M: Models>(
    scene: &Scene<M>,
    state: &mut State<M>,
    pose: &Pose<M::Scalar>,
    contact_force: M::Scalar,
) -> Actuators<M::Scalar> {
    let mut wanted = [-contact_force; AXES];
    // Not `skip(1)`: the call behind it costs more than the hold itself.
    for (axis, (force, motion)) in (0..scene.axes).zip(wanted.iter_mut().zip(&pose.axes)) {
        if axis > 0 {
            *force = scene.hold.force(*motion);
        }
    }
    let mut at_limit = false;
    let mut forces = state.forces;
    for (last, wanted) in forces.iter_mut().zip(wanted).take(scene.axes) {
        at_limit |= scene.guard.max_force < wanted.abs();
        *last = scene.guard.limit(*last, wanted);
    }
    let mut duties = [Duty::default(); AXES];
    for (duty, joint_force) in duties.iter_mut().zip(pose.joint_forces(forces)).take(scene.axes) {
        let (value, clipped) = scene.motor.duty(joint_force);
        *duty = value;
        at_limit |= clipped;
    }
    if state.saturated.spent(at_limit, scene.guard.saturated_ticks) {
        state.trip(Fault::ForceSaturated);
        return Actuators::default();
    }
    // Exact readings have no encoder to doubt.
    let [first, ..] = &state.joints;
    if first.encoder.primed {
        if scene.watch.is_too_much(forces, pose.axes) {
            state.trip(Fault::Runaway);
            return Actuators::default();
        }
        if state.packet_due() && is_stuck(scene, state, duties) {
            state.trip(Fault::EncoderStuck);
            return Actuators::default();
        }
    }
    state.forces = forces;
    Actuators { forces, duties, enable: true }
}

/// Once a packet period, and not in the tick that is the longest: whether a joint's encoder does not count.
#[inline(never)]
fn is_stuck<M: Models>(scene: &Scene<M>, state: &mut State<M>, duties: [Duty; AXES]) -> bool {
    let joints = state.joints.iter().zip(&mut state.still).zip(duties).take(scene.axes);
    joints.fold(false, |stuck, ((joint, still), duty)| scene.watch.is_stuck(still, joint.encoder.total, duty) || stuck)
}
