//! Time-domain passivity approach of a two-port: velocity goes out, force comes back, and an observer and a controller at either port keep the network
//! passive (Ryu, Artigas & Preusche 2010, "A passive bilateral control scheme for a teleoperator with time-varying communication delay", Mechatronics
//! 20), with a compensator of position drift (Artigas, Ryu & Preusche 2010; Chawda, Ott & O'Malley 2014).
//!
//! Peer 1 (`contact.side` left) is the **master**: it sends its copy's motion and shows the force that comes back, an impedance port. Peer 2 is the **slave**: its copy
//! hangs by K_T, B_T on a point x_sd that moves as the master's copy was said to, an admittance port, and it sends the force f_s of that spring.
//!
//! > master:  F_T = −f_s(t − T) − α·v           slave:  F_T = f_s = K_T·(x_sd − x_o) + B_T·(ẋ_sd − v),   ẋ_sd = ẋ_m(t − T) + (x_m(t − T) − x_sd)/τ − β·f_s
//!
//! **Observers**, one a port: P is the power that leaves the network there, −f_s·v at the master and f_s·ẋ_sd at the slave. What is below 0 came in: it is summed in
//! E_in, which travels with every packet. What is above 0 went out, E_out. Of each port, with all that the other end is known to have put in,
//!
//! > W(k) = E_in,far(k − T) − E_out(k) + E_PC(k) + E₀ ≥ 0,   E₀ = `coordination.tank_j`.
//!
//! **Controllers** take out of P what W does not cover. The admittance one is the paper's, β = (T_c·P − W)/(T_c·f_s²) where that is above 0: a
//! step Δ of x_sd costs K_T·((s + Δ)² − s²)/2, s = x_sd − x_o, which is known before it is made; Δ is the largest that is covered. The paper's impedance one adds
//! α = −W/(T_c·v²) once W was found to be below 0; here v is known only when it is too late, so that α is the smallest which no velocity gets the better of,
//! α = T_c·f_s²/(4W): 0.01 N·s/m at 1 N and 20 mJ, and at most 2m_O/T_c. What α dissipates is E_PC. What of f_s an account that is all but empty does not cover is left out where it
//! would give energy; where it takes energy from the copy, as that moves, it is shown as a damper of the same force, which is P < 0 at any v.
//!
//! **Drift**: β and lost packets leave x_sd behind. x_m is sent beside ẋ_m, and the second term goes to it with a time constant of τ (`tdpa.drift_s`; 0: the scheme
//! of the first paper, which drifts), as far as W pays for. Between packets the last sample of velocity and force is held.
//!
//! **Differs**, beside α: W holds at most [`super::credit::CAP_J`] or E₀, for what was dissipated in minutes must not come back as one blow; the slave's damper is held back by
//! what W pays for at any v, T_c·B_T·ẋ_sd²/4.
//!
//! **What holds**: on any network both copies together get no more from the coordination than 2·E₀ and what was stored in K_T. **What it costs**: the two hands are not alike, and the
//! master's is pushed by a force that is a round trip late: stable by itself only with a soft K_T and a B_T to match, else W is what bounds it. The scheme is made for a
//! master that leads and an environment that gives nothing: an energy that comes back is known of a trip later, W of the master pays until then, and what the slave's damper and β
//! dissipate nobody puts in again. Once both accounts are empty a slave that pushes moves no master, and the copies part. So no promise that nothing drifts.
//! Needs `object.integrator = "midpoint"`.

use super::tank::{START, Tank, Tanks};
use super::{Coupled, Law, LawInfo, Observation, Packet, Promise, Sends, Spring};
use crate::names::Side;
use crate::num::{Motion, Scalar, StateVector, visit_counter};
use crate::object::{Port, Solve};
use crate::settings::{Key, Refused, Settings};

const DRIFT: Key = Key::number(
    "tdpa.drift_s",
    0.1,
    [0.0, 100.0],
    "s",
    "TDPA: time in which 1/e of a position drift of the slave is left; 0: drift is not compensated.",
);

/// One port of the network: the master's or the slave's.
#[derive(Clone, Copy, Debug)]
pub struct Tdpa<S: Scalar> {
    tanks: Tanks<S::Counter>,
    /// It is the master's.
    leads: bool,
    /// K_T, N/m.
    stiffness: S::Counter,
    /// B_T, N·s/m.
    damping: S::Counter,
    /// K_T·T_c/2 + B_T, N·s/m.
    impedance: S,
    /// 4/T_c, 1/s.
    rate: S::Counter,
    /// Largest α, 2m_O/T_c, N·s/m.
    most_resistance: S::Counter,
    /// T_c/τ of a tick, 1 − e^(−T_c/τ).
    share: S::Counter,
}

configured!([S: Scalar] Tdpa<S> {
    tanks, leads, stiffness, damping, impedance, rate, most_resistance, share
});

/// State of one port.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TdpaState<S: Scalar> {
    /// The other copy as last received; the slave carries its position on by its velocity.
    remote: Motion<S>,
    /// Force received, N.
    reflected: S,
    /// Force of the newest tick, N.
    own: S,
    /// x_sd, m; at the master where its copy is.
    point: S::Counter,
    /// W.
    tank: Tank<S::Counter>,
}

impl<S: Scalar> TdpaState<S> {
    /// W, J; never negative.
    pub fn account_j(&self) -> S::Counter {
        self.tank.level_j
    }
}

impl<S: Scalar> StateVector<S> for TdpaState<S> {
    #[inline]
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        self.remote.visit(each);
        each(&mut self.reflected);
        each(&mut self.own);
        visit_counter::<S>(&mut self.point, each);
    }
}

/// A port before its tick is solved.
#[derive(Clone, Copy, Debug)]
struct Prepared<S: Scalar> {
    port: Port<S>,
    /// Of the master's force what is covered, N; of the slave's the cost of its step, J.
    covered: S::Counter,
    /// α, N·s/m, or ẋ_sd as far as the damper has it, m/s.
    controlled: S::Counter,
    /// The damper that stands for a force that is not covered, N·s/m.
    brake: S::Counter,
}

/// What a solve need not be compiled with, once for all of them.
impl<S: Scalar> Tdpa<S> {
    /// The master's port.
    #[inline(never)]
    fn reflect(&self, state: &mut TdpaState<S>, local: Motion<S>) -> Prepared<S> {
        let (level, wanted) = (state.tank.level_j, -state.reflected.to_counter());
        state.point = local.position.to_counter();
        // Written so that no number is no force.
        let force = wanted.limit((self.rate * self.most_resistance * level).sqrt());
        let resistance = (force * force).ratio(self.rate * level);
        let (uncovered, before) = (wanted - force, local.velocity.to_counter());
        let brake = if uncovered * before < S::Counter::ZERO {
            (-uncovered).over(before).min(self.most_resistance)
        } else {
            S::Counter::ZERO
        };
        let port = Port { force: S::of_counter(force), impedance: S::of_counter(resistance + brake) };
        Prepared { port, covered: force, controlled: resistance, brake }
    }

    /// The slave's port, its point moved.
    #[inline(never)]
    fn follow(&self, state: &mut TdpaState<S>, local: Motion<S>) -> Prepared<S> {
        let Tanks { period_s, .. } = self.tanks;
        let ahead = period_s * state.remote.velocity.to_counter();
        let drift = state.remote.position.to_counter() - state.point;
        let local = local.position.to_counter();
        let (level, before) = (state.tank.level_j, state.point - local);
        let wanted = before + ahead + self.share * drift;
        let (after, cost) = self.tanks.stretch(&mut state.tank, self.stiffness, before, wanted);
        // What is taken out of the spring is the other end's to spend.
        let left = if cost < S::Counter::ZERO { level } else { state.tank.level_j };
        state.tank.level_j = level;
        state.point = local + after;
        state.remote.position = state.remote.position + S::of_counter(ahead);

        // 0 without a damper, of which no velocity is asked.
        let most = (self.rate * left).ratio(self.damping).sqrt();
        let carried = (after - before).over(period_s).limit(most);
        let force = self.stiffness * after + self.damping * carried;
        let port = Port { force: S::of_counter(force), impedance: self.impedance };
        Prepared { port, covered: cost, controlled: carried, brake: S::Counter::ZERO }
    }

    /// Books a tick at this mean velocity (m/s) of the copy; the power that came in at the port, W.
    #[inline(never)]
    fn book(&self, state: &mut TdpaState<S>, prepared: &Prepared<S>, velocity: S::Counter) -> S::Counter {
        let (Tanks { period_s, .. }, nothing) = (self.tanks, S::Counter::ZERO);
        let Prepared { covered, controlled, brake, .. } = *prepared;
        let (out, dissipated) = if self.leads {
            (covered * velocity - brake * velocity * velocity, controlled * velocity * velocity)
        } else {
            // The copy gets no more of this than was covered: a spring's part was paid for, and the damper's is at most what is left.
            (covered.over(period_s) + self.damping * (controlled - velocity) * controlled, nothing)
        };
        self.tanks.settle(&mut state.tank, period_s * (dissipated - out.max(nothing)));
        (-out).max(nothing)
    }
}

impl<S: Scalar> Law<S> for Tdpa<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "tdpa",
        sends: Sends::Motion,
        keys: &[START, DRIFT],
        gains: &[
            "coordination.stiffness_n_per_m=310",
            // Without delay it would be stable with less; 8 ms each way take some 5 N·s/m.
            "coordination.damping_n_s_per_m=8",
            "object.integrator=midpoint",
        ],
        source: "Ryu, Artigas & Preusche 2010, two-port; drift: Artigas, Ryu & Preusche 2010",
        promises: &[Promise::Passive],
    }];
    type State = TdpaState<S>;
    const PORTS_ONLY: bool = true;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let (period, coordination) = (settings.timing.control_period_s, &settings.coordination);
        let drift = settings.own(&DRIFT);
        let share = if drift > 0.0 { -libm::expm1(-period / drift) } else { 0.0 };
        Ok(Self {
            tanks: Tanks::build(settings, &START)?,
            leads: settings.contact.side == Side::Left,
            stiffness: S::Counter::from_f64(coordination.stiffness_n_per_m),
            damping: S::Counter::from_f64(coordination.damping_n_s_per_m),
            impedance: Spring::build(settings).impedance,
            rate: S::Counter::from_f64(4.0 / period),
            most_resistance: S::Counter::from_f64(2.0 * settings.object.mass_kg / period),
            share: S::Counter::from_f64(share),
        })
    }

    fn start(&self, local: Motion<S>) -> TdpaState<S> {
        let point = local.position.to_counter();
        TdpaState { remote: local, point, tank: self.tanks.start(), ..TdpaState::default() }
    }

    fn restart(&self, state: &mut TdpaState<S>, local: Motion<S>) {
        *state = TdpaState { tank: self.tanks.restart(&state.tank), ..self.start(local) };
    }

    fn receive(&self, state: &mut TdpaState<S>, packet: Packet<S>) {
        (state.remote, state.reflected) = (packet.motion, packet.wave);
        state.tank.receive(&packet);
    }

    #[inline]
    fn couple(&self, state: &mut TdpaState<S>, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        let power_in = S::of_counter(self.tanks.fill(&mut state.tank));
        let prepared =
            if self.leads { self.reflect(state, observed.local) } else { self.follow(state, observed.local) };
        let mean = solve.velocity(prepared.port);
        state.own = prepared.port.at(mean);
        let power_out = S::of_counter(self.book(state, &prepared, mean.to_counter()));
        let position = if self.leads { state.remote.position } else { S::of_counter(state.point) };
        let desired = Motion { position, velocity: state.remote.velocity };
        Coupled { desired, force: state.own, power_in, power_out }
    }

    fn send(&self, state: &TdpaState<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, wave: state.own, ..Packet::default() }
    }
}
