//! Wave-domain coordination: each peer sends u_out and decodes the desired motion of its copy from u_in.
//!
//! u_in = (b·ẋ_d + F_T)/√(2b), u_out = (b·ẋ_d − F_T)/√(2b), so that F_T·ẋ_d = ½·(u_in² − u_out²): whatever the (constant)
//! delay, the line stores energy and makes none (cooperation paper §2; symmetric form, THEORY §2).
//!
//! [`Line`] is the one implementation; the filter before decimation is its parameter: [`Wave`] sends the newest sample,
//! [`PassiveWave`] sends it through the paper's one-pole filter, [`PassiveMean`] sends the mean. The energy of the
//! incoming wave may be limited by a ledger ([`super::credit`]): then the line is passive on any network.
//!
//! ẋ_d needs F_T and F_T needs ẋ_d. [`Decode::Delayed`] opens that loop as the paper does, with the force of the tick
//! before; it generates energy near its gain limit. [`Decode::Implicit`] solves it in closed form (backward Euler on
//! x_d): with a semi-implicit or exact object no limit on K_T is found up to 1e6 N/m at the paper's impedance; where
//! there is one, `host-sim/analysis/tests/suite/bounds.rs` says. With `object.integrator = "midpoint"` spring and line
//! in a row are one port and the loop closes in the object's own solve (THEORY §7), which makes no energy at any K_T.
//! Square roots are taken once, in `build()`.

use super::credit::{Account, Credit};
use super::decimate::{Decimator, Mean, Newest, OnePole};
use super::terminal::{Terminal, TerminalState};
use super::{Coupled, Law, LawInfo, Observation, Packet};
use crate::num::{Carry, Configured, Motion, Scalar, StateVector, Sum};
use crate::object::Solve;
use crate::settings::{Allowed, Refused, Settings};

pub use crate::names::Decode;

/// Traditional wave communications: the newest sample is sent.
pub type Wave<S> = Line<S, Newest>;

/// Passive multirate wave communications: the filtered wave is sent.
pub type PassiveWave<S> = Line<S, OnePole<S>>;

/// Exactly passive multirate wave communications: the mean of a packet's waves is sent.
pub type PassiveMean<S> = Line<S, Mean<S>>;

/// One end of a wave line.
#[derive(Clone, Copy, Debug)]
pub struct Line<S: Scalar, D> {
    end: Terminal<S>,
    decimator: D,
    decode: Decode,
    credit: Option<Credit<S>>,
    period: S,
    /// √(2b)/b, to decode with the force of the tick before.
    root_over_impedance: S,
    /// 1/b.
    inverse_impedance: S,
    /// 1/(b + B_T + K_T·T_c), to decode implicitly.
    inverse_loop: S,
    half: S,
}

configured!([S: Scalar, D: Configured] Line<S, D> {
    end, decimator, decode, credit, period, root_over_impedance, inverse_impedance, inverse_loop, half
});

/// State of one end of a wave line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineState<S: Scalar, D> {
    /// x_d, ẋ_d.
    desired: Motion<S>,
    /// F_T of the last tick, N.
    force: S,
    /// u_in as last received, √W, held between packets.
    wave_in: S,
    /// The filter before the rate drop.
    outgoing: D,
    /// What u_in is paid from.
    account: Account<S>,
    /// ∫u_out dt, √W·s.
    integral: Sum<S>,
    /// What x_d could not hold: rounding, no state.
    carry: Carry<S>,
}

visited!([S: Scalar, D: StateVector<S>] LineState<S, D> { desired, force, wave_in, outgoing });

impl<S: Scalar, D: Decimator<S>> Line<S, D> {
    /// u_in of this tick, √W.
    #[inline]
    fn paid(&self, state: &mut LineState<S, D::State>) -> S {
        match &self.credit {
            Some(credit) => credit.spend(&mut state.account, state.wave_in),
            None => state.wave_in,
        }
    }

    /// u_out of this tick goes into what is sent.
    #[inline]
    fn emit(&self, state: &mut LineState<S, D::State>, desired: Motion<S>, wave_in: S) -> Coupled<S> {
        let wave_out = self.end.wave_out(desired.velocity, state.force);
        self.decimator.push(&mut state.outgoing, wave_out);
        if self.credit.is_some() {
            state.integral.add(self.period * wave_out);
        }
        Coupled {
            desired,
            force: state.force,
            power_in: self.half * wave_in * wave_in,
            power_out: self.half * wave_out * wave_out,
        }
    }

    #[inline]
    fn decode(&self, state: &mut LineState<S, D::State>, wave_in: S, local: Motion<S>) -> Motion<S> {
        let before = state.desired;
        match self.decode {
            Decode::Delayed => Motion {
                position: state.carry.add(before.position, self.period * before.velocity),
                velocity: self.root_over_impedance * wave_in - self.inverse_impedance * state.force,
            },
            Decode::Implicit => {
                let stretch = before.position - local.position;
                let spring = &self.end.spring;
                let velocity = (self.end.root * wave_in - spring.stiffness * stretch + spring.damping * local.velocity)
                    * self.inverse_loop;
                Motion::new(state.carry.add(before.position, self.period * velocity), velocity)
            }
        }
    }
}

impl<S: Scalar, D: Decimator<S>> Law<S> for Line<S, D> {
    const LAWS: &'static [LawInfo] = &[D::INFO];
    type State = LineState<S, D::State>;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let (period, coordination) = (settings.timing.control_period_s, &settings.coordination);
        if coordination.drift_correction && !(coordination.ledger && D::KEEPS_INTEGRAL) {
            // Only the mean carries its integral exactly, and only the ledger pays for what is added.
            let allowed =
                Allowed::Only("false, unless coordination.comm is \"passive-mean\" and coordination.ledger is true");
            return Err(settings.refuses("coordination.drift_correction", allowed));
        }
        let impedance = coordination.wave_impedance_n_s_per_m;
        let loop_gain = impedance + coordination.damping_n_s_per_m + coordination.stiffness_n_per_m * period;
        let root = libm::sqrt(2.0 * impedance);
        Ok(Self {
            end: Terminal::build(settings),
            decimator: D::build(settings),
            decode: coordination.decode,
            credit: Credit::build(settings),
            period: S::from_f64(period),
            root_over_impedance: S::from_f64(root / impedance),
            inverse_impedance: S::from_f64(1.0 / impedance),
            inverse_loop: S::from_f64(1.0 / loop_gain),
            half: S::from_f64(0.5),
        })
    }

    fn start(&self, local: Motion<S>) -> Self::State {
        LineState { desired: Motion::at(local.position), ..LineState::default() }
    }

    fn restart(&self, state: &mut Self::State, local: Motion<S>) {
        // What was sent stays sent: the other peer counts on it.
        *state = LineState { integral: state.integral, ..self.start(local) };
    }

    fn receive(&self, state: &mut LineState<S, D::State>, packet: Packet<S>) {
        state.wave_in = packet.wave;
        if let Some(credit) = &self.credit {
            credit.receive(&mut state.account, &packet);
        }
    }

    fn only_holds(&self) -> bool {
        self.credit.is_none()
    }

    #[inline]
    fn couple(
        &self,
        state: &mut LineState<S, D::State>,
        observed: &Observation<S>,
        solve: impl Solve<S>,
    ) -> Coupled<S> {
        let wave_in = self.paid(state);
        if solve.is_staged() {
            let desired = self.decode(state, wave_in, observed.local);
            state.desired = desired;
            state.force = self.end.spring.force(desired, observed.local, solve);
            return self.emit(state, desired, wave_in);
        }
        let before = state.desired.position;
        let TerminalState { velocity, force, .. } =
            self.end.solve(self.end.spring_force(before - observed.local.position), wave_in, solve);
        state.desired = Motion::new(state.carry.add(before, self.period * velocity), velocity);
        state.force = force;
        self.emit(state, Motion::new(before, velocity), wave_in)
    }

    fn send(&self, state: &LineState<S, D::State>, _: Motion<S>) -> Packet<S> {
        Packet {
            wave: self.decimator.level(&state.outgoing),
            wave_integral: state.integral.total().to_counter(),
            ..Packet::default()
        }
    }
}
