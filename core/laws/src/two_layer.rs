//! The two-layer approach: a transparency layer says which force it wants, a passivity layer gives as much of it as its energy tank pays for
//! (Franken, Stramigioli, Misra, Secchi & Macchelli 2011, "Bilateral telemanipulation with time delays: a two-layer approach combining
//! passivity and transparency", IEEE Transactions on Robotics 27).
//!
//! **Transparency layer**: the power-domain spring and damper, K_T·(x_d − x_o) + B_T·(ẋ_d − ẋ_o) to the newest packet; nothing of it
//! holds energy: a spring that is virtual is in the tank, too.
//!
//! **Passivity layer**, at both ends, H the energy in the tank:
//! - **Measured exchange**: H loses T_c·F_T·v, the work on the copy, exact with the midpoint rule.
//! - **Energy transfer**: each tick the share β of H goes to the other end, βH, and what it sent comes in; so both tanks level out. With a
//!   delay of d ticks each way and nobody who moves, H₁ = H₂ = (H₁ + H₂ + on the way)/(2 + 2βd).
//! - **Tank level controller**: below H_d a damper of α·(H_d − H) takes energy from whoever moves the copy.
//! - **Saturation**: with z the damping that the copy meets in a tick, κ and the damper's, T_c·(f − z·v)·v ≤ T_c·f²/4z at any v. So
//!   |f| ≤ √(4zH/T_c) leaves the tank at or above 0 whatever the copy does; an empty tank gives no force but damping.
//!
//! In the paper the level controller is at the master alone, which a human moves; here both ends are. The energy on the line is a sum, so
//! that what a lost packet carried comes with the next. **What holds**: both copies together never get more than both tanks held at first. It
//! does not promise that drift is made good: an empty tank pushes nothing.

use crate::tank::{START, Tank, Tanks};
use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Promise, Spring};
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::{Port, Solve};
use cohold_core::settings::{Key, Refused, Settings};

const LEVEL: Key = Key::number("coordination.tank_level_j", 0.01, [0.0, 1.0], "J")
    .means("Two-layer: level H_d below which a damper fills the tank.");
const FILL: Key = Key::number("coordination.tank_damping_n_s_per_m_j", 200.0, [0.0, 1e5], "N·s/(m·J)")
    .means("Two-layer: damping α for each joule that is missing from the tank's level.");
const SHARE: Key = Key::number("coordination.tank_share", 0.01, [0.0, 0.5], "")
    .means("Two-layer: share β of the tank that goes to the other peer each tick.");

/// One end: a spring and a damper whose force is limited to what the energy tank pays for.
#[derive(Clone, Copy, Debug)]
pub struct TwoLayer<S: Scalar> {
    tanks: Tanks<S::Counter>,
    spring: Spring<S>,
    level_j: S::Counter,
    /// α, N·s/(m·J).
    fill: S::Counter,
    /// β.
    share: S::Counter,
    /// 4/T_c, 1/s.
    rate: S::Counter,
}

configured!([S: Scalar] TwoLayer<S> { tanks, spring, level_j, fill, share, rate });

/// State of one end: the motion received, and the energy tank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TwoLayerState<S: Scalar> {
    /// x_d and ẋ_d as received.
    desired: Motion<S>,
    /// H.
    tank: Tank<S::Counter>,
}

visited!([S: Scalar] TwoLayerState<S> { desired });

impl<S: Scalar> Law<S> for TwoLayer<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "two-layer",
        keys: &[START, LEVEL, FILL, SHARE],
        gains: &["coordination.stiffness_n_per_m=1000", "object.integrator=midpoint"],
        source: "Franken et al. 2011",
        promises: &[Promise::Passive],
        ..LawInfo::MOTION
    }];
    type State = TwoLayerState<S>;
    const PORTS_ONLY: bool = true;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self {
            tanks: Tanks::build(settings, &START)?,
            spring: Spring::build(settings),
            level_j: S::Counter::from_f64(settings.own(&LEVEL)),
            fill: S::Counter::from_f64(settings.own(&FILL)),
            share: S::Counter::from_f64(settings.own(&SHARE)),
            rate: S::Counter::from_f64(4.0 / settings.timing.control_period_s),
        })
    }

    fn start(&self, local: Motion<S>) -> TwoLayerState<S> {
        TwoLayerState { desired: local, tank: self.tanks.start() }
    }

    fn restart(&self, state: &mut TwoLayerState<S>, local: Motion<S>) {
        *state = TwoLayerState { tank: self.tanks.restart(&state.tank), ..self.start(local) };
    }

    fn receive(&self, state: &mut TwoLayerState<S>, packet: Packet<S>) {
        state.desired = packet.motion;
        state.tank.receive(&packet);
    }

    fn couple(&self, state: &mut TwoLayerState<S>, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        let period = self.tanks.period_s;
        let power_in = self.tanks.fill(&mut state.tank);
        let quantum = self.share * state.tank.level_j;
        state.tank.level_j = state.tank.level_j - quantum;

        let wanted = self.spring.port(state.desired, observed.local);
        let missing = self.level_j - state.tank.level_j;
        let damping = if missing > S::Counter::ZERO { self.fill * missing } else { S::Counter::ZERO };
        let impedance = wanted.impedance + S::of_counter(damping);
        let most = (self.rate * impedance.to_counter() * state.tank.level_j).sqrt();
        let port = Port::new(wanted.force.limit(S::of_counter(most)), impedance);
        let mean = solve.velocity(port);
        let force = port.at(mean);
        self.tanks.settle(&mut state.tank, -(period * force.to_counter() * mean.to_counter()));
        Coupled {
            desired: state.desired,
            force,
            power_in: S::of_counter(power_in),
            power_out: S::of_counter(quantum.over(period)),
        }
    }

    fn send(&self, _: &TwoLayerState<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, ..Packet::default() }
    }
}
