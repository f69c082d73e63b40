//! Passivity observer and controller at one port (after Hannaford & Ryu 2002, "Time-domain passivity control of haptic interfaces", IEEE Transactions on
//! Robotics and Automation 18): in every tick the power-domain force is reduced to what this end has absorbed before. Only the motion is sent.
//!
//! The **observer** keeps what the coordination may still give to its own copy, exact by the midpoint rule (v: the copy's mean velocity):
//!
//! > W ← W − T_c·F_T·v,   W = E₀ when it begins (`coordination.tank_j`).
//!
//! The **controller** stands before the spring. As a port the power-domain law is F_T = f − κ·v, κ = K_T·T_c/2 + B_T, and gives the copy no more than
//! T_c·f²/(4κ) in a tick, at whatever v. So the gate lets through
//!
//! > F_T = g·f − κ·v,   g = min(1, √(4κ·W/T_c)/|f|),
//!
//! and **W ≥ 0 at every tick, whatever the packets say and the hand does**. What takes power out fills the account, up to [`CAP_J`]; an empty one leaves
//! the damper κ, which fills it again as soon as the copy moves.
//!
//! **Differs** from the paper in two things. Its controller adds the damping α = −W/(T_c·v²) that makes good in a tick what the observer found to be
//! missing; here a tick's worst is known before it is spent, so that nothing need be made good. And its observer has no bound on what it
//! remembers. The port is that of the network at the copy, not that of a device at a hand.
//!
//! **What holds**: each end is passive by itself, ∫F_T·ẋ_o dt ≤ E₀, on any network and beside any other peer, an untrue one included. **What it costs**: energy does not
//! cross. A copy that nobody holds is drawn along for as long as its account lasts; who pushes one copy moves the other by no more than was stored there. Laws
//! that send energy along (a ledger, a tank) do not pay that. Not promised: that drift is made good. Needs `object.integrator = "midpoint"`.
//!
//! `input-gated`, its name before, is another method (Kanai, Kanazawa, Ichiwara, Ito, Noguchi & Ogata 2025, arXiv 2509.08226; docs/reference/theory.md, section 12).

use crate::tank::{MIDPOINT, START, needs_midpoint};
use cohold_core::law::credit::CAP_J;
use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Promise, Spring};
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::{Port, Solve};
use cohold_core::settings::{Refused, Settings};

/// The power-domain spring and damper behind a passivity controller, the gate g.
#[derive(Clone, Copy, Debug)]
pub struct PassivityObserver<S> {
    spring: Spring<S>,
    /// 4κ/T_c, N²/J.
    budget: S,
    start: S,
    most: S,
    period: S,
}

configured!([S: Scalar] PassivityObserver<S> { spring, budget, start, most, period });

/// The received motion, and the energy account.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassivityObserverState<S> {
    /// x_d, ẋ_d.
    desired: Motion<S>,
    /// W, J, never negative.
    account: S,
}

impl<S: Scalar> PassivityObserverState<S> {
    /// Energy account W that the gate may still spend, J; never negative.
    pub fn account_j(&self) -> S {
        self.account
    }
}

// What was received; the account is a constant of a linear law.
visited!([S: Scalar] PassivityObserverState<S> { desired });

impl<S: Scalar> Law<S> for PassivityObserver<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "passivity-observer",
        formerly: "input-gated",
        keys: &[START],
        gains: MIDPOINT,
        source: "after Hannaford & Ryu 2002, one-port passivity observer and controller; a gate for the damper",
        promises: &[Promise::Passive],
        ..LawInfo::MOTION
    }];
    type State = PassivityObserverState<S>;
    const PORTS_ONLY: bool = true;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        needs_midpoint(settings)?;
        let (energy, period) = (settings.own(&START), settings.timing.control_period_s);
        Ok(Self {
            spring: Spring::build(settings),
            budget: S::from_f64(4.0 * Spring::<S>::impedance(settings) / period),
            start: S::from_f64(energy),
            most: S::from_f64(energy.max(CAP_J)),
            period: S::from_f64(period),
        })
    }

    fn start(&self, local: Motion<S>) -> PassivityObserverState<S> {
        PassivityObserverState { desired: local, account: self.start }
    }

    fn restart(&self, state: &mut PassivityObserverState<S>, local: Motion<S>) {
        // What was spent stays spent.
        state.desired = local;
    }

    fn receive(&self, state: &mut PassivityObserverState<S>, packet: Packet<S>) {
        state.desired = packet.motion;
    }

    #[inline]
    fn couple(
        &self,
        state: &mut PassivityObserverState<S>,
        observed: &Observation<S>,
        solve: impl Solve<S>,
    ) -> Coupled<S> {
        let open = self.spring.port(state.desired, observed.local);
        let (worst, covered) = (open.force * open.force, self.budget * state.account);
        // Written so that no number is no force.
        let force = if worst <= covered { open.force } else { open.force.limit(covered.sqrt()) };
        let port = Port { force, ..open };
        let velocity = solve.velocity(port);
        let force = port.at(velocity);
        let given = self.period * force * velocity;
        state.account = (state.account - given).max(S::ZERO).min(self.most);
        // No energy crosses the line.
        Coupled { desired: state.desired, force, ..Coupled::default() }
    }

    fn send(&self, _: &PassivityObserverState<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, ..Packet::default() }
    }
}
