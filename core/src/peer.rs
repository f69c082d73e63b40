//! One haptic peer at run time: [`Peer::tick`] every control period, [`Peer::exchange`] every packet period, and
//! [`Peer::hear`] whenever a packet has come; nothing else.
//!
//! **Deadline**: the board calls [`Peer::tick`] from its highest interrupt once every T_c (1 ms); a tick that is late is
//! reported to the next one ([`Sensors::overrun`]), which turns the motors off.
//! **Total**: no panic, no allocation, no lock, no clock. Whatever comes in, the forces that come out are finite and
//! within the scene's limits.
//!
//! Order of tick n (THEORY §2), so that independent implementations agree: (a) [`Peer::hear`], if a packet has come since
//! the tick before, and if [`Peer::packet_due`], [`Peer::exchange`]; (b) contact force from x_h\[n\], x_o\[n\]; (c) decode,
//! coordination force, outgoing wave; (d) the object advances. With `object.integrator = "midpoint"` (b) to (d) are one solve (THEORY §7).

use crate::contact::{AnyRendering, Impacts, Strikes};
use crate::device::encoder::{Encoder, EncoderState, Marks};
use crate::device::envelope::{self, Envelope, Load};
use crate::device::kinematics::{AnyKinematics, Pose};
use crate::device::motor::{Duty, Motor};
use crate::device::probe::{End, Outcome, Probe, Probing, Push};
use crate::device::stage::Measured;
use crate::device::stage_watch::{Driven, StageState, StageWatch};
use crate::device::watch::{Still, Watch};
use crate::device::{AXES, Reading};
use crate::law::ladder::{Engagement, Ladder};
use crate::law::{AnyLaw, Coupled, Law, Packet, Seen, credit};
use crate::num::{Motion, Scalar, StateVector};
use crate::safety::{Command, Fault, Guard, Mode, Patience};
use crate::settings::{Refused, Settings, Tables};
use crate::{
    device::constraint::Hold,
    device::velocity::AnyVelocity,
    law::ledger::Ledger,
    object::{AnyIntegrator, Port},
};

/// What the tick reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors<S> {
    /// Where the device is.
    pub reading: Reading<S>,
    /// The last tick had not ended when this one was due.
    pub overrun: bool,
    /// What the power stage measured; none where there is no current loop.
    pub stage: Option<Measured>,
    /// What the encoders showed beside their counts; none where nobody looks.
    pub marks: Option<[Marks; AXES]>,
}

impl<S> Sensors<S> {
    /// Where the device is, and no more: in time, without a current loop.
    pub fn of(reading: Reading<S>) -> Self {
        Self { reading, overrun: false, stage: None, marks: None }
    }
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
    /// No loop is closed around the currents: duties are voltages, shares of the supply. They are given to the bridges' inputs even
    /// while `enable` is low, when none of them may come out. Of a probe only, and only where there is a current loop.
    pub open: bool,
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
#[derive(Clone, Copy, Debug)]
struct Joint<S: Scalar> {
    encoder: EncoderState,
    velocity: AnyVelocity<S>,
}

/// What one tick does to the copy.
struct Moved<S> {
    next: Motion<S>,
    /// Force on the copy whose reaction the device feels, N.
    felt: S,
    coupled: Coupled<S>,
}

/// A peer: what the settings made of it, and everything about it that changes.
///
/// Any built-in law is held by `Peer<S, AnyLaw<S>>`. An image that will only ever run one law names it and carries no other:
///
/// ```
/// use haptic_core::{device::AXES, law::power::Power, num::Motion, peer::Peer, settings::Settings};
///
/// let mut settings = Settings::default();
/// // Settings that ask for another law are refused.
/// assert!(Peer::<f32, Power<f32>>::new(&settings, [Motion::REST; AXES]).is_err());
/// settings.coordination.comm = "power";
/// assert!(Peer::<f32, Power<f32>>::new(&settings, [Motion::REST; AXES]).is_ok());
/// ```
// Laid out as written: what every tick reads or writes as a float comes first, for a Cortex-M reaches 1020 bytes with one instruction.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Peer<S: Scalar, L: Law<S>> {
    coordination: L::State,
    object: Motion<S>,
    device: [Motion<S>; AXES],
    forces: [S; AXES],
    observed: Observed<S>,
    ledger: Ledger<S>,
    load: Load<S>,
    /// T_c, s.
    period_s: S,
    /// Where the axes are when the encoders read zero, m.
    home: [S; AXES],
    encoder: Encoder<S>,
    guard: Guard<S>,
    watch: Watch<S>,
    envelope: Envelope<S>,
    hold: Hold<S>,
    motor: Motor<S>,
    /// The packet that stands.
    standing: Packet<S>,
    integrator: AnyIntegrator<S>,
    contact: AnyRendering<S>,
    kinematics: AnyKinematics<S>,
    joints: [Joint<S>; AXES],
    ticks_per_packet: u32,
    /// Axes, and joints, in use.
    axes: usize,
    mode: Mode,
    until_packet: u32,
    engagement: Engagement,
    /// Since the newest packet came.
    age_ticks: u32,
    /// Packets come and are too old to be taken.
    delayed: bool,
    saturated: Patience,
    /// What the last tick asked of the motors.
    asked: [Duty; AXES],
    still: [Still; AXES],
    law: L,
    ladder: Ladder<S>,
    strikes: Strikes<S>,
    stage_watch: StageWatch<S>,
    stage: StageState<S>,
    probing: Probing<S>,
}

impl Settings {
    /// Whether a peer can be built, with the laws of this crate: every value within its range, every combination possible.
    pub fn check(&self) -> Result<(), Refused<'static>> {
        Peer::<f64, AnyLaw<f64>>::new(self, [Motion::REST; AXES]).map(drop)
    }
}

impl<S: Scalar, L: Law<S>> Peer<S, L> {
    /// Disarmed, with the object just clear of the device. `device` (m, m/s) is where the device is when its encoders are
    /// first read: they count from there, so that two peers agree on where the shared object is. After this nothing fails.
    ///
    /// # Errors
    /// The first key whose value is out of range, impossible beside the others, or names a law that `L` is not.
    pub fn new(settings: &Settings, device: [Motion<S>; AXES]) -> Result<Self, Refused<'static>> {
        settings.check_ranges()?;
        let kinematics = AnyKinematics::build(settings)?;
        let mut velocity = AnyVelocity::build(settings)?;
        let ladder = Ladder::build(settings)?;
        let contact = AnyRendering::build(settings)?;
        let integrator = AnyIntegrator::build(settings)?;
        let kind = L::kind(settings).ok_or_else(|| crate::law::unknown(settings, L::KINDS))?;
        let law = L::build(settings)?;
        credit::check(settings, kind.sends)?;
        let [free, ..] = device;
        let object = Motion::at(contact.clear_of(free.position));
        Ok(Self {
            period_s: S::from_f64(settings.timing.control_period_s),
            ticks_per_packet: settings.timing.ticks_per_packet,
            axes: settings.axis.count as usize,
            encoder: Encoder::build(settings),
            kinematics,
            hold: Hold::build(settings),
            motor: Motor::build(settings),
            contact,
            law,
            ladder,
            guard: Guard::build(settings),
            watch: Watch::build(settings),
            envelope: Envelope::build(settings),
            stage_watch: StageWatch::build(settings)?,
            home: device.map(|axis| axis.position),
            mode: Mode::Disarmed,
            until_packet: 0,
            joints: device.map(|at| {
                velocity.start(at);
                Joint { encoder: EncoderState::default(), velocity }
            }),
            device,
            object,
            strikes: Strikes::default(),
            integrator,
            coordination: law.start(object),
            forces: [S::ZERO; AXES],
            ledger: Ledger::default(),
            saturated: Patience::default(),
            load: Load::default(),
            engagement: ladder.engaged(),
            age_ticks: 0,
            delayed: false,
            probing: Probing::default(),
            still: Default::default(),
            asked: [Duty::OFF; AXES],
            stage: StageState::default(),
            standing: Packet::default(),
            observed: Observed::default(),
        })
    }

    /// Puts the object at rest, clear of the device, and starts the coordination from there.
    fn engage(&mut self) {
        let [free, ..] = self.device;
        self.object = Motion::at(self.contact.clear_of(free.position));
        self.strikes = Strikes::default();
        self.integrator.rest();
        self.coordination = self.law.start(self.object);
        self.forces = [S::ZERO; AXES];
        self.ledger = Ledger::default();
        self.saturated = Patience::default();
        self.engagement = self.ladder.engaged();
        self.age_ticks = 0;
        self.delayed = false;
        self.standing = Packet::default();
        self.still = Default::default();
        self.start_stage();
    }

    /// No motor has been asked for anything yet.
    fn start_stage(&mut self) {
        self.asked = [Duty::OFF; AXES];
        self.stage_watch.start(&mut self.stage);
    }

    /// Carries out an operator's command; arming starts from rest and from zero force.
    pub fn command(&mut self, command: Command) {
        let before = self.mode;
        self.mode = before.after(command);
        if self.mode != Mode::Probing {
            self.probing.end(End::Stopped);
        }
        if command == Command::Home && self.mode == Mode::Disarmed {
            for joint in &mut self.joints {
                joint.encoder = EncoderState::default();
            }
        }
        if command == Command::Clear && matches!(before, Mode::Faulted(_)) {
            // What an encoder says after a jump is taken as where the joint was: the only reference there is. And what an
            // estimator remembers may be no number.
            for (joint, at) in self.joints.iter_mut().zip(self.device) {
                joint.encoder = EncoderState { total: joint.encoder.total, ..EncoderState::default() };
                joint.velocity.start(at);
            }
            self.start_stage();
        }
        if before != Mode::Armed && self.mode == Mode::Armed {
            if self.stage.supply_is_wrong {
                return self.trip(Fault::SupplyOutOfRange);
            }
            self.engage();
        }
    }

    /// Begins a probe, if disarmed; otherwise nothing changes.
    pub fn probe(&mut self, probe: Probe<S>) {
        if self.mode == Mode::Disarmed {
            if self.stage.supply_is_wrong {
                return self.trip(Fault::SupplyOutOfRange);
            }
            self.mode = Mode::Probing;
            self.probing = Probing::of(probe);
            self.start_stage();
        }
    }

    /// What came of the last probe.
    pub fn probed(&self) -> Outcome {
        self.probing.outcome()
    }

    /// Packets come, but too old to be taken (`safety.max_delay_s`): silence all the same, which is the link's to say. Until one is taken
    /// the fault that silence leads to is [`Fault::PeerDelayed`].
    pub fn delayed(&mut self) {
        self.delayed = true;
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

    /// Whether [`Peer::exchange`] is due before the next [`Peer::tick`].
    pub fn packet_due(&self) -> bool {
        self.until_packet == 0
    }

    /// What the last tick saw and did.
    pub fn observed(&self) -> &Observed<S> {
        &self.observed
    }

    /// Energy that crossed the network port since arming.
    pub fn ledger(&self) -> &Ledger<S> {
        &self.ledger
    }

    /// Impacts since arming, where contact is impulsive.
    pub fn impacts(&self) -> Impacts<S> {
        self.strikes.impacts()
    }

    /// Ticks per packet, M.
    pub fn ticks_per_packet(&self) -> u32 {
        self.ticks_per_packet
    }

    /// Axes, and joints, in use.
    pub fn axes(&self) -> usize {
        self.axes
    }

    /// What [`Peer::exchange`] would send now. Only a network without delay needs to ask beforehand.
    pub fn outgoing(&self) -> Packet<S> {
        let mut packet =
            Packet { energy_j: self.ledger.sent_j().to_counter(), ..self.law.send(&self.coordination, self.object) };
        let finite = packet.is_finite();
        if !(self.is_engaged() && finite) {
            // At rest where it stands: a wave line ends in its own impedance and takes everything in. Counters stay, if they are numbers.
            (packet.motion, packet.wave) = (Motion::at(self.object.position), S::ZERO);
            if !finite {
                (packet.energy_j, packet.wave_integral, packet.live_ticks) = (S::Counter::ZERO, S::Counter::ZERO, 0);
            }
        }
        packet
    }

    /// Takes in a packet of the other peer: it acts at the next tick, and stands until another one comes.
    ///
    /// Before any tick, whether or not [`Peer::exchange`] is due; where both are, first this. Which of several that have come
    /// is the newest, the caller knows.
    pub fn hear(&mut self, packet: Packet<S>) {
        if !packet.is_finite() {
            return self.trip(Fault::NonFiniteInput);
        }
        if self.mode != Mode::Armed {
            return;
        }
        if self.ladder.hear(&mut self.engagement) {
            self.law.restart(&mut self.coordination, self.object);
        }
        self.standing = packet;
        self.age_ticks = 0;
        self.delayed = false;
        if self.ladder.is_whole(&self.engagement) {
            self.law.receive(&mut self.coordination, packet);
        } else {
            self.fade();
        }
    }

    /// Gives the law the packet that stands, as far as it still counts.
    #[inline(never)]
    fn fade(&mut self) {
        let share = self.ladder.share(&self.engagement);
        let packet = if share == S::ONE { self.standing } else { self.law.fade(share, self.standing, self.object) };
        self.law.receive(&mut self.coordination, packet);
    }

    /// One packet period: gives what to send, and counts the silence if nothing has been heard in it.
    ///
    /// Due before every M-th tick, when [`Peer::packet_due`].
    pub fn exchange(&mut self) -> Packet<S> {
        let packet = self.outgoing();
        if self.mode == Mode::Armed {
            self.ladder.pass(&mut self.engagement);
            if self.engagement.is_fading() {
                self.fade();
            }
            if self.engagement.silent() >= self.guard.silent_packets {
                self.trip(if self.delayed { Fault::PeerDelayed } else { Fault::PeerLost });
            }
        }
        packet
    }

    /// One control period: sensors in, forces out.
    #[inline(always)]
    pub fn tick(&mut self, sensors: &Sensors<S>) -> Actuators<S> {
        // One by one, so that what is not there need not be put into memory either.
        let Sensors { reading, overrun, stage, marks } = *sensors;
        self.period(reading, overrun, stage, marks)
    }

    fn period(
        &mut self,
        reading: Reading<S>,
        overrun: bool,
        stage: Option<Measured>,
        marks: Option<[Marks; AXES]>,
    ) -> Actuators<S> {
        self.until_packet = match self.until_packet {
            0 => self.ticks_per_packet - 1,
            more => more - 1,
        };
        let sensed = if overrun { Err(Fault::TickOverrun) } else { self.sense(reading, marks) };
        let pose = match sensed {
            Ok(pose) => pose,
            Err(fault) => {
                self.trip(fault);
                return Actuators::default();
            }
        };
        self.device = pose.axes;
        let [free, ..] = pose.axes;
        if let Some(measured) = stage {
            self.judge(measured);
        }
        if self.mode != Mode::Armed {
            self.envelope.rest(&mut self.load);
            let object = Motion::at(self.object.position);
            self.observed = Observed { device: free, object, desired: object, ..Observed::default() };
            return if self.mode == Mode::Probing { self.push(stage) } else { Actuators::default() };
        }

        let Moved { next, felt, coupled } = self.advance(free);
        if !(next.is_finite() && coupled.is_finite()) {
            self.trip(Fault::Diverged);
            return Actuators::default();
        }
        self.object = next;
        self.actuate(&pose, felt)
    }

    /// Contact, coordination and the copy's motion through one tick: in stages, as the papers have it, or in one solve.
    #[inline]
    fn advance(&mut self, device: Motion<S>) -> Moved<S> {
        let [commanded, ..] = self.forces;
        let mut object = self.object;
        let mut seen = Seen { local: object, contact_force: self.observed.contact_force, age_ticks: self.age_ticks };
        let uncoupled = |object| Coupled { desired: object, ..Coupled::default() };
        let engaged = self.engagement.is_engaged();
        let moved = if let AnyIntegrator::Midpoint(midpoint, carries) = &mut self.integrator {
            let press = self.contact.press(&mut self.strikes, device, &mut object, commanded);
            seen.local = object;
            let (mut half_change, mut contact_force) = (S::ZERO, S::ZERO);
            let mut solve = |coordination: Port<S>| {
                half_change = midpoint.half_change(object.velocity, press.port + coordination);
                contact_force = press.port.at(object.velocity + half_change);
                if contact_force * press.toward < S::ZERO {
                    // What can only push does not pull.
                    contact_force = S::ZERO;
                    half_change = midpoint.half_change(object.velocity, coordination);
                }
                object.velocity + half_change
            };
            let coupled = if engaged {
                self.law.couple_as_port(&mut self.coordination, &seen, solve)
            } else {
                solve(Port::default());
                uncoupled(object)
            };
            Moved { next: midpoint.advance(carries, object, half_change), felt: contact_force + press.pulse, coupled }
        } else {
            let touch = self.contact.touch(&mut self.strikes, device, &mut object, commanded);
            (seen.local, seen.contact_force) = (object, touch.felt);
            let coupled = if engaged { self.law.couple(&mut self.coordination, &seen) } else { uncoupled(object) };
            let next = self.integrator.step(object, touch.pushing + coupled.force);
            Moved { next, felt: touch.felt, coupled }
        };
        self.ledger.book(&moved.coupled, self.period_s);
        self.age_ticks = self.age_ticks.saturating_add(1);
        self.observed = Observed {
            device,
            object,
            desired: moved.coupled.desired,
            contact_force: moved.felt,
            coordination_force: moved.coupled.force,
        };
        moved
    }

    /// Whether the power stage says that something is wrong. Not where it is called: what has no stage would pay for its registers.
    #[inline(never)]
    fn judge(&mut self, measured: Measured) {
        let [first, ..] = &self.joints;
        let driven = match self.mode {
            Mode::Armed if first.encoder.primed => Driven::Whole,
            Mode::Armed => Driven::Alone,
            Mode::Probing => Driven::Probed,
            _ => Driven::Off,
        };
        let joints = &self.joints;
        let counts = || joints.each_ref().map(|joint| joint.encoder.total);
        if let Some(fault) = self.stage_watch.step(&mut self.stage, &measured, self.asked, driven, counts) {
            self.trip(fault);
        }
    }

    /// One tick of a probe; disarmed when it is over.
    #[cold]
    fn push(&mut self, stage: Option<Measured>) -> Actuators<S> {
        match self.probing.step(self.joints.iter().map(|joint| joint.encoder.total), stage) {
            Some(Push { duties, enable, open }) => Actuators { duties, enable, open, ..Actuators::default() },
            None => {
                self.mode = Mode::Disarmed;
                Actuators::default()
            }
        }
    }

    /// Where the device is on its axes, or why that cannot be said.
    #[inline]
    fn sense(&mut self, reading: Reading<S>, marks: Option<[Marks; AXES]>) -> Result<Pose<S>, Fault> {
        let pose = match reading {
            Reading::Exact(mut axes) => {
                for (axis, joint) in axes.iter_mut().zip(&mut self.joints).take(self.axes) {
                    if !axis.is_finite() {
                        return Err(Fault::NonFiniteInput);
                    }
                    axis.velocity = joint.velocity.step(*axis);
                }
                Pose::direct(axes)
            }
            Reading::Counts(counts) => {
                let mut joints = [Motion::REST; AXES];
                for ((motion, joint), counts) in joints.iter_mut().zip(&mut self.joints).zip(&counts).take(self.axes) {
                    let first = !joint.encoder.primed;
                    let position = self.encoder.step(&mut joint.encoder, *counts).ok_or(Fault::EncoderJump)?;
                    *motion = Motion::at(position);
                    if first {
                        joint.velocity.start(*motion);
                    }
                    motion.velocity = joint.velocity.step(*motion);
                }
                if let Some(marks) = marks {
                    let joints = self.joints.each_ref().map(|joint| &joint.encoder);
                    if Encoder::<S>::heeds(joints, marks) {
                        let [one, two] = marks;
                        self.heed(one, two)?;
                    }
                }
                let mut pose = self.kinematics.forward(joints);
                for (axis, home) in pose.axes.iter_mut().zip(self.home) {
                    axis.position = axis.position + home;
                }
                pose
            }
        };
        for (axis, home) in pose.axes.iter().zip(self.home).take(self.axes) {
            // No number passes neither comparison.
            let within =
                axis.velocity.abs() <= self.guard.max_speed && (axis.position - home).abs() <= self.guard.workspace;
            if !within {
                self.doubt(*axis)?;
            }
        }
        Ok(pose)
    }

    /// What encoders show beside their counts: whether it fits, and while disarmed where the index says the joint is.
    #[inline(never)]
    fn heed(&mut self, one: Marks, two: Marks) -> Result<(), Fault> {
        let may_move = self.mode == Mode::Disarmed;
        for (joint, marks) in self.joints.iter_mut().zip(&[one, two]).take(self.axes) {
            if self.encoder.heed(&mut joint.encoder, marks, may_move)? {
                joint.velocity.start(Motion::at(self.encoder.position(&joint.encoder)));
            }
        }
        Ok(())
    }

    /// Of an axis that is too fast, too far from home or nowhere: why it is a fault. Too fast or too far is none while nothing is
    /// rendered; a probe has limits of its own.
    #[cold]
    fn doubt(&self, axis: Motion<S>) -> Result<(), Fault> {
        if !axis.is_finite() {
            Err(Fault::NonFiniteInput)
        } else if self.mode != Mode::Armed {
            Ok(())
        } else if axis.velocity.abs() > self.guard.max_speed {
            Err(Fault::Overspeed)
        } else {
            Err(Fault::OutOfWorkspace)
        }
    }

    /// The reaction of the contact on the free axis and the hold of the others, within the limits.
    #[inline]
    fn actuate(&mut self, pose: &Pose<S>, contact_force: S) -> Actuators<S> {
        let mut wanted = [-contact_force; AXES];
        // Not `skip(1)`: the call behind it costs more than the hold itself.
        for (axis, (force, motion)) in (0..self.axes).zip(wanted.iter_mut().zip(&pose.axes)) {
            if axis > 0 {
                *force = self.hold.force(*motion);
            }
        }
        let mut at_limit = false;
        let mut forces = self.forces;
        for (last, wanted) in forces.iter_mut().zip(wanted).take(self.axes) {
            at_limit |= wanted.limit(self.guard.max_force) != wanted;
            *last = self.guard.limit(*last, wanted);
        }
        let mut duties = [Duty::default(); AXES];
        for (duty, joint_force) in duties.iter_mut().zip(pose.joint_forces(forces)).take(self.axes) {
            let (value, clipped) = self.motor.duty(joint_force);
            *duty = value;
            at_limit |= clipped;
        }
        if self.saturated.spent(at_limit, self.guard.saturated_ticks) {
            self.trip(Fault::ForceSaturated);
            return Actuators::default();
        }
        let power = envelope::power(forces, pose.axes);
        if let Some(fault) = self.envelope.exceeded(&mut self.load, forces, power) {
            self.trip(fault);
            return Actuators::default();
        }
        // Exact readings have no encoder to doubt.
        let [first, ..] = &self.joints;
        if first.encoder.primed {
            if self.watch.is_too_much(power) {
                self.trip(Fault::Runaway);
                return Actuators::default();
            }
            if self.until_packet & 3 == 0 && self.is_stuck(duties) {
                self.trip(Fault::EncoderStuck);
                return Actuators::default();
            }
        }
        self.forces = forces;
        self.asked = duties;
        Actuators { forces, duties, enable: true, open: false }
    }

    /// Every fourth tick, and not in the one that is the longest: whether a joint's encoder does not count.
    #[inline(never)]
    fn is_stuck(&mut self, duties: [Duty; AXES]) -> bool {
        let joints = self.joints.iter().zip(&mut self.still).zip(duties).take(self.axes);
        joints
            .fold(false, |stuck, ((joint, still), duty)| self.watch.is_stuck(still, joint.encoder.total, duty) || stuck)
    }

    /// Turns the motors off and latches the fault; the first one stays. For whoever knows of a fault that the peer cannot see.
    pub fn trip(&mut self, fault: Fault) {
        if !matches!(self.mode, Mode::Faulted(_)) {
            self.mode = Mode::Faulted(fault);
        }
        self.forces = [S::ZERO; AXES];
        self.probing.end(End::Stopped);
    }
}

/// The dynamic state: object, integrator, coordination law and velocity estimators, in this order.
impl<S: Scalar, L: Law<S>> StateVector<S> for Peer<S, L> {
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        self.object.visit(each);
        self.integrator.visit(each);
        self.coordination.visit(each);
        for joint in &mut self.joints {
            joint.velocity.visit(each);
        }
    }
}
