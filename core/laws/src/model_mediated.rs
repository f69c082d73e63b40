//! Model-mediated coordination: a mass-spring-damper model of the other peer's copy and hand is simulated here, without
//! delay, and its parameters are estimated from what is received (Mitra & Niemeyer 2008; see Passenberg et al. 2010).
//!
//! The model has mass m̂, damping b̂, stiffness k̂ and a place of rest x̂₀. The local copy hangs on it by the scene's
//! K_T, B_T; what is received only corrects where it is, through K_c, B_c:
//!
//! > m̂·ẍ_p = −b̂·ẋ_p − k̂·(x_p − x̂₀) − F_T + g·F_c,   F_T = K_T·(x_p − x_o) + B_T·(ẋ_p − ẋ_o)
//! > F_c = K_c·(x_r − x_p) + B_c·(ẋ_r − ẋ_p),   0 ≤ g ≤ 1
//!
//! in one solve a tick with the copy, as [`crate::remote_dynamic_proxy`] does it.
//!
//! **What is estimated, and how.** Beside its motion a peer sends the mean F_T of the packet's M ticks (the packet's wave field, N). From one packet to the next
//! that mean moved its copy and hand, and by the midpoint rule, where m·Δẋ = T_c·ΣF and Δx = T_c·Σv are exact,
//!
//! > F̄_T = m·Δẋ/T_n + b·Δx/T_n + k·(x_k + x_{k−1})/2 − f,   f = k·x₀ (and what the hand pushes by itself)
//!
//! is fitted by recursive least squares with forgetting, θ = (m, b, k, f), φ the four factors:
//!
//! > γ = P·φ/(λR + φᵀ·P·φ),   θ ← θ + γ·(F̄_T − φᵀ·θ),   P ← (P − γ·φᵀ·P)/λ,   λ = e^(−T_n/`memory_s`)
//!
//! in units in which a parameter is about 1 ([`UNITS`]; R is the square of [`NOISE_N`]). A variance never exceeds what it began with, and a packet that tells
//! nothing (φᵀPφ < R/1000) changes nothing, so that nothing winds up while nobody moves. A packet after a lost one only gives the next a beginning.
//!
//! **How the model is updated.** With each packet the model goes toward the estimate, held to m_O/4…4·m_O, b̂ ≥ 0, k̂ ≥ 0, by the share
//! T_n·`rate_per_s`. If that raises ½·m̂·ẋ_p² + ½·k̂·(x_p − x̂₀)², the **account** pays the difference, or the model stays. The account
//! pays for the correction too: T_c·F_c·w is at most T_c·g·f_c²/(4κ_c) at whatever velocity w (f_c: F_c at w = 0, κ_c = K_c·T_c/2 + B_c),
//! and g is the largest that leaves it at or above 0. What the correction takes out of the model, and what b̂ does, goes to the other peer
//! (`energy_j`), whose account it fills: so a push is handed on with the energy it takes.
//!
//! **What holds**: model and copy are moved by one passive solve, and nothing is added that was not in an account. On any network both peers' copies together get
//! no more than both accounts began with (`coordination.tank_j`) and what was done on them. The channel by itself may give out more than came in, for
//! what a hand put into its own model pays, too. Not promised: that drift is made good, for an empty account corrects nothing; and a hand that pushes by
//! itself is no impedance: its push comes with the correction, late. Needs `object.integrator = "midpoint"`. With an account that
//! nothing empties ([`PLENTY_J`]) nothing is learned and the law is linear.

mod estimate;

use crate::tank::{MIDPOINT, START, needs_midpoint};
use cohold_core::law::credit::CAP_J;
use cohold_core::law::decimate::{Decimator, Mean, MeanState};
use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Spring};
use cohold_core::num::{Carry, Motion, Scalar};
use cohold_core::object::port::{Port, Solve, met_midway};
use cohold_core::settings::{Key, PLENTY_J, Refused, Settings};
use estimate::Estimate;

const STIFFNESS: Key = Key::number("model_mediated.correction_n_per_m", 100.0, [0.0, 1e5], "N/m")
    .means("Model-mediated: stiffness K_c that draws the model to the motion that was received.");
const DAMPING: Key = Key::number("model_mediated.correction_n_s_per_m", 4.0, [0.1, 1e3], "N·s/m")
    .means("Model-mediated: damping B_c toward the motion that was received.");
const RATE: Key = Key::number("model_mediated.rate_per_s", 5.0, [0.0, 1000.0], "1/s")
    .means("Model-mediated: how fast the model goes toward the estimate; 0: it stays as it begins.");
const MEMORY: Key = Key::number("model_mediated.memory_s", 0.5, [0.01, 100.0], "s")
    .means("Model-mediated: after this time a packet counts for 1/e in the estimate.");

/// Units of m, b, k and f in which the estimate is kept: kg, N·s/m, N/m, N.
pub const UNITS: [f64; 4] = [1.0, 10.0, 1000.0, 10.0];
/// Standard error of a packet's mean force, N.
pub const NOISE_N: f64 = 0.05;

/// The model of the other peer's copy and hand: a mass on a spring and damper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<S> {
    /// Estimated mass m̂, kg.
    pub mass: S,
    /// Estimated damping b̂, N·s/m.
    pub damping: S,
    /// Estimated stiffness k̂, N/m.
    pub stiffness: S,
    /// Estimated rest position of the spring x̂₀, m.
    pub rest: S,
}

configured!([S: Scalar] Model<S> { mass, damping, stiffness, rest });

/// A model of the other copy, and what corrects it.
#[derive(Clone, Copy, Debug)]
pub struct ModelMediated<S> {
    spring: Spring<S>,
    mean: Mean<S>,
    /// The model as it begins; its rest is where the law starts.
    first: Model<S>,
    /// m_O/4 and 4·m_O, kg.
    masses: [S; 2],
    /// K_c, B_c, κ_c.
    stiffness: S,
    damping: S,
    impedance: S,
    /// 4κ_c/T_c, N²/J.
    budget: S,
    start: S,
    most: S,
    /// Share of the way to the estimate that one packet takes; 0: nothing is learned.
    share: S,
    /// λR, R/1000 and 1/λ.
    memory: [S; 3],
    /// [`UNITS`].
    units: [S; 4],
    ticks_per_packet: u32,
    /// 1/T_n, 1/s.
    packet_rate: S,
    period: S,
    half_period: S,
    /// 2/T_c, 1/s.
    twice_rate: S,
    half: S,
}

configured!([S: Scalar] ModelMediated<S> {
    spring, mean, first, masses, stiffness, damping, impedance, budget, start, most, share, memory, units,
    ticks_per_packet, packet_rate, period, half_period, twice_rate, half
});

/// The model, what is known of the other copy, and what may be spent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelMediatedState<S: Scalar> {
    /// x_p, ẋ_p.
    body: Motion<S>,
    /// x_r, ẋ_r.
    remote: Motion<S>,
    model: Model<S>,
    estimate: Estimate<S>,
    /// Where the estimate's positions are measured from, m.
    origin: S,
    /// J, never negative.
    account: S,
    /// The other peer's energy counter in the newest packet, J, and its ticks.
    heard: Option<(S::Counter, u32)>,
    /// Mean F_T of a packet, N.
    sent: MeanState<S>,
    /// Ticks since the start.
    live: u32,
    /// What x_p could not hold: rounding, no state.
    carry: Carry<S>,
}

impl<S: Scalar> ModelMediatedState<S> {
    /// The model as it is now.
    pub fn model(&self) -> Model<S> {
        self.model
    }

    /// Energy that corrections of the model may still spend, J; never negative.
    pub fn account_j(&self) -> S {
        self.account
    }
}

// What moves; the model and the account are constants of a linear law.
visited!([S: Scalar] ModelMediatedState<S> { body, remote, sent });

impl<S: Scalar> Model<S> {
    /// ½·m̂·ẋ_p² + ½·k̂·(x_p − x̂₀)², J.
    fn energy(&self, body: Motion<S>, half: S) -> S {
        let stretch = body.position - self.rest;
        half * (self.mass * body.velocity * body.velocity + self.stiffness * stretch * stretch)
    }
}

impl<S: Scalar> ModelMediated<S> {
    /// What a packet says of the other copy, if the one before it is known.
    fn learn(&self, state: &mut ModelMediatedState<S>, packet: &Packet<S>) {
        let (before, now) = (state.remote, packet.motion);
        let middle = self.half * (before.position + now.position) - state.origin;
        let [m, b, k, f] = self.units;
        let factors = [
            m * self.packet_rate * (now.velocity - before.velocity),
            b * self.packet_rate * (now.position - before.position),
            k * middle,
            -f,
        ];
        state.estimate.learn(self.memory, factors, packet.wave);
        let [mass, damping, stiffness, push] = state.estimate.theta;
        let [least, most] = self.masses;
        let positive = |value: S| value.max(S::ZERO);
        let (damping, stiffness) = (positive(b * damping), positive(k * stiffness));
        let model = state.model;
        let toward = |from: S, to: S| from + self.share * (to - from);
        let next = Model {
            mass: toward(model.mass, (m * mass).max(least).min(most)),
            damping: toward(model.damping, damping),
            stiffness: toward(model.stiffness, stiffness),
            // Without a spring there is no place of rest: then where the body is.
            rest: if stiffness >= S::ONE {
                toward(model.rest, state.origin + (f * push).ratio(stiffness))
            } else {
                toward(model.rest, state.body.position)
            },
        };
        let price = next.energy(state.body, self.half) - model.energy(state.body, self.half);
        if price <= state.account {
            state.model = next;
            state.account = (state.account - price).min(self.most);
        }
    }
}

impl<S: Scalar> Law<S> for ModelMediated<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "model-mediated",
        learns: true,
        keys: &[START, STIFFNESS, DAMPING, RATE, MEMORY],
        gains: MIDPOINT,
        source: "Mitra & Niemeyer 2008; Passenberg, Peer & Buss 2010; estimation by recursive least squares",
        ..LawInfo::MOTION
    }];
    type State = ModelMediatedState<S>;
    const PORTS_ONLY: bool = true;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        needs_midpoint(settings)?;
        let [energy, stiffness, damping, rate, memory] =
            [START, STIFFNESS, DAMPING, RATE, MEMORY].map(|key| settings.own(&key));
        let (timing, object) = (&settings.timing, &settings.object);
        let (period, packet) = (timing.control_period_s, timing.packet_period_s());
        let impedance = met_midway(stiffness, damping, settings);
        let (keep, noise) = (libm::exp(-packet / memory), NOISE_N * NOISE_N);
        let share = if energy < PLENTY_J { (packet * rate).min(1.0) } else { 0.0 };
        Ok(Self {
            spring: Spring::build(settings),
            mean: Mean::build(settings),
            first: Model {
                mass: S::from_f64(object.mass_kg),
                damping: S::from_f64(object.damping_n_s_per_m),
                stiffness: S::ZERO,
                rest: S::ZERO,
            },
            masses: [S::from_f64(0.25 * object.mass_kg), S::from_f64(4.0 * object.mass_kg)],
            stiffness: S::from_f64(stiffness),
            damping: S::from_f64(damping),
            impedance: S::from_f64(impedance),
            budget: S::from_f64(4.0 * impedance / period),
            start: S::from_f64(energy),
            most: S::from_f64(energy.max(CAP_J)),
            share: S::from_f64(share),
            memory: [keep * noise, 1e-3 * noise, 1.0 / keep].map(S::from_f64),
            units: UNITS.map(S::from_f64),
            ticks_per_packet: timing.ticks_per_packet,
            packet_rate: S::from_f64(1.0 / packet),
            period: S::from_f64(period),
            half_period: S::from_f64(0.5 * period),
            twice_rate: S::from_f64(2.0 / period),
            half: S::from_f64(0.5),
        })
    }

    fn start(&self, local: Motion<S>) -> ModelMediatedState<S> {
        let model = Model { rest: local.position, ..self.first };
        let [m, b, ..] = UNITS.map(|unit| S::from_f64(1.0 / unit));
        ModelMediatedState {
            body: local,
            remote: local,
            model,
            estimate: Estimate::start([m * model.mass, b * model.damping, S::ZERO, S::ZERO]),
            origin: local.position,
            account: self.start,
            heard: None,
            sent: MeanState::default(),
            live: 0,
            carry: Carry::default(),
        }
    }

    fn restart(&self, state: &mut ModelMediatedState<S>, local: Motion<S>) {
        // What was spent stays spent, and the other peer may count from another beginning.
        *state = ModelMediatedState { account: state.account, live: state.live, ..self.start(local) };
    }

    // Not inlined: the other laws of a list would save the registers that this one needs.
    #[inline(never)]
    fn receive(&self, state: &mut ModelMediatedState<S>, packet: Packet<S>) {
        let (energy, ticks) = (packet.energy_j, packet.live_ticks);
        // The first packet brings no past.
        let (before, last) = state.heard.unwrap_or((energy, ticks));
        if energy > before {
            state.account = (state.account + S::of_counter(energy - before)).min(self.most);
        }
        let next = state.heard.is_some() && ticks.wrapping_sub(last) == self.ticks_per_packet;
        state.heard = Some((if energy > before { energy } else { before }, ticks));
        if next && self.share > S::ZERO {
            self.learn(state, &packet);
        }
        state.remote = packet.motion;
    }

    #[inline]
    fn couple(&self, state: &mut ModelMediatedState<S>, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        let (body, remote, model, kappa) = (state.body, state.remote, state.model, self.spring.impedance);
        // The correction, as far as the account pays for it whatever the body does.
        let wanted = self.stiffness * (remote.position - body.position) + self.damping * remote.velocity;
        let (worst, covered) = (wanted * wanted, state.account * self.budget);
        let gate = if worst <= covered { S::ONE } else { covered.ratio(worst) };
        let (pull, pull_impedance) = (gate * wanted, gate * self.impedance);
        // D·w + F_T = drive.
        let inertia = self.twice_rate * model.mass;
        let own = inertia + model.damping + self.half_period * model.stiffness + pull_impedance;
        let spring = self.spring.stiffness * (body.position - observed.local.position);
        let drive = inertia * body.velocity + model.stiffness * (model.rest - body.position) + pull - spring;
        let inverse_sum = S::ONE.ratio(own + kappa);
        let share = kappa * inverse_sum;
        let port = Port::new(spring + share * drive, own * share);
        let mean = solve.velocity(port);
        let velocity = (drive + kappa * mean) * inverse_sum;
        state.body = Motion {
            position: state.carry.add(body.position, self.period * velocity),
            velocity: velocity + velocity - body.velocity,
        };
        let force = port.at(mean);
        self.mean.push(&mut state.sent, force);
        state.live = state.live.wrapping_add(1);
        let corrected = (pull - pull_impedance * velocity) * velocity;
        let power_in = corrected.max(S::ZERO);
        state.account = (state.account - self.period * power_in).max(S::ZERO);
        Coupled {
            desired: Motion { position: body.position, velocity },
            force,
            power_in,
            power_out: (-corrected).max(S::ZERO) + model.damping * velocity * velocity,
        }
    }

    fn send(&self, state: &ModelMediatedState<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, wave: self.mean.level(&state.sent), live_ticks: state.live, ..Packet::default() }
    }
}
