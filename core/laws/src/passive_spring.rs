//! A spring between the copies whose middle moves only as far as energy pays for it: a law of this project, after time-domain passivity control and
//! passive set-position modulation.
//!
//! The spring K_T between the copies is two springs of 2K_T in a row, and x_m, where they meet, is the network's port: each end
//! holds its own half, 2K_T·(x_m − x_o), which is the force K_T·(x_d − x_o) where x_m is the middle of the copies. Within a
//! tick x_m is at rest; between two ticks it moves by Δ toward the middle, ½(x_o + x_d), x_d of the newest packet. That costs
//!
//! > ΔV = K_T·((s + Δ)² − s²),   s = x_m − x_o
//!
//! - **Account**: a cost below 0 is energy that this end absorbs; it goes into what the packets say was absorbed, E_in. A cost above 0 is
//!   what the end emits, E_out. W = E_in of the other end, as far as it is known, less E_out of this one, from the tank's start on.
//! - **Limit**: x_m moves so far that W stays at or above 0, and no farther. No tick generates energy that must be made good, for its cost is known
//!   before it is spent.
//! - **Drift**: what x_m was held back by is not forgotten, for it goes to a position; it moves on as soon as W allows.
//!
//! The damper, F_B = B_T·(ẋ_d − v), is held back the same way: ẋ_d is not above what W pays for at any v (T_c·B_T·ẋ_d²/4 ≤ W), and W loses
//! T_c·F_B·v, or gains what the damper took from the copy. At no delay nothing is held back: what one end emits the other absorbs.
//!
//! **After** Ryu, Artigas & Preusche 2010 (Mechatronics 20), whose bookkeeping it has: energy into and out of each port apart, and what came in travels
//! with the packets. It **differs** in what is coupled: positions against positions, both ends alike, instead of a velocity one way
//! and a force back; a port in the middle of the spring; and a limit on a step whose cost is known, which for a spring is what Lee & Huang's set-position modulation does
//! (2010, [`crate::set_position`]; there the set position is the other copy's, the account is filled by a damper, and the harvest is sent), instead of a
//! damping that makes good a tick later. Its name was `passivity-control`.
//!
//! **What holds**: on any network both copies together get no more from the coordination than both tanks had at first; what is in the halves
//! of the spring is counted. No drift as long as W is above 0 when the network has recovered; it is, unless dampers of the
//! object, contacts or hands have taken all there was: then x_m waits for the next energy that anybody puts in.

use crate::tank::{START, Tank, Tanks};
use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Promise};
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::port::{Port, Solve, met_midway};
use cohold_core::settings::{Refused, Settings};

/// One end: half of the spring K_T, whose far end x_m moves only as far as the energy account W pays for.
#[derive(Clone, Copy, Debug)]
pub struct PassiveSpring<S: Scalar> {
    tanks: Tanks<S::Counter>,
    /// 2K_T, N/m.
    stiffness: S::Counter,
    /// B_T, N·s/m.
    damping: S::Counter,
    /// √(4/(T_c·B_T)), m/s for each √J; 0 without damping.
    fastest: S::Counter,
    /// 2K_T·T_c/2 + B_T, N·s/m.
    impedance: S,
}

configured!([S: Scalar] PassiveSpring<S> { tanks, stiffness, damping, fastest, impedance });

/// State of one end: the motion received, the place x_m of the network port, and the energy account W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassiveSpringState<S: Scalar> {
    /// x_d and ẋ_d as received.
    remote: Motion<S>,
    /// x_m, m.
    middle: S::Counter,
    /// W.
    tank: Tank<S::Counter>,
}

visited!([S: Scalar] PassiveSpringState<S> { remote });

impl<S: Scalar> Law<S> for PassiveSpring<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "passive-spring",
        formerly: "passivity-control",
        keys: &[START],
        gains: &["coordination.stiffness_n_per_m=1000", "object.integrator=midpoint"],
        source: "this project; after Ryu, Artigas & Preusche 2010 and Lee & Huang 2010",
        promises: &[Promise::Passive, Promise::NoDrift],
        ..LawInfo::MOTION
    }];
    type State = PassiveSpringState<S>;
    const PORTS_ONLY: bool = true;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let (period, coordination) = (settings.timing.control_period_s, &settings.coordination);
        let (stiffness, damping) = (2.0 * coordination.stiffness_n_per_m, coordination.damping_n_s_per_m);
        let fastest = if damping > 0.0 { libm::sqrt(4.0 / (period * damping)) } else { 0.0 };
        Ok(Self {
            tanks: Tanks::build(settings, &START)?,
            stiffness: S::Counter::from_f64(stiffness),
            damping: S::Counter::from_f64(damping),
            fastest: S::Counter::from_f64(fastest),
            impedance: S::from_f64(met_midway(stiffness, damping, settings)),
        })
    }

    fn start(&self, local: Motion<S>) -> PassiveSpringState<S> {
        PassiveSpringState { remote: local, middle: local.position.to_counter(), tank: self.tanks.start() }
    }

    fn restart(&self, state: &mut PassiveSpringState<S>, local: Motion<S>) {
        *state = PassiveSpringState { tank: self.tanks.restart(&state.tank), ..self.start(local) };
    }

    fn receive(&self, state: &mut PassiveSpringState<S>, packet: Packet<S>) {
        state.remote = packet.motion;
        state.tank.receive(&packet);
    }

    fn couple(&self, state: &mut PassiveSpringState<S>, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        let period = self.tanks.period_s;
        let power_in = self.tanks.fill(&mut state.tank);
        let local = observed.local.position.to_counter();
        let wanted = self.tanks.half * (state.remote.position.to_counter() - local);
        let before = state.tank.level_j;
        let (stretch, cost) = self.tanks.stretch(&mut state.tank, self.stiffness, state.middle - local, wanted);
        state.middle = local + stretch;
        let mut absorbed = S::Counter::ZERO;
        if cost < S::Counter::ZERO {
            // That is the other end's to spend.
            (state.tank.level_j, absorbed) = (before, -cost);
        }
        let carried = state.remote.velocity.to_counter().limit(self.fastest * state.tank.level_j.sqrt());
        let port = Port::new(S::of_counter(self.stiffness * stretch + self.damping * carried), self.impedance);
        let mean = solve.velocity(port);
        let velocity = mean.to_counter();
        self.tanks.settle(&mut state.tank, period * self.damping * (velocity - carried) * velocity);
        Coupled {
            desired: Motion { position: S::of_counter(local + stretch + stretch), velocity: S::of_counter(carried) },
            force: port.at(mean),
            power_in: S::of_counter(power_in),
            power_out: S::of_counter(absorbed.over(period)),
        }
    }

    fn send(&self, _: &PassiveSpringState<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, ..Packet::default() }
    }
}
