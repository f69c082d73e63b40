//! Coordination laws: what holds the two copies of the shared object together.
//!
//! A law sees its own copy move ([`Law::couple`], every tick), hands out one [`Packet`] each packet period
//! ([`Law::send`]) and takes in the other peer's ([`Law::receive`]). **A new law is one file here, its `pub mod`, and one
//! line in the list below**: simulator, analyser, campaign, board and reports find it there, and go by what it [`Sends`].
//! [`free`] shows the least a law can be.
//!
//! Sign: the coordination force F_T acts on the local copy, F_T = K_T·(x_d − x_o) + B_T·(ẋ_d − ẋ_o)
//! (cooperation paper §3, eq. 7).

pub mod credit;
pub mod decimate;
pub mod free;
pub mod ladder;
pub mod ledger;
pub mod node;
pub mod power;
pub mod wave;

use crate::model::Model;
use crate::num::{Motion, Scalar, StateVector};
use crate::settings::Settings;

/// What crosses the network once each packet period. A law fills the fields it uses; the others stay 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Packet<S> {
    /// Motion of the sender's copy of the object, m and m/s (power-domain).
    pub motion: Motion<S>,
    /// Wave sample, √W (wave-domain).
    pub wave: S,
    /// Wave energy that the sender absorbed since it was armed, up to its last tick, J. Filled in by the peer.
    pub energy_j: f64,
    /// Integral of the sender's outgoing wave over the same time, √W·s.
    pub wave_integral: f64,
}

/// The signals that a peer may send, in the order of declaration; the counters beside them are no state of a linear line.
impl<S> StateVector<S> for Packet<S> {
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        self.motion.visit(each);
        each(&mut self.wave);
    }
}

impl<S: Scalar> Packet<S> {
    /// Every field finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.motion.is_finite() && self.wave.is_finite() && self.energy_j.is_finite() && self.wave_integral.is_finite()
    }
}

/// What a law did in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coupled<S> {
    /// Where the law wants the local copy: the decoded remote copy x_d, ẋ_d.
    pub desired: Motion<S>,
    /// Coordination force F_T on the local copy, N.
    pub force: S,
    /// Power that came in from the network, ½·u_in², W, never negative.
    pub power_in: S,
    /// Power that went out to the network, ½·u_out², W, never negative.
    pub power_out: S,
}

impl<S: Scalar> Coupled<S> {
    /// Force and powers finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        // One test for three: a sum is finite only if its terms are.
        (self.force + self.power_in + self.power_out).is_finite()
    }
}

/// What a law sends, which is also what it acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sends {
    /// Nothing.
    Nothing,
    /// The motion of its copy.
    Motion,
    /// Waves, whose energy can be counted: only these can be paid for by a ledger, and meet in a node.
    Waves,
}

/// What the law sends that these settings name.
pub fn sends(settings: &Settings) -> Sends {
    AnyLaw::<f64>::build(settings).sends()
}

/// A coordination law.
pub trait Law<S: Scalar>: Model<S> {
    /// What [`Law::send`] fills in.
    fn sends(&self) -> Sends;
    /// Engages at rest with the local copy: no force until something moves.
    fn start(&self, state: &mut Self::State, local: Motion<S>);
    /// Takes in the other peer's packet; it stands until the next.
    fn receive(&self, state: &mut Self::State, packet: Packet<S>);
    /// One tick: the force on the local copy from the copy's motion and what was received.
    fn couple(&self, state: &mut Self::State, local: Motion<S>) -> Coupled<S>;
    /// What to send now: everything up to and including the last tick.
    fn send(&self, state: &Self::State, local: Motion<S>) -> Packet<S>;
}

list! {
    /// Any coordination law.
    Law: AnyLaw, AnyLawState, named by LawName in coordination.comm {
        "power" => Power(power::Power<S>),
        "wave" => Wave(wave::Wave<S>),
        "passive-wave" => PassiveWave(wave::PassiveWave<S>),
        "passive-mean" => PassiveMean(wave::PassiveMean<S>),
        "none" => Free(free::Free),
    }
    fn sends(&self) -> Sends;
    fn start(&self, [&mut] state; local: Motion<S>);
    fn receive(&self, [&mut] state; packet: Packet<S>);
    fn couple(&self, [&mut] state; local: Motion<S>) -> Coupled<S>;
    fn send(&self, [&] state; local: Motion<S>) -> Packet<S>;
}

/// The spring and damper K_T, B_T between the copy and where it should be.
#[derive(Clone, Copy, Debug)]
pub struct Spring<S> {
    /// K_T, N/m.
    pub stiffness: S,
    /// B_T, N·s/m.
    pub damping: S,
}

impl<S: Scalar> Spring<S> {
    /// K_T and B_T of the scene.
    pub fn build(settings: &Settings) -> Self {
        let coordination = &settings.coordination;
        Self {
            stiffness: S::from_f64(coordination.stiffness_n_per_m),
            damping: S::from_f64(coordination.damping_n_s_per_m),
        }
    }

    /// F_T, N.
    #[inline]
    pub fn force(&self, desired: Motion<S>, local: Motion<S>) -> S {
        self.stiffness * (desired.position - local.position) + self.damping * (desired.velocity - local.velocity)
    }
}
