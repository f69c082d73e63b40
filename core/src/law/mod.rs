//! Coordination laws: each couples the local copy of the shared object to the other peer's, over a lossy network.
//!
//! Every tick a law observes its copy and gives the coordination force on it ([`Law::couple`]); each packet period it
//! makes one [`Packet`] ([`Law::send`]), which goes out unless it is not worth sending ([`Law::speaks`], [`event`]); it
//! takes in the other peer's packets ([`Law::receive`]). **A law is one file** with its [`LawInfo`]: its name, what it
//! sends, its own keys, the gains to try. In this crate the file, its `pub mod` and one line in the list below make it
//! known to simulator, analyser, campaign and reports, and a line in the list of `cohold_laws` makes it known to a board. A
//! crate outside passes it to them. [`free`] is the smallest law.
//!
//! Sign: the coordination force F_T acts on the local copy, F_T = K_T·(x_d − x_o) + B_T·(ẋ_d − ẋ_o)
//! (cooperation paper §3, eq. 7).

pub mod bounds;
pub mod credit;
pub mod decimate;
pub mod degradation;
pub mod event;
pub mod four_channel;
pub mod free;
pub mod ledger;
pub mod p_plus_d;
pub mod power;
pub mod self_timed;
pub mod terminal;
pub mod wave;

use bounds::Bounds;

use crate::num::{Configured, Motion, Scalar, StateVector, visit_counter};
use crate::object::port::{self, Port, Solve};
use crate::settings::{Allowed, Refused, Settings};

pub use crate::settings::{LawInfo, Promise, Sends};

/// What crosses the network once each packet period. A law fills the fields it uses; the others stay 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Packet<S: Scalar> {
    /// Motion of the sender's copy of the object, m and m/s (power-domain), or a place and a speed that the law has in its stead.
    pub motion: Motion<S>,
    /// Wave sample, √W (wave-domain), or what a law sends beside motion or sums, in a unit of its own, such as a force, N. 0 from a
    /// peer that is not engaged.
    pub wave: S,
    /// Energy that the sender has given to the network since arming, up to its last tick, J: of its waves, or from its
    /// tank. The peer fills it in from its [`ledger`], unless the law has.
    pub energy_j: S::Counter,
    /// Integral of the sender's outgoing wave over the same time, √W·s, or what a law of motion sends for it.
    pub wave_integral: S::Counter,
    /// Ticks that the sender's sums cover, by default those since the law began; wraps.
    pub live_ticks: u32,
}

/// The signals that a peer may send, in the order of declaration; the counters beside them are no state of a linear line.
impl<S: Scalar> StateVector<S> for Packet<S> {
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        self.motion.visit(each);
        each(&mut self.wave);
        visit_counter::<S>(&mut self.wave_integral, each);
    }
}

impl<S: Scalar> Packet<S> {
    /// Whether every field is finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        // Two tests for five: nothing times a number is nothing, times anything else no number.
        let nothing = S::ZERO * self.motion.position + S::ZERO * self.motion.velocity + S::ZERO * self.wave;
        let none = S::Counter::ZERO;
        nothing == S::ZERO && none * self.energy_j + none * self.wave_integral == none
    }

    /// During silence, when this share (below 1) of it still counts: a motion moved toward that of the copy, and a wave made smaller, which
    /// takes energy out of the line and never puts any in.
    pub fn faded(self, share: S, local: Motion<S>) -> Self {
        let position = local.position + share * (self.motion.position - local.position);
        let velocity = local.velocity + share * (self.motion.velocity - local.velocity);
        Self { motion: Motion::new(position, velocity), wave: share * self.wave, ..self }
    }
}

/// What a law is given to observe in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation<S> {
    /// Motion of the local copy as the tick begins, m and m/s.
    pub local: Motion<S>,
    /// Force of contact on the copy, N: of this tick, or of the one before where contact and law are solved together.
    pub contact_force: S,
    /// Ticks since the newest packet came; since arming before the first.
    pub age_ticks: u32,
}

/// Refuses every order but those in which a force works with the way of the same tick; `allowed` says which and where.
pub fn needs_midpoint(settings: &Settings, allowed: &'static str) -> Result<(), Refused<'static>> {
    if settings.object.integrator.solves() {
        return Ok(());
    }
    Err(settings.refuses("object.integrator", Allowed::Only(allowed)))
}

/// What a law did in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coupled<S> {
    /// Where the law wants the local copy: the decoded remote copy x_d, ẋ_d.
    pub desired: Motion<S>,
    /// Coordination force F_T on the local copy, N.
    pub force: S,
    /// Power that came in from the network, ½·u_in² of waves, W, never negative.
    pub power_in: S,
    /// Power that went out to the network, ½·u_out² of waves, W, never negative.
    pub power_out: S,
}

impl<S: Scalar> Coupled<S> {
    /// No force: the copy is where it should be.
    #[inline]
    pub fn none(local: Motion<S>) -> Self {
        Self { desired: local, ..Self::default() }
    }

    /// A force (N) toward where the remote copy is said to be, which moves as it was said to: the network does the work F_T·ẋ_d.
    #[inline]
    pub fn toward(desired: Motion<S>, force: S) -> Self {
        Self::of_power(desired, force, force * desired.velocity)
    }

    /// A force (N), with the power that came in from the network, W; negative if it went out.
    #[inline]
    pub fn of_power(desired: Motion<S>, force: S, power: S) -> Self {
        Self { desired, force, power_in: power.max(S::ZERO), power_out: (-power).max(S::ZERO) }
    }

    /// Force and powers in one sum, which is finite only if its terms are.
    #[inline]
    pub(crate) fn sum(&self) -> S {
        self.force + self.power_in + self.power_out
    }
}

/// A coordination law: how the local copy of the object is coupled to the remote one, and what is sent for that. A law
/// lists the parameters that it was built with ([`crate::configured!`]); with an empty `impl Configured` instead,
/// scenes with it are simulated one by one, never many side by side.
pub trait Law<S: Scalar>: Configured + Copy + core::fmt::Debug + Send + Sync + 'static {
    /// Name, keys and promises of the law; one entry, unless the type is a list of laws such as [`AnyLaw`].
    const LAWS: &'static [LawInfo];
    /// State of the law.
    type State: StateVector<S> + Copy + core::fmt::Debug + Send + Sync;
    /// Whether the law needs `object.integrator = "midpoint"` or `"backward-euler"`: [`Law::build`] refuses any other.
    const PORTS_ONLY: bool = false;

    /// The entry that the settings name, if it is this law's: one of [`Law::LAWS`], unless the laws are known only at run time.
    #[must_use]
    fn info(settings: &Settings) -> Option<&'static LawInfo> {
        named(settings, Self::LAWS)
    }
    /// Takes what it needs from settings that are within their ranges. After this nothing can fail.
    ///
    /// # Errors
    /// The first key whose value is impossible beside the others.
    fn build(settings: &Settings) -> Result<Self, Refused<'static>>;
    /// Bounds on what an end with the limits of these settings sends: by default on motion, or waves.
    fn bounds(settings: &Settings) -> Bounds {
        match Self::info(settings) {
            Some(LawInfo { sends: Sends::Motion, .. }) => Bounds::of_motion(settings),
            _ => Bounds::of_waves(settings),
        }
    }
    /// How far a newton takes two copies at rest from each other, over a network of `delay_s` (s) each way, m/N, at least and at most:
    /// by default 2/K_T, and T/b of a line of waves.
    fn compliance(settings: &Settings, delay_s: f64) -> [f64; 2] {
        let line = matches!(Self::info(settings), Some(LawInfo { sends: Sends::Waves, .. }));
        let impedance = if line { settings.coordination.wave_impedance_n_s_per_m } else { f64::INFINITY };
        [2.0 / settings.coordination.stiffness_n_per_m + delay_s / impedance; 2]
    }
    /// State of a law that begins at rest with the local copy: no force until something moves.
    fn start(&self, local: Motion<S>) -> Self::State;
    /// Begins again after a silence that disengaged the peer; counters of what was sent go on, where a law has any.
    fn restart(&self, state: &mut Self::State, local: Motion<S>) {
        *state = self.start(local);
    }
    /// Takes in the other peer's packet, which is held until the next.
    fn receive(&self, state: &mut Self::State, packet: Packet<S>);
    /// Whether [`Law::receive`] only stores signals of the packet where its [`StateVector`] visits them, so that to receive it again changes
    /// nothing, and nothing depends on how old it is: scenes with such a law are simulated side by side although other packets of theirs are
    /// lost.
    fn only_holds(&self) -> bool {
        false
    }
    /// One tick: the coordination force on the local copy, N, from what is observed and what was received.
    ///
    /// A law gives `solve` its [`Port`], a force affine in the copy's velocity, and gets that velocity (m/s) back; its
    /// force is then `port.at(velocity)`. [`Spring::force`] does so for a law that is a spring and a damper. With the
    /// staged integrators of the papers the velocity is the one at the start of the tick; with the midpoint rule it is
    /// the mean of the tick, solved from all ports (THEORY §7). There a law that gives [`Port::of_force`], a force that
    /// does not depend on the velocity, makes energy if it is stiff, and one that does not call `solve` leaves the copy
    /// where it is. By default there is no force.
    #[inline]
    fn couple(&self, _state: &mut Self::State, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        solve.velocity(Port::default());
        Coupled::none(observed.local)
    }
    /// What to send now: everything up to and including the last tick.
    fn send(&self, state: &Self::State, local: Motion<S>) -> Packet<S>;
    /// Whether `packet`, which [`Law::send`] has just made, is worth sending. Asked in each packet period until the
    /// silence that [`event::LONGEST`] allows is over.
    fn speaks(&self, _state: &Self::State, _packet: &Packet<S>) -> bool {
        true
    }
    /// Whether its force acts on the device itself: there is no copy then but the device, which is what the law observes, and beside it as the
    /// force of contact the reaction of what acts on the device by now. Such a law refuses integrators that solve.
    fn acts_on_device(&self) -> bool {
        false
    }
    /// Takes note that `packet` goes out, where [`event::LONGEST`] allows silence.
    fn spoke(&self, _state: &mut Self::State, _packet: &Packet<S>) {}
    /// What goes out instead of `packet` from a peer that is not engaged, and whose copy is `local`: at rest where that stands, so that a
    /// wave line ends in its own impedance and takes everything in. Counters stay.
    fn idle(&self, packet: Packet<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: Motion::at(local.position), wave: S::ZERO, ..packet }
    }
    /// Whether its packets count for less and less during silence ([`Packet::faded`]); if not, they stand until the peer disengages.
    fn fades(&self) -> bool {
        true
    }
}

/// The entry of these that the settings name.
pub fn named(settings: &Settings, laws: &'static [LawInfo]) -> Option<&'static LawInfo> {
    laws.iter().find(|info| info.name == settings.coordination.comm)
}

/// That the settings name none of these.
pub fn unknown(settings: &Settings, laws: &'static [LawInfo]) -> Refused<'static> {
    settings.refuses("coordination.comm", Allowed::Laws(laws))
}

/// Declares a list of laws, which is a [`Law`] itself: any of them, chosen by name as a peer is built. Each is a type that computes in `S`.
/// Its state leaves alone what another law's is handed.
///
/// ```
/// use cohold_core::law::{Law, free::Free, power::Power};
///
/// cohold_core::laws! {
///     /// One of two.
///     pub enum Two, TwoState { Power(Power<S>), Free(Free) }
/// }
/// assert_eq!(Two::<f32>::LAWS.len(), 2);
/// ```
#[macro_export]
macro_rules! laws {
    ($(#[$doc:meta])* pub enum $Any:ident, $AnyState:ident { $( $Variant:ident($law:ty) ),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        #[allow(missing_docs, clippy::large_enum_variant)]
        // A tag of its own in both: one among the unused values of a field takes six instructions to read.
        #[repr(u32)]
        pub enum $Any<S: $crate::num::Scalar> { $( $Variant($law) ),+ }

        /// The state of any of them. What a law is handed that is not its own it leaves alone, and it couples nothing.
        #[derive(Clone, Copy, Debug)]
        #[allow(missing_docs, clippy::large_enum_variant)]
        #[repr(u32)]
        pub enum $AnyState<S: $crate::num::Scalar> { $( $Variant(<$law as $crate::law::Law<S>>::State) ),+ }

        const _: () = {
            use $crate::law::{Coupled, Law, LawInfo, Observation, Packet, bounds::Bounds};
            use $crate::num::{Configured, Motion, Scalar, StateVector};
            use $crate::object::Solve;
            use $crate::settings::{Refused, Settings};

            impl<S: Scalar> StateVector<S> for $AnyState<S> {
                #[inline]
                fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
                    match self { $( Self::$Variant(state) => state.visit(each) ),+ }
                }
            }

            /// Its name, and what it was built with.
            impl<S: Scalar> Configured for $Any<S> {
                fn configuration(&self, each: &mut dyn FnMut(u64)) -> bool {
                    match self { $( Self::$Variant(law) => {
                        let [info] = <$law as Law<S>>::LAWS else { return false };
                        info.name.bytes().for_each(|letter| each(letter.into()));
                        law.configuration(each)
                    } ),+ }
                }
            }

            impl<S: Scalar> Law<S> for $Any<S> {
                const LAWS: &'static [LawInfo] = &[$( <$law as Law<S>>::LAWS[0] ),+];
                type State = $AnyState<S>;

                fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
                    // Names alone: with `named` an image would hold the list of each law beside that of all.
                    $( if settings.coordination.comm == <$law as Law<S>>::LAWS[0].name {
                        return Ok(Self::$Variant(Law::<S>::build(settings)?));
                    } )+
                    Err($crate::law::unknown(settings, Self::LAWS))
                }
                fn bounds(settings: &Settings) -> Bounds {
                    $( if settings.coordination.comm == <$law as Law<S>>::LAWS[0].name {
                        return <$law as Law<S>>::bounds(settings);
                    } )+
                    Bounds::of_waves(settings)
                }
                fn compliance(settings: &Settings, delay_s: f64) -> [f64; 2] {
                    $( if settings.coordination.comm == <$law as Law<S>>::LAWS[0].name {
                        return <$law as Law<S>>::compliance(settings, delay_s);
                    } )+
                    [0.0; 2]
                }
                fn start(&self, local: Motion<S>) -> Self::State {
                    match self { $( Self::$Variant(law) => $AnyState::$Variant(law.start(local)) ),+ }
                }
                fn restart(&self, state: &mut Self::State, local: Motion<S>) {
                    match (self, state) { $( (Self::$Variant(law), $AnyState::$Variant(state)) => law.restart(state, local), )+ _ => {} }
                }
                fn receive(&self, state: &mut Self::State, packet: Packet<S>) {
                    match (self, state) { $( (Self::$Variant(law), $AnyState::$Variant(state)) => law.receive(state, packet), )+ _ => {} }
                }
                // Compiled into its caller as it stands, where each copy is made only for the law that needs it.
                #[inline(always)]
                fn couple(&self, state: &mut Self::State, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
                    match (self, state) { $(
                        (Self::$Variant(_), $AnyState::$Variant(_)) if <$law as Law<S>>::PORTS_ONLY && solve.is_staged() => Coupled::none(observed.local),
                        // A copy for each: what one law takes by reference would be in memory for all.
                        (Self::$Variant(law), $AnyState::$Variant(state)) => law.couple(state, &{ *observed }, solve),
                    )+ _ => Coupled::none(observed.local) }
                }
                fn send(&self, state: &Self::State, local: Motion<S>) -> Packet<S> {
                    match (self, state) { $( (Self::$Variant(law), $AnyState::$Variant(state)) => law.send(state, local), )+ _ => Packet::default() }
                }
                fn speaks(&self, state: &Self::State, packet: &Packet<S>) -> bool {
                    match (self, state) { $( (Self::$Variant(law), $AnyState::$Variant(state)) => law.speaks(state, packet), )+ _ => true }
                }
                fn spoke(&self, state: &mut Self::State, packet: &Packet<S>) {
                    match (self, state) { $( (Self::$Variant(law), $AnyState::$Variant(state)) => law.spoke(state, packet), )+ _ => {} }
                }
                fn only_holds(&self) -> bool {
                    match self { $( Self::$Variant(law) => Law::<S>::only_holds(law) ),+ }
                }
                fn acts_on_device(&self) -> bool {
                    match self { $( Self::$Variant(law) => Law::<S>::acts_on_device(law) ),+ }
                }
                fn idle(&self, packet: Packet<S>, local: Motion<S>) -> Packet<S> {
                    match self { $( Self::$Variant(law) => Law::<S>::idle(law, packet, local) ),+ }
                }
                fn fades(&self) -> bool {
                    match self { $( Self::$Variant(law) => Law::<S>::fades(law) ),+ }
                }
            }
        };
    };
}

laws! {
    /// Any coordination law of this crate; each is described on the page of its module.
    pub enum AnyLaw, AnyLawState {
        Power(power::Power<S>),
        PPlusD(p_plus_d::PPlusD<S>),
        Wave(wave::Wave<S>),
        PassiveWave(wave::PassiveWave<S>),
        PassiveMean(wave::PassiveMean<S>),
        SelfTimed(self_timed::SelfTimed<S>),
        FourChannel(four_channel::FourChannel<S>),
        Free(free::Free),
    }
}

/// The spring and damper K_T, B_T between the local copy and the desired motion x_d, ẋ_d.
#[derive(Clone, Copy, Debug)]
pub struct Spring<S> {
    /// Coordination stiffness K_T, N/m.
    pub stiffness: S,
    /// Coordination damping B_T, N·s/m.
    pub damping: S,
    /// Impedance κ = K_T·T_c/2 + B_T (K_T·T_c + B_T with backward Euler), N·s/m: by how much the mean force falls per m/s of the copy
    /// (THEORY §7).
    pub impedance: S,
}

configured!([S: Scalar] Spring<S> { stiffness, damping, impedance });

impl<S: Scalar> Spring<S> {
    /// The spring of the scene's K_T and B_T.
    pub fn build(settings: &Settings) -> Self {
        let coordination = &settings.coordination;
        Self {
            stiffness: S::from_f64(coordination.stiffness_n_per_m),
            damping: S::from_f64(coordination.damping_n_s_per_m),
            impedance: S::from_f64(Self::impedance(settings)),
        }
    }

    /// κ of the scene, N·s/m.
    pub fn impedance(settings: &Settings) -> f64 {
        let coordination = &settings.coordination;
        port::met_midway(coordination.stiffness_n_per_m, coordination.damping_n_s_per_m, settings)
    }

    /// F_T through a tick in which the desired motion is held, N: from both motions as they are with staged
    /// integrators, else from [`Spring::port`] and the copy's mean velocity.
    #[inline]
    pub fn force(&self, desired: Motion<S>, local: Motion<S>, solve: impl Solve<S>) -> S {
        if solve.is_staged() {
            let stretch = desired.position - local.position;
            return self.stiffness * stretch + self.damping * (desired.velocity - local.velocity);
        }
        let port = self.port(desired, local);
        port.at(solve.velocity(port))
    }

    /// F_T as a port, through a tick in which the copy moves and the desired motion is held.
    #[inline]
    pub fn port(&self, desired: Motion<S>, local: Motion<S>) -> Port<S> {
        let stretch = desired.position - local.position;
        Port::new(self.stiffness * stretch + self.damping * desired.velocity, self.impedance)
    }
}
