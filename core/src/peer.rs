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

mod axis;
mod exchange;

use crate::contact::{AnyRendering, Grip, Impacts};
use crate::device::encoder::{EncoderState, Marks, Shown};
use crate::device::hand::Hand;
use crate::device::kinematics::{AnyKinematics, AnySpatial, Kinematics};
use crate::device::probe::{End, Outcome, Probe, Probing};
use crate::device::stage::Measured;
use crate::device::watch::Watch;
use crate::device::{self, AXES, Reading};
use crate::law::degradation::{Degradation, Engagement};
use crate::law::{AnyLaw, Law, Spring, credit};
use crate::num::{Configured, Motion, Scalar, StateVector};
use crate::safety::{Command, Fault, Limits, Mode};
use crate::settings::{Refused, Settings, Tables};
use crate::{
    device::clutch::{Clutch, Slip},
    law::ledger::Ledger,
    object::AnyIntegrator,
    object::fixture::Fixture,
    object::plane::Oblique,
};
use axis::{Felt, SharedAxis, Tick};

pub use crate::device::hand::Actuators;
pub use axis::Observed;
pub use exchange::Arrived;

/// What a tick reads. Positions that are not encoder counts are in the shared world's units ([`crate::device::scale`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors<S, const N: usize = AXES> {
    /// Reading of the device's position.
    pub reading: Reading<S, N>,
    /// Whether the last tick had not ended when this one was due.
    pub overrun: bool,
    /// Measurements of the power stage; none where there is no current loop.
    pub stage: Option<Measured<N>>,
    /// Edges and index pulses of the encoders since the tick before; none where the hardware does not report them.
    pub marks: Option<[Marks; N]>,
}

impl<S, const N: usize> Sensors<S, N> {
    /// Sensors with this reading only: the tick is in time, and nothing else is measured.
    pub fn of(reading: Reading<S, N>) -> Self {
        Self { reading, overrun: false, stage: None, marks: None }
    }
}

/// One peer: its configuration, built from the settings, and its whole state.
///
/// Any built-in law is held by `Peer<S, AnyLaw<S>>`. An image that will only ever run one law names it and carries no other:
///
/// ```
/// use cohold_core::{device::AXES, law::power::Power, num::Motion, peer::Peer, settings::Settings};
///
/// let mut settings = Settings::default();
/// // Settings that ask for another law are refused.
/// assert!(Peer::<f32, Power<f32>>::new(&settings, [Motion::REST; AXES]).is_err());
/// settings.coordination.comm = "power";
/// assert!(Peer::<f32, Power<f32>>::new(&settings, [Motion::REST; AXES]).is_ok());
/// ```
///
/// A device has `N` axes and joints, of a mechanism `K`; along the first `SHARED` of them the object is shared, the
/// others are held on their line. [`Peer::new`] builds a peer that shares one axis of a device in the plane,
/// [`Peer::build`] any other. There is one law state, one packet and one energy account for each shared axis, and one
/// degradation level for all, since their packets travel together ([`Peer::hear`], [`Peer::exchange`]).
///
/// ```
/// use cohold_core::{device::kinematics::AnySpatial, law::wave::PassiveMean, num::Motion, peer::Peer, settings::Settings};
///
/// let mut settings = Settings::default();
/// settings.coordination.comm = "passive-mean";
/// (settings.axis.count, settings.axis.shared) = (3, 3);
/// let peer = Peer::<f32, PassiveMean<f32>, 3, 3, AnySpatial<f32>>::build(&settings, [Motion::REST; 3]);
/// assert_eq!(peer.map(|peer| peer.axes()), Ok(3));
/// ```
// Laid out as written: what every tick reads or writes as a float comes first, for a Cortex-M reaches 1020 bytes with one instruction.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Peer<S: Scalar, L: Law<S>, const SHARED: usize = 1, const N: usize = AXES, K = AnyKinematics<S>> {
    shared_axes: [SharedAxis<S, L>; SHARED],
    law: L,
    /// T_c, s.
    period_s: S,
    contact: AnyRendering<S>,
    hand: Hand<S, SHARED, N, K>,
    ticks_per_packet: u32,
    until_packet: u32,
    engagement: Engagement<S>,
    /// Since the newest packet came.
    age_ticks: u32,
    /// Packets come and are too old to be taken.
    delayed: bool,
    degradation: Degradation<S>,
    spring: Spring<S>,
    /// Packet periods in which nothing was sent, since something was.
    quiet: u32,
    /// Armed with the clutch closed, no fixture, and a copy beside the device.
    plain: bool,
    clutch: Clutch<S>,
    slips: [Slip<S>; SHARED],
    /// Virtual fixture where one axis is shared.
    fixture: Option<Fixture<S>>,
    /// Virtual fixture where several axes are shared.
    oblique: Option<Oblique<S, SHARED>>,
    /// The law's force acts on the device itself.
    at_device: bool,
}

configured!([S: Scalar, L: Law<S>, const SHARED: usize, const N: usize, K: Configured] Peer<S, L, SHARED, N, K> {
    shared_axes, period_s, contact, hand, ticks_per_packet, law, degradation, spring, clutch, fixture, oblique, at_device;
    until_packet, engagement, age_ticks, delayed, quiet, plain, slips
});

impl Settings {
    /// [`Settings::check_with`] the laws of this crate.
    ///
    /// # Errors
    /// The first key whose value is out of range or impossible beside the others.
    pub fn check(&self) -> Result<(), Refused<'static>> {
        self.check_with::<AnyLaw<f64>>()
    }

    /// Whether a peer can be built with these laws: every value within its range, every combination possible.
    ///
    /// # Errors
    /// The first key whose value is out of range or impossible beside the others.
    pub fn check_with<L: Law<f64>>(&self) -> Result<(), Refused<'static>> {
        let (plane, space) = ([Motion::REST; AXES], [Motion::REST; 3]);
        match (self.axis.shared, self.axis.count) {
            (2, 0..=2) => Peer::<f64, L, 2>::build(self, plane).map(drop),
            (2, 3..) => Peer::<f64, L, 2, 3, AnySpatial<f64>>::build(self, space).map(drop),
            (3.., _) => Peer::<f64, L, 3, 3, AnySpatial<f64>>::build(self, space).map(drop),
            (_, 3..) => Peer::<f64, L, 1, 3, AnySpatial<f64>>::build(self, space).map(drop),
            _ => Peer::<f64, L>::new(self, plane).map(drop),
        }
    }
}

/// One shared axis of a device in the plane.
impl<S: Scalar, L: Law<S>> Peer<S, L> {
    /// Disarmed, with the object just clear of the device. `device` (m, m/s) is where the device is when its encoders are
    /// first read: they count from there, so that two peers agree on where the shared object is. After this nothing fails.
    ///
    /// # Errors
    /// The first key whose value is out of range, impossible beside the others, or names a law that `L` is not.
    pub fn new(settings: &Settings, device: [Motion<S>; AXES]) -> Result<Self, Refused<'static>> {
        Self::build(settings, device)
    }
}

impl<S: Scalar, L: Law<S>, const SHARED: usize, const N: usize, K: Kinematics<S, N>> Peer<S, L, SHARED, N, K> {
    /// [`Peer::new`], of any number of axes.
    ///
    /// # Errors
    /// The first key whose value is out of range, impossible beside the others, or names a law that `L` is not; `axis.shared` that is
    /// not `SHARED`.
    pub fn build(settings: &Settings, device: [Motion<S>; N]) -> Result<Self, Refused<'static>> {
        settings.check_ranges()?;
        device::check_axes(settings, SHARED as u32, N as u32)?;
        let degradation = Degradation::build(settings)?;
        let contact = AnyRendering::build(settings)?;
        let integrator = AnyIntegrator::build(settings)?;
        let info = L::info(settings).ok_or_else(|| crate::law::unknown(settings, L::LAWS))?;
        let law = L::build(settings)?;
        credit::check(settings, info)?;
        let mut shared_axes = [SharedAxis::new(&law, &contact, integrator, S::ZERO); SHARED];
        for (axis, device) in shared_axes.iter_mut().zip(&device) {
            *axis = SharedAxis::new(&law, &contact, integrator, device.position);
        }
        Ok(Self {
            shared_axes,
            period_s: S::from_f64(settings.timing.control_period_s),
            ticks_per_packet: settings.timing.ticks_per_packet,
            contact,
            law,
            degradation,
            spring: Spring::build(settings),
            at_device: law.acts_on_device(),
            hand: Hand::build(settings, device)?,
            plain: false,
            until_packet: 0,
            engagement: degradation.engaged(),
            age_ticks: 0,
            delayed: false,
            clutch: Clutch::build(settings),
            slips: [Slip::default(); SHARED],
            fixture: if SHARED == 1 { Fixture::build(settings)? } else { None },
            oblique: if SHARED == 1 { None } else { Oblique::build(settings)? },
            quiet: u32::MAX,
        })
    }

    /// Puts the object at rest, clear of the device, and starts the coordination from there.
    fn engage(&mut self) {
        for ((axis, slip), device) in self.shared_axes.iter_mut().zip(&mut self.slips).zip(self.hand.device) {
            slip.close();
            axis.engage(&self.law, &self.contact, slip.of(device).position);
            if self.at_device {
                axis.object = Motion::at(slip.of(device).position);
            }
        }
        self.hand.start();
        self.engagement = self.degradation.engaged();
        self.age_ticks = 0;
        self.delayed = false;
        // The first packet goes at once.
        self.quiet = u32::MAX;
    }

    /// Carries out an operator's command; arming starts from rest and from zero force.
    pub fn command(&mut self, command: Command) {
        let before = self.hand.mode;
        self.enter(before.after(command));
        if self.hand.mode != Mode::Probing {
            self.hand.probing.end(End::Stopped);
        }
        if self.hand.mode == Mode::Armed && matches!(command, Command::Clutch | Command::Release) {
            for (slip, device) in self.slips.iter_mut().zip(self.hand.device) {
                slip.turn(command == Command::Clutch, device.position);
            }
            (self.hand.fast_path, self.plain) = (false, false);
        }
        if command == Command::Home && self.hand.mode == Mode::Disarmed {
            self.slips = [Slip::default(); SHARED];
            for joint in &mut self.hand.joints {
                joint.encoder = EncoderState::default();
            }
        }
        if command == Command::Clear && matches!(before, Mode::Faulted(_)) {
            // What an encoder says after a jump is taken as where the joint was: the only reference there is. And what an
            // estimator remembers may be no number.
            for (joint, at) in self.hand.joints.iter_mut().zip(self.hand.device) {
                joint.encoder = EncoderState { total: joint.encoder.total, ..EncoderState::default() };
                joint.velocity.start(at);
            }
            self.hand.start_stage();
        }
        if before != Mode::Armed && self.hand.mode == Mode::Armed {
            if self.hand.stage.supply_is_wrong {
                return self.trip(Fault::SupplyOutOfRange);
            }
            self.engage();
        }
    }

    /// Goes into a mode.
    fn enter(&mut self, mode: Mode) {
        self.hand.enter(mode);
        let free = self.fixture.is_none() && (SHARED == 1 || self.oblique.is_none()) && !self.at_device;
        self.plain = mode == Mode::Armed && free && self.slips.iter().all(Slip::is_none);
    }

    /// Everything is firm again where every slip and all that is left of a force is back at 0: one question for all of them.
    fn firm_up(&mut self) {
        let grips = self.shared_axes.iter().map(|axis| &axis.grip).chain(&self.hand.grips);
        let slipped = grips.fold(S::ZERO, |sum, grip| sum + grip.slip_m().abs());
        if slipped == S::ZERO && !self.falls() {
            self.shared_axes.iter_mut().for_each(|axis| axis.grip = Grip::default());
            self.hand.grips = [Grip::default(); N];
            self.hand.fast_path = self.plain;
        }
    }

    /// Begins a probe, if disarmed; otherwise nothing changes.
    pub fn probe(&mut self, probe: Probe<S>) {
        if self.hand.mode == Mode::Disarmed {
            if self.hand.stage.supply_is_wrong {
                return self.trip(Fault::SupplyOutOfRange);
            }
            self.enter(Mode::Probing);
            self.hand.probing = Probing::of(probe);
            self.hand.start_stage();
        }
    }

    /// Outcome of the last probe.
    pub fn probed(&self) -> Outcome {
        self.hand.probing.outcome()
    }

    /// The mode, with the fault that latched.
    pub fn mode(&self) -> Mode {
        self.hand.mode
    }

    /// Whether the coordination acts: armed, and not disengaged by silence or by [`Peer::part`].
    pub fn is_engaged(&self) -> bool {
        self.hand.mode == Mode::Armed && self.engagement.is_engaged()
    }

    /// Whether the coordination acts in full: engaged, and the other peer's packets are not faded by silence.
    pub fn is_whole(&self) -> bool {
        self.hand.mode == Mode::Armed && self.engagement.has_heard() && self.degradation.is_whole(&self.engagement)
    }

    /// What forces may be until the next tick that finds a mean near its limit ([`crate::device::envelope`], [`crate::device::thermal`]), or away from it.
    pub fn limits(&self) -> Limits<S> {
        self.hand.guard.limits
    }

    /// Motions and forces of the last tick along every shared axis.
    pub fn observed(&self) -> [&Observed<S>; SHARED] {
        self.shared_axes.each_ref().map(|axis| &axis.observed)
    }

    /// Energy that crossed the network port since arming, of every shared axis.
    pub fn ledger(&self) -> [&Ledger<S>; SHARED] {
        self.shared_axes.each_ref().map(|axis| &axis.ledger)
    }

    /// Impacts since arming along every shared axis, where contact is impulsive.
    pub fn impacts(&self) -> [Impacts<S>; SHARED] {
        self.shared_axes.each_ref().map(|axis| axis.strikes.impacts())
    }

    /// Ticks per packet, M.
    pub fn ticks_per_packet(&self) -> u32 {
        self.ticks_per_packet
    }

    /// Whether the next [`Peer::tick`] is the longest, that of an exchange, or, where every tick has one, that in which the watch looks:
    /// marks of encoders had better wait for the one after it.
    pub fn is_busy(&self) -> bool {
        if self.ticks_per_packet > 1 { self.packet_due() } else { Watch::<S>::looks(self.hand.ticks.wrapping_add(1)) }
    }

    /// Axes, and joints, in use.
    pub fn axes(&self) -> usize {
        self.hand.axes
    }

    /// One control period: sensors in, forces out.
    #[inline(never)]
    pub fn tick(&mut self, sensors: &Sensors<S, N>) -> Actuators<S, N> {
        let Sensors { reading, overrun, stage, marks } = sensors;
        self.tick_in_place(*reading, *overrun, stage, marks.as_ref().map_or(Shown::Unknown, Shown::Marks))
    }

    /// [`Peer::tick`] compiled into its caller, for an interrupt that is the only one: no register is saved twice. What [`Sensors`] are made
    /// of comes one by one, so that what is not there need not be put into memory either.
    #[inline(always)]
    pub fn tick_in_place(
        &mut self,
        reading: Reading<S, N>,
        overrun: bool,
        stage: &Option<Measured<N>>,
        shown: Shown<'_, N>,
    ) -> Actuators<S, N> {
        self.until_packet = match self.until_packet {
            0 => self.ticks_per_packet - 1,
            more => more - 1,
        };
        self.hand.ticks = self.hand.ticks.wrapping_add(1);
        let sensed = if overrun { Err(Fault::TickOverrun) } else { self.hand.sense(reading, shown) };
        let pose = match sensed {
            Ok(pose) => pose,
            Err(fault) => {
                self.trip(fault);
                return Actuators::default();
            }
        };
        self.hand.device = pose.axes;
        if let Some(measured) = stage {
            self.hand.judge(measured);
        }
        // Not one question for both: what the slow one gives in memory would be there for both.
        let felt = if self.hand.fast_path {
            let Some(felt) = self.advance::<true>(&pose.axes) else {
                self.trip(Fault::Diverged);
                return Actuators::default();
            };
            felt
        } else if self.hand.mode == Mode::Armed {
            let Some(felt) = self.slow_path() else {
                self.trip(Fault::Diverged);
                return Actuators::default();
            };
            felt
        } else {
            let Actuators { forces, duties, enable, open } = self.unarmed(stage.as_ref());
            return Actuators { forces, duties, enable, open };
        };
        self.hand.actuate(&pose, felt)
    }

    /// [`Peer::advance`] in an armed tick that is not [`Peer::fast_path`].
    #[cold]
    #[inline(never)]
    fn slow_path(&mut self) -> Option<[S; SHARED]> {
        self.firm_up();
        let device = self.hand.device;
        let most = self.hand.envelope.most(&self.hand.load, self.hand.guard.full_force, device);
        self.hand.guard.limits.ease(self.hand.stage_watch.most(
            &self.hand.stage,
            most,
            self.hand.asked,
            self.hand.forces,
        ));
        let mut felt = self.advance::<false>(&device)?;
        for (felt, motion) in felt.iter_mut().zip(&device) {
            *felt = *felt - self.hand.guard.brake(motion.velocity);
        }
        Some(felt)
    }

    /// A tick with motors that are off, or probed.
    #[cold]
    #[inline(never)]
    fn unarmed(&mut self, stage: Option<&Measured<N>>) -> Actuators<S, N> {
        self.hand.envelope.rest(&mut self.hand.load);
        for ((axis, slip), device) in self.shared_axes.iter_mut().zip(&self.slips).zip(self.hand.device) {
            axis.rest(slip.of(device));
        }
        if self.hand.mode == Mode::Probing { self.hand.push(stage) } else { Actuators::default() }
    }

    /// One tick of the copy along every shared axis, with devices there: the force on it whose reaction the device feels, N, if all of them
    /// are numbers. `PLAIN`: clutch, fixture and slips are skipped, so that a peer with none pays for none.
    #[inline(always)]
    fn advance<const PLAIN: bool>(&mut self, sensed: &[Motion<S>; N]) -> Option<[S; SHARED]> {
        let tick = Tick {
            law: &self.law,
            contact: &self.contact,
            spring: &self.spring,
            guard: &self.hand.guard,
            fixture: if PLAIN { None } else { self.fixture },
            at_device: !PLAIN && self.at_device,
            engaged: self.engagement.is_engaged(),
            age_ticks: self.age_ticks,
            period_s: self.period_s,
        };
        self.age_ticks = self.age_ticks.saturating_add(1);
        if SHARED > 1
            && !PLAIN
            && let Some(oblique) = &self.oblique
        {
            let mut devices = [Motion::REST; SHARED];
            let mut felt = [Felt { commanded: S::ZERO, share: None }; SHARED];
            let sensed = sensed.iter().zip(&self.hand.forces).zip(&mut self.slips);
            for ((device, felt), ((sensed, force), slip)) in devices.iter_mut().zip(&mut felt).zip(sensed) {
                *device = self.clutch.carry(slip, *sensed);
                *felt = Felt { commanded: *force, share: Some(slip.ratio()) };
            }
            let mut forces = axis::advance_together(&mut self.shared_axes, &tick, oblique, devices, felt)?;
            for (force, slip) in forces.iter_mut().zip(&self.slips) {
                *force = slip.ratio() * *force;
            }
            return Some(forces);
        }
        let mut felt = [S::ZERO; SHARED];
        let mut finite = true;
        let mut slips = self.slips.iter_mut();
        for (axis, (felt, (device, commanded))) in
            self.shared_axes.iter_mut().zip(felt.iter_mut().zip(sensed.iter().zip(&self.hand.forces)))
        {
            let slip = if PLAIN { None } else { slips.next() };
            let (device, share) = match slip {
                Some(slip) => (self.clutch.carry(slip, *device), Some(slip.ratio())),
                None => (*device, None),
            };
            match axis.advance::<PLAIN>(&tick, device, Felt { commanded: *commanded, share }) {
                Some(force) => *felt = share.map_or(force, |share| share * force),
                // With several axes all of them go on to the end of the tick.
                None if SHARED == 1 => return None,
                None => finite = false,
            }
            if !axis.grip.is_firm() {
                self.hand.fast_path = false;
            }
        }
        finite.then_some(felt)
    }

    /// Turns the motors off and latches the fault; the first one stays. For faults that the peer cannot see.
    pub fn trip(&mut self, fault: Fault) {
        self.hand.trip(fault);
    }
}

/// The dynamic state: of every shared axis object, integrator and coordination law, then the velocity estimators, in this order.
impl<S: Scalar, L: Law<S>, const SHARED: usize, const N: usize, K: Kinematics<S, N>> StateVector<S>
    for Peer<S, L, SHARED, N, K>
{
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        self.shared_axes.visit(each);
        for joint in &mut self.hand.joints {
            joint.velocity.visit(each);
        }
    }
}
