//! Deadband coding: a motion is worth a packet when its velocity differs from what was sent last by more than a hand would feel
//! (Hirche, Hinterseer, Steinbach & Buss 2007, "Transparent data reduction in networked telepresence and teleaction systems", Presence
//! 16(5); Hinterseer, Hirche, Chaudhuri, Steinbach & Buss 2008).
//!
//! **Sender**, Weber's law with a least threshold: ẋ is sent when |ẋ − ẋ*| > Δ, Δ = max(k·|ẋ*|, Δ₀), ẋ* the velocity in the packet before.
//! k = `WEBER`; hands notice some 10 %. On a ramp of velocity packets come at ẋ₀·(1 + k)ⁿ. And each [`event::LONGEST`] at the latest, for
//! Weber's law says nothing of position.
//!
//! **Receiver**, between packets, for no longer than that:
//!
//! | law | goes on at | on any network |
//! |---|---|---|
//! | `deadband` | ẋ*: hold the last sample; x_d is its integral from the position that came with it | as `power`, which makes energy |
//! | `passive-deadband` | ẋ* − Δ·sign(F_T), below | passive |
//!
//! **With passivity** (Hirche et al. 2007, the modified hold): of all velocities within the deadband the receiver assumes the one
//! that gives it the least energy, ẋ_d = ẋ* − Δ·sign(F_T), F_T·ẋ_d ≤ F_T·ẋ for every |ẋ − ẋ*| ≤ Δ. That is enough without delay.
//! On any network an energy account does the rest: the held motion is what [`crate::passive_spring`] moves its end of the
//! spring toward, which spends no more than the other end is known to have absorbed, W ≥ 0, and pays for its damper as well.
//! Where nothing empties the account ([`PLENTY_J`]) there is nothing to save: the hold is the plain one, and the law is linear.
//!
//! With `event.longest_s = 0` a packet goes each packet period, and either is the law it codes for, its motion carried on between packets.

use crate::passive_spring::PassiveSpring;
use crate::tank::START;
use cohold_core::law::event::{self, LONGEST};
use cohold_core::law::power::Power;
use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Promise};
use cohold_core::num::{Configured, Motion, Scalar, StateVector};
use cohold_core::object::Solve;
use cohold_core::settings::{Key, PLENTY_J, Refused, Settings};

const WEBER: Key = Key::number("deadband.weber", 0.1, [0.0, 1.0], "")
    .means("Deadband coding: change of velocity that is worth a packet, over the velocity that was sent last: Weber's fraction k.");
const LEAST: Key = Key::number("deadband.least_m_per_s", 0.002, [1e-6, 1.0], "m/s")
    .means("Deadband coding: the least change of velocity that is worth a packet, for Weber's law ends where a hand feels nothing.");

/// A law that sends motions, of which deadband coding chooses the ones worth a packet.
pub trait Coded<S: Scalar>: Law<S> {
    /// Name, keys and promises of the coded law.
    const INFO: LawInfo;
    /// Whether the receiver uses the modified hold.
    fn is_modified(settings: &Settings) -> bool;
}

impl<S: Scalar> Coded<S> for Power<S> {
    const INFO: LawInfo = LawInfo {
        name: "deadband",
        keys: &[LONGEST, WEBER, LEAST],
        gains: &[
            "coordination.stiffness_n_per_m=310",
            "event.longest_s=0.05",
            "safety.fade_s=0.1",
            "safety.disengage_s=0.4",
        ],
        source: "Hirche, Hinterseer, Steinbach & Buss 2007",
        ..LawInfo::MOTION
    };

    fn is_modified(_: &Settings) -> bool {
        false
    }
}

impl<S: Scalar> Coded<S> for PassiveSpring<S> {
    const INFO: LawInfo = LawInfo {
        name: "passive-deadband",
        keys: &[LONGEST, WEBER, LEAST, START],
        gains: &[
            "coordination.stiffness_n_per_m=1000",
            "object.integrator=midpoint",
            "event.longest_s=0.05",
            "safety.fade_s=0.1",
            "safety.disengage_s=0.4",
        ],
        source: "Hirche, Hinterseer, Steinbach & Buss 2007",
        promises: &[Promise::Passive],
        ..LawInfo::MOTION
    };

    fn is_modified(settings: &Settings) -> bool {
        settings.own(&START) < PLENTY_J
    }
}

/// Deadband coding of the power law: the last sample is held.
pub type Deadband<S> = Coding<S, Power<S>>;

/// Deadband coding with the modified hold and an energy account, so that the hold stays passive.
pub type PassiveDeadband<S> = Coding<S, PassiveSpring<S>>;

/// A law that sends a packet only when the motion changed by more than a hand would feel.
#[derive(Clone, Copy, Debug)]
pub struct Coding<S, L> {
    law: L,
    /// The modified hold.
    modified: bool,
    /// k.
    weber: S,
    /// Δ₀, m/s.
    least: S,
    /// T_c, s.
    period: S,
    /// Ticks for which a motion is carried on.
    longest: u32,
}

configured!([S: Scalar, L: Configured] Coding<S, L> { law, modified, weber, least, period, longest });

/// State of one end: the coded law's own, the packet that is held, and the velocity that was sent last.
#[derive(Clone, Copy, Debug)]
pub struct CodingState<S: Scalar, T> {
    law: T,
    /// The packet that stands.
    held: Packet<S>,
    /// How far its motion has been carried on, m.
    carried: S,
    /// Velocity of the newest packet sent, ẋ*, m/s.
    announced: S,
    /// F_T of the tick before, N.
    force: S,
}

visited!([S: Scalar, T: StateVector<S>] CodingState<S, T> { law, held.motion, carried, force });

impl<S: Scalar, L: Coded<S>> Coding<S, L> {
    /// Δ at this velocity, m/s.
    #[inline]
    fn band(&self, velocity: S) -> S {
        (self.weber * velocity.abs()).max(self.least)
    }

    /// Hands the law the motion that is held, as far as it is carried on by this tick.
    #[inline]
    fn carry_on(&self, state: &mut CodingState<S, L::State>, age_ticks: u32) {
        if age_ticks == 0 {
            state.carried = S::ZERO;
        }
        let announced = state.held.motion.velocity;
        let velocity = if age_ticks >= self.longest {
            S::ZERO
        } else if self.modified && state.force > S::ZERO {
            announced - self.band(announced)
        } else if self.modified && state.force < S::ZERO {
            announced + self.band(announced)
        } else {
            announced
        };
        let position = state.held.motion.position + state.carried;
        self.law.receive(&mut state.law, Packet { motion: Motion { position, velocity }, ..state.held });
        state.carried = state.carried + self.period * velocity;
    }
}

impl<S: Scalar, L: Coded<S>> Law<S> for Coding<S, L> {
    const LAWS: &'static [LawInfo] = &[L::INFO];
    type State = CodingState<S, L::State>;
    const PORTS_ONLY: bool = L::PORTS_ONLY;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let (timing, longest_s) = (&settings.timing, event::longest_s(settings)?);
        // A cast saturates.
        let longest = (longest_s / timing.control_period_s + 0.5) as u32;
        Ok(Self {
            law: L::build(settings)?,
            modified: L::is_modified(settings),
            weber: S::from_f64(settings.own(&WEBER)),
            least: S::from_f64(settings.own(&LEAST)),
            period: S::from_f64(timing.control_period_s),
            longest: longest.max(timing.ticks_per_packet),
        })
    }

    fn start(&self, local: Motion<S>) -> Self::State {
        let held = Packet { motion: Motion::at(local.position), ..Packet::default() };
        CodingState { law: self.law.start(local), held, carried: S::ZERO, announced: S::ZERO, force: S::ZERO }
    }

    fn restart(&self, state: &mut Self::State, local: Motion<S>) {
        self.law.restart(&mut state.law, local);
        *state = CodingState { law: state.law, ..self.start(local) };
    }

    /// The packet that stands comes again in silence: how far it is carried on is kept apart.
    fn receive(&self, state: &mut Self::State, packet: Packet<S>) {
        state.held = packet;
    }

    #[inline]
    fn couple(&self, state: &mut Self::State, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        self.carry_on(state, observed.age_ticks);
        let coupled = self.law.couple(&mut state.law, observed, solve);
        state.force = coupled.force;
        coupled
    }

    fn send(&self, state: &Self::State, local: Motion<S>) -> Packet<S> {
        self.law.send(&state.law, local)
    }

    fn speaks(&self, state: &Self::State, packet: &Packet<S>) -> bool {
        (packet.motion.velocity - state.announced).abs() > self.band(state.announced)
    }

    fn spoke(&self, state: &mut Self::State, packet: &Packet<S>) {
        state.announced = packet.motion.velocity;
    }
}
