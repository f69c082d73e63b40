//! Wave variables with integral transmission (Niemeyer & Slotine 2004, "Telemanipulation with time delays", International Journal of Robotics
//! Research 23; over networks whose delay changes: Niemeyer & Slotine 1998).
//!
//! Each packet carries the integral of u_out and its energy since the sender was armed, and the ticks that they are over,
//!
//! > U = ∫u_out dt = (b·x_d − p)/√(2b),   E = ½∫u_out² dt,   p = ∫F_T dt
//!
//! so that position and momentum feed through, whatever is lost. Let ε (√W·s) and W (J) be what was received of both
//! and is not yet emitted. The end emits
//!
//! > u_in = u + λ·ε₀
//!
//! with u the mean of what a packet brought, for M ticks and no longer, ε₀ the part of ε that is older, and λ =
//! 1/(4·T_n). On a constant delay ε₀ is 0 and this is the line that sends means. Where W does not leave ½·λ·ε² to pay
//! for what is still owed,
//!
//! > u_in = 2W/ε, or ε/T_c if that is less,
//!
//! which spends both at once: held, it takes ε²/2W, at the end of which neither is left.
//!
//! **What holds**: W is never below 0, so that the line emits no more than the other end absorbed, on any network. And W is above 0
//! while ε is not 0, so that everything that was sent comes out in the end: x_d = x_d0 + (∫u_in + ∫u_out)/√(2b), two ends that have
//! emitted all that was sent are as far apart as when they began, as long as neither was let go of (`safety.disengage_s`). What averaging saves is W that nothing needs; above [`CAP_J`] it
//! is thrown away, never what ε needs.

use crate::tank::{WAVE_START, needs_midpoint};
use cohold_core::law::bounds::Bounds;
use cohold_core::law::credit::CAP_J;
use cohold_core::law::terminal::{Terminal, TerminalState};
use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Promise};
use cohold_core::num::{Motion, Scalar, StateVector, Sum, visit_counter, visit_sum};
use cohold_core::object::Solve;
use cohold_core::settings::{Refused, Settings};

/// Packets over which what is owed is made good, 1/(λ·T_n).
const CORRECTION_PACKETS: f64 = 4.0;

/// One end of a wave line that sends integrals.
#[derive(Clone, Copy, Debug)]
pub struct WaveIntegral<S: Scalar> {
    end: Terminal<S>,
    half: S,
    start_j: S::Counter,
    /// What is kept whatever is owed, J.
    cap_j: S::Counter,
    /// T_c, s; ½·T_c, s; 1/T_c, 1/s.
    period_s: S::Counter,
    half_period_s: S::Counter,
    per_s: S::Counter,
    /// M.
    ticks_per_packet: u32,
    /// λ, 1/s.
    rate: S::Counter,
    /// λ/2, 1/s.
    half_rate: S::Counter,
    /// 1/√(2b).
    wave_to_position: S::Counter,
}

configured!([S: Scalar] WaveIntegral<S> {
    end, half, start_j, cap_j, period_s, half_period_s, per_s, ticks_per_packet, rate, half_rate, wave_to_position
});

/// State of one end: x_d, the wave that is held, what is still owed, its energy W, and the sums to be sent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaveIntegralState<S: Scalar> {
    /// x_d, m.
    desired: Sum<S::Counter>,
    /// Mean of what the newest packet brought, √W, and the ticks since it came.
    wave: S,
    held: u32,
    /// ε less what the newest wave still brings, √W·s.
    owed: S::Counter,
    /// W, J.
    energy_j: S::Counter,
    /// What the newest packet said.
    heard: Option<Heard<S::Counter>>,
    /// Ticks since this end began, or began anew.
    age: u32,
    /// U up to the packet before, and since, √W·s; ticks that it is over.
    sent: Sum<S::Counter>,
    fresh: S::Counter,
    ticks: u32,
    /// Ticks since a packet was due.
    phase: u32,
}

/// Ticks, integral and energy of the other end, √W·s and J.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Heard<C> {
    ticks: u32,
    integral: C,
    energy_j: C,
}

/// x_d, what is held and owed, and what the next packet says.
impl<S: Scalar> StateVector<S> for WaveIntegralState<S> {
    #[inline]
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        visit_sum::<S>(&mut self.desired, each);
        each(&mut self.wave);
        visit_counter::<S>(&mut self.owed, each);
        visit_counter::<S>(&mut self.fresh, each);
    }
}

impl<S: Scalar> WaveIntegral<S> {
    /// What the newest wave still brings, √W·s.
    #[inline]
    fn coming(&self, state: &WaveIntegralState<S>) -> S::Counter {
        let ticks = self.ticks_per_packet.saturating_sub(state.held).cast_signed();
        S::Counter::from_i32(ticks) * self.period_s * state.wave.to_counter()
    }

    /// u_in of this tick, √W.
    #[inline]
    fn emit(&self, state: &mut WaveIntegralState<S>) -> S {
        let held = if state.held < self.ticks_per_packet { state.wave.to_counter() } else { S::Counter::ZERO };
        let outstanding = self.coming(state) + state.owed;
        let wanted = held + self.rate * state.owed;
        let after = outstanding - self.period_s * wanted;
        let kept_j = self.half_rate * after * after;
        let wave = if self.price_j(wanted) + kept_j <= state.energy_j {
            wanted
        } else {
            let both = (state.energy_j + state.energy_j).ratio(outstanding.abs());
            (outstanding * self.per_s).limit(both)
        };
        // What comes out is what is booked, to the bit.
        let emitted = S::of_counter(wave);
        let wave = emitted.to_counter();
        state.held = state.held.saturating_add(1);
        let outstanding = outstanding - self.period_s * wave;
        state.owed = outstanding - self.coming(state);
        let most_j = (self.rate * outstanding * outstanding).max(self.cap_j);
        state.energy_j = (state.energy_j - self.price_j(wave)).min(most_j).max(S::Counter::ZERO);
        emitted
    }

    /// Energy of emitting this wave for one tick, ½·T_c·u², J.
    #[inline]
    fn price_j(&self, wave: S::Counter) -> S::Counter {
        self.half_period_s * wave * wave
    }
}

impl<S: Scalar> Law<S> for WaveIntegral<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "wave-integral",
        keys: &[WAVE_START],
        // An end to which nothing comes is a damper, and goes on where it was: it is let go of late.
        gains: &[
            "coordination.stiffness_n_per_m=10000",
            "object.integrator=midpoint",
            "safety.fade_s=5",
            "safety.disengage_s=8",
        ],
        source: "Niemeyer & Slotine 2004",
        promises: &[Promise::Passive, Promise::NoDrift],
        scatters: false,
        ..LawInfo::WAVES
    }];
    type State = WaveIntegralState<S>;
    const PORTS_ONLY: bool = true;

    fn bounds(settings: &Settings) -> Bounds {
        Bounds::of_waves(settings).counting(true)
    }

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        needs_midpoint(settings)?;
        let (timing, start_j) = (&settings.timing, settings.own(&WAVE_START));
        let (period_s, rate) = (timing.control_period_s, 1.0 / (CORRECTION_PACKETS * timing.packet_period_s()));
        let number = S::Counter::from_f64;
        Ok(Self {
            end: Terminal::build(settings),
            half: S::from_f64(0.5),
            start_j: number(start_j),
            cap_j: number(start_j.max(CAP_J)),
            period_s: number(period_s),
            half_period_s: number(0.5 * period_s),
            per_s: number(1.0 / period_s),
            ticks_per_packet: timing.ticks_per_packet,
            rate: number(rate),
            half_rate: number(0.5 * rate),
            wave_to_position: number(1.0 / libm::sqrt(2.0 * settings.coordination.wave_impedance_n_s_per_m)),
        })
    }

    fn start(&self, local: Motion<S>) -> WaveIntegralState<S> {
        let desired = Sum::from(local.position.to_counter());
        WaveIntegralState { desired, energy_j: self.start_j, ..WaveIntegralState::default() }
    }

    fn restart(&self, state: &mut WaveIntegralState<S>, local: Motion<S>) {
        // What was sent stays sent, and what may be emitted is no more than before.
        let WaveIntegralState { sent, fresh, ticks, phase, energy_j, .. } = *state;
        *state = WaveIntegralState { sent, fresh, ticks, phase, energy_j, ..self.start(local) };
    }

    // Not inlined: the other laws of a list would save the registers that this one needs.
    #[inline(never)]
    fn receive(&self, state: &mut WaveIntegralState<S>, packet: Packet<S>) {
        let Packet { wave_integral: integral, energy_j, live_ticks: ticks, .. } = packet;
        let heard = Heard { ticks, integral, energy_j };
        let Some(before) = state.heard.or_else(|| {
            // What the other end sent since this one began is not lost if the first packets are. An end that began earlier has a past
            // that is none of this one's.
            let nothing = Heard { ticks: 0, integral: S::Counter::ZERO, energy_j: S::Counter::ZERO };
            (ticks <= state.age).then_some(nothing)
        }) else {
            state.heard = Some(heard);
            return;
        };
        let new = ticks.wrapping_sub(before.ticks).cast_signed();
        if new > 0 {
            let brought = integral - before.integral;
            let outstanding = self.coming(state) + state.owed + brought;
            state.heard = Some(heard);
            state.wave = S::of_counter(brought.over(S::Counter::from_i32(new) * self.period_s));
            state.held = 0;
            state.owed = outstanding - self.coming(state);
            state.energy_j = state.energy_j + (energy_j - before.energy_j).max(S::Counter::ZERO);
        }
    }

    fn couple(&self, state: &mut WaveIntegralState<S>, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        let desired = state.desired.total();
        if state.phase == 0 {
            state.sent.add(state.fresh);
            state.fresh = S::Counter::ZERO;
        }
        state.phase = if state.phase + 1 >= self.ticks_per_packet { 0 } else { state.phase + 1 };
        (state.age, state.ticks) = (state.age.saturating_add(1), state.ticks.wrapping_add(1));
        let stretch = S::of_counter(desired - observed.local.position.to_counter());
        let wave_in = self.emit(state);
        let TerminalState { velocity, force, .. } = self.end.solve(self.end.spring_force(stretch), wave_in, solve);
        let wave_out = self.end.wave_out(velocity, force);
        let (taken, given) = (wave_in.to_counter(), wave_out.to_counter());
        state.desired.add(self.period_s * self.wave_to_position * (taken + given));
        state.fresh = state.fresh + self.period_s * given;
        Coupled {
            desired: Motion { position: S::of_counter(desired), velocity },
            force,
            power_in: self.half * wave_in * wave_in,
            power_out: self.half * wave_out * wave_out,
        }
    }

    fn send(&self, state: &WaveIntegralState<S>, _: Motion<S>) -> Packet<S> {
        let wave_integral = state.sent.total() + state.fresh;
        Packet { wave_integral, live_ticks: state.ticks, ..Packet::default() }
    }
}
