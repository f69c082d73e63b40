//! Wave variables with a compensated reflection (after Ye & Liu 2009, "Improving haptic feedback fidelity in wave-variable-based teleoperation
//! orientated to telemedical applications", IEEE Transactions on Instrumentation and Measurement 58).
//!
//! A wave line adds a bias to the force that it reflects,
//!
//! > F_T = −F_r(t − T) + b·(ẋ_r(t − T) − ẋ_d),
//!
//! with F_r, ẋ_r those of the other end: what the impedance b makes of two ends that do not move alike yet. The compensator adds to the
//! wave that comes in a wave of its own, which takes the bias out below its bandwidth λ,
//!
//! > u_in′ = u_in − y,   ẏ = λ·(√(b/2)·(ẋ_r(t − T) − ẋ_d) − y)
//!
//! so that slow contact is felt as it is, and what is fast still ends in the line's impedance. This is the form used here; of the published
//! one only the bias and its low-passed compensation could be established. Each end sends ẋ_d beside its wave. As in the paper one end
//! compensates, the master's: here that of the peer on the left (`contact.side`), user 1. With both ends compensated nothing would hold the
//! two positions together.
//!
//! The published scheme bounds λ to stay passive. Here the compensated wave is paid for like any other: the energy that was heard and
//! not yet emitted, W, and u_in′ is scaled down where ½·T_c·u_in′² is more than W. **What holds**: passive on any network. Positions
//! drift as on every line that sends waves alone.

use crate::tank::{Tank, Tanks, WAVE_START};
use cohold_core::law::decimate::{Decimator, Mean, MeanState};
use cohold_core::law::terminal::{Terminal, TerminalState};
use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Promise};
use cohold_core::names::Side;
use cohold_core::num::{Carry, Motion, Scalar};
use cohold_core::object::Solve;
use cohold_core::settings::{Key, Refused, Settings};

const BANDWIDTH: Key = Key::number("coordination.compensator_hz", 2.0, [0.0, 50.0], "Hz")
    .means("Wave compensator: bandwidth λ/2π below which the reflected force is freed of its bias.");

/// One end of a wave line that compensates what it reflects.
#[derive(Clone, Copy, Debug)]
pub struct WaveCompensator<S: Scalar> {
    tanks: Tanks<S::Counter>,
    end: Terminal<S>,
    mean: Mean<S>,
    /// T_c, s.
    period: S,
    half: S,
    /// 1 − e^(−λ·T_c); 0 at the end that does not compensate.
    take: S,
    /// √(b/2).
    velocity_to_wave: S,
}

configured!([S: Scalar] WaveCompensator<S> { tanks, end, mean, period, half, take, velocity_to_wave });

/// State of one end: x_d, ẋ_d, the wave received, its compensation, the mean to be sent, and the energy account.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaveCompensatorState<S: Scalar> {
    /// x_d, ẋ_d.
    desired: Motion<S>,
    /// What x_d could not hold: rounding, no state.
    carry: Carry<S>,
    /// Wave, √W, and ẋ_r, m/s, of the newest packet.
    wave: S,
    remote: S,
    /// y, √W.
    compensation: S,
    /// The mean that is sent next.
    outgoing: MeanState<S>,
    /// W.
    tank: Tank<S::Counter>,
}

visited!([S: Scalar] WaveCompensatorState<S> { desired, wave, remote, compensation, outgoing });

impl<S: Scalar> Law<S> for WaveCompensator<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "wave-compensator",
        keys: &[WAVE_START, BANDWIDTH],
        gains: &["coordination.stiffness_n_per_m=10000", "object.integrator=midpoint"],
        source: "after Ye & Liu 2009",
        promises: &[Promise::Passive],
        scatters: false,
        ends_alike: false,
        ..LawInfo::WAVES
    }];
    type State = WaveCompensatorState<S>;
    const PORTS_ONLY: bool = true;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let tanks = Tanks::build(settings, &WAVE_START)?;
        let period = settings.timing.control_period_s;
        let angle = core::f64::consts::TAU * settings.own(&BANDWIDTH) * period;
        let take = if settings.contact.side == Side::Left { -libm::expm1(-angle) } else { 0.0 };
        Ok(Self {
            end: Terminal::build(settings),
            mean: Mean::build(settings),
            period: S::from_f64(period),
            half: S::from_f64(0.5),
            take: S::from_f64(take),
            velocity_to_wave: S::from_f64(libm::sqrt(0.5 * settings.coordination.wave_impedance_n_s_per_m)),
            tanks,
        })
    }

    fn start(&self, local: Motion<S>) -> WaveCompensatorState<S> {
        let desired = Motion::at(local.position);
        WaveCompensatorState { desired, tank: self.tanks.start(), ..WaveCompensatorState::default() }
    }

    fn restart(&self, state: &mut WaveCompensatorState<S>, local: Motion<S>) {
        *state = WaveCompensatorState { tank: self.tanks.restart(&state.tank), ..self.start(local) };
    }

    fn receive(&self, state: &mut WaveCompensatorState<S>, packet: Packet<S>) {
        (state.wave, state.remote) = (packet.wave, packet.motion.velocity);
        state.tank.receive(&packet);
    }

    fn couple(
        &self,
        state: &mut WaveCompensatorState<S>,
        observed: &Observation<S>,
        solve: impl Solve<S>,
    ) -> Coupled<S> {
        self.tanks.fill(&mut state.tank);
        let bias = self.velocity_to_wave * (state.remote - state.desired.velocity);
        state.compensation = state.compensation + self.take * (bias - state.compensation);
        let wave_in = self.tanks.emit(&mut state.tank, state.wave - state.compensation);

        let before = state.desired.position;
        let TerminalState { velocity, force, .. } =
            self.end.solve(self.end.spring_force(before - observed.local.position), wave_in, solve);
        let wave_out = self.end.wave_out(velocity, force);
        state.desired = Motion { position: state.carry.add(before, self.period * velocity), velocity };
        self.mean.push(&mut state.outgoing, wave_out);
        Coupled {
            desired: Motion { position: before, velocity },
            force,
            power_in: self.half * wave_in * wave_in,
            power_out: self.half * wave_out * wave_out,
        }
    }

    fn send(&self, state: &WaveCompensatorState<S>, _: Motion<S>) -> Packet<S> {
        Packet { motion: state.desired, wave: self.mean.level(&state.outgoing), ..Packet::default() }
    }
}
