//! Passive set-position modulation (Lee & Huang 2010, "Passive-set-position-modulation framework for interactive robotic systems",
//! IEEE Transactions on Robotics 26).
//!
//! The copy hangs on a spring to a set position and on a damper to the ground, F_T = K_T·(p̂ − x_o) − B_T·ẋ_o. A set position that
//! jumps changes the spring's energy by
//!
//! > ΔP = ½K_T·(p̂ₖ − x_o)² − ½K_T·(p̂ₖ₋₁ − x_o)²,
//!
//! which the tank pays: p̂ₖ is the position nearest to the one wanted, pₖ, for which E + ΔE_y + D − ΔP ≥ 0. D is what the damper took
//! since, T_c·B_T·v² a tick, which goes into the tank (damping injection, harvested); ΔE_y is what the other peer sent. The harvest of a
//! tick that begins with no less in the tank than at the start goes to the other peer (ΔE_x, energy shuffling); what is received is never
//! sent on, so that nothing circulates.
//!
//! Here pₖ is the position of the other copy in the newest packet, and k counts ticks, not packets: what cannot be paid for at once is
//! gone on with as soon as it can. With the midpoint rule D and the work of the spring are exact, so that
//!
//! > E₁ + ½K_T·s₁² + E₂ + ½K_T·s₂² + ΣT_c·(F_T1·v₁ + F_T2·v₂) + what is on the way
//!
//! never grows: both copies together get no more than both tanks held at first and what was done on them. **No drift**: p̂ is a position;
//! copies that nobody pushes come back to each other as long as there is anything in a tank. Only what the damper of the object, a
//! contact or a hand takes is out of reach for good.
//!
//! What it costs is a drag of B_T that is felt in free motion.

use crate::tank::{START, Tank, Tanks};
use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Promise, Spring};
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::{Port, Solve};
use cohold_core::settings::{Refused, Settings};

/// One end: a spring to a set position, which moves only as far as the energy tank pays for.
#[derive(Clone, Copy, Debug)]
pub struct SetPosition<S: Scalar> {
    tanks: Tanks<S::Counter>,
    stiffness: S::Counter,
    /// T_c·B_T, N·s²/m.
    harvest: S::Counter,
    /// K_T·T_c/2 + B_T, N·s/m.
    impedance: S,
}

configured!([S: Scalar] SetPosition<S> { tanks, stiffness, harvest, impedance });

/// State of one end: the position wanted p, the set position p̂, and the tank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SetPositionState<S: Scalar> {
    /// p, m.
    wanted: S,
    /// p̂, m.
    set: S::Counter,
    tank: Tank<S::Counter>,
}

visited!([S: Scalar] SetPositionState<S> { wanted });

impl<S: Scalar> Law<S> for SetPosition<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "set-position",
        keys: &[START],
        gains: &[
            "coordination.stiffness_n_per_m=1000",
            "coordination.damping_n_s_per_m=10",
            "object.integrator=midpoint",
        ],
        source: "Lee & Huang 2010",
        promises: &[Promise::Passive, Promise::NoDrift],
        ..LawInfo::MOTION
    }];
    type State = SetPositionState<S>;
    const PORTS_ONLY: bool = true;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let (timing, coordination) = (&settings.timing, &settings.coordination);
        Ok(Self {
            tanks: Tanks::build(settings, &START)?,
            stiffness: S::Counter::from_f64(coordination.stiffness_n_per_m),
            harvest: S::Counter::from_f64(timing.control_period_s * coordination.damping_n_s_per_m),
            impedance: Spring::build(settings).impedance,
        })
    }

    fn start(&self, local: Motion<S>) -> SetPositionState<S> {
        SetPositionState { wanted: local.position, set: local.position.to_counter(), tank: self.tanks.start() }
    }

    fn restart(&self, state: &mut SetPositionState<S>, local: Motion<S>) {
        *state = SetPositionState { tank: self.tanks.restart(&state.tank), ..self.start(local) };
    }

    fn receive(&self, state: &mut SetPositionState<S>, packet: Packet<S>) {
        state.wanted = packet.motion.position;
        state.tank.receive(&packet);
    }

    fn couple(&self, state: &mut SetPositionState<S>, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        let power_in = self.tanks.fill(&mut state.tank);
        let local = observed.local.position.to_counter();
        let (before, wanted) = (state.set - local, state.wanted.to_counter() - local);
        let (stretch, _) = self.tanks.stretch(&mut state.tank, self.stiffness, before, wanted);
        state.set = local + stretch;
        let port = Port::new(S::of_counter(self.stiffness * stretch), self.impedance);
        let mean = solve.velocity(port);
        let velocity = mean.to_counter();
        let mut power_out = S::Counter::ZERO;
        let harvest = self.harvest * velocity * velocity;
        if self.tanks.is_full(&state.tank) {
            power_out = harvest.over(self.tanks.period_s);
        } else {
            self.tanks.settle(&mut state.tank, harvest);
        }
        Coupled {
            desired: Motion::at(S::of_counter(state.set)),
            force: port.at(mean),
            power_in: S::of_counter(power_in),
            power_out: S::of_counter(power_out),
        }
    }

    fn send(&self, _: &SetPositionState<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, ..Packet::default() }
    }
}
