//! The self-timed line: wave coordination that is passive and without drift on any network, with a time of its own
//! (THEORY §8).
//!
//! Every tick of a line's end is **live** or **stands**. Live: it has a sample, emits it and sends one. Standing: it has
//! none; x_d stays where it is, nothing is emitted, sent or counted, and the copy hangs on the spring K_T there, as on a wall, or on what
//! carries on from there (`carry` says how). What crosses the network are two counters, the live ticks and the integral of
//! u_out over them: whatever is lost, late, repeated or overtaken, the next packet brings all of it. `incoming` says how
//! much of it a tick emits, `mass` what impedance the line has.
//!
//! x_d is not the sum of its velocities but of the waves, x_d = x_d0 + (∫u_in + ∫u_out)/√(2b), so that two ends that have
//! exchanged the same waves are as far apart as when they began. These sums are `f64` in every number type, whose last bit at a
//! metre is 10⁻¹⁶: all roundings of an hour come to 10⁻¹³ m. That of energies is compensated, for it has to pay to the last bit.
//!
//! Nothing is live before a packet has come; what the other end sent before that (at most d₀ samples, both at rest) is not in
//! the line.
//!
//! Somebody else may make a copy faster than its own limits allow. Its end then has larger waves than anybody believes
//! ([`super::bounds`]): it tells them no faster than that, and the rest later, as a line does that is a little longer.
//!
//! Which packets are worth sending, `events` says.
//!
//! A peer that begins anew (a restart, a silence after which it was let go of) goes on with its counters, which jump by more
//! than a line can hold: the other end sees that and begins anew with it. Needs `object.integrator = "midpoint"`.

mod carry;
mod even;
mod events;
mod incoming;
mod mass;
mod taut;

use carry::{Carry, DAMPING, ENERGY, FADE, LinePhase, MODULUS_M, RETURN, Slip};
use even::{EVEN, Even};
use events::{Events, LastSent, THRESHOLD, TOGETHER};
use incoming::{CREDIT, DelayLine, Incoming, restart_counter};
use mass::{End, MASS, Scattered, Share};
use taut::SLOWNESS;

pub use taut::TAUTNESS;

use super::bounds::{Bounds, WITHIN};
use super::event::LONGEST;
use super::terminal::Terminal;
use super::{Coupled, Law, LawInfo, Observation, Packet, Promise, needs_midpoint};
use crate::num::{Motion, Scalar, StateVector, Sum, visit_counter};
use crate::object::Solve;
use crate::settings::{Refused, Settings};

/// No packet tells a larger slip, m; ends tell half of it, and a step.
pub(super) const MOST_TOLD_M: f64 = MODULUS_M;

/// One end of a self-timed line.
#[derive(Clone, Copy, Debug)]
pub struct SelfTimed<S: Scalar> {
    end: End<S>,
    incoming: Incoming<S::Counter>,
    carry: Carry<S>,
    even: Even<S>,
    events: Option<Events<S::Counter>>,
    ticks_per_packet: u32,
    half: S,
    /// T_c, s.
    period_s: S::Counter,
    /// T_c/√(2b).
    wave_to_position_s: S::Counter,
    /// What a tick tells of ∫u_out at most, √W·s.
    most_told: S::Counter,
}

configured!([S: Scalar] SelfTimed<S> { end, incoming, carry, even, events, ticks_per_packet, half, period_s, wave_to_position_s, most_told });

/// State of one end of a self-timed line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SelfTimedState<S: Scalar> {
    /// x_d, m.
    desired: S::Counter,
    delay_line: DelayLine<S::Counter>,
    /// What the other end says of itself.
    remote_share: S,
    /// Samples that were outstanding when the newest packet had come, here and there, as they are told.
    own_samples: u16,
    far_samples: u16,
    share: Share<S>,
    slip: Slip<S>,
    /// ∫u_out up to the packet before, and since, √W·s.
    sent: S::Counter,
    fresh: S::Counter,
    /// And what nobody would believe, who is told it at once.
    untold: S::Counter,
    /// T_c·Σ½ρ·u_out², J.
    sent_j: Sum<S::Counter>,
    /// Ticks that it is over.
    live: u32,
    /// Ticks since a packet was due.
    phase: u32,
    last_sent: LastSent<S::Counter>,
}

/// x_d, what is outstanding, and what the next packet adds: all that a linear line remembers.
impl<S: Scalar> StateVector<S> for SelfTimedState<S> {
    #[inline]
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        visit_counter::<S>(&mut self.desired, each);
        visit_counter::<S>(&mut self.delay_line.integral, each);
        visit_counter::<S>(&mut self.fresh, each);
        self.slip.visit(each);
    }
}

impl<S: Scalar> Law<S> for SelfTimed<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "self-timed",
        keys: &[CREDIT, MASS, DAMPING, FADE, RETURN, ENERGY, TAUTNESS, SLOWNESS, EVEN, LONGEST, THRESHOLD, TOGETHER],
        // A line that stands loses nothing by a silence: it is let go of late.
        gains: &[
            "coordination.stiffness_n_per_m=10000",
            "coordination.tautness=0.9",
            "coordination.even_s=0.02",
            "object.integrator=midpoint",
            "safety.fade_s=5",
            "safety.disengage_s=8",
        ],
        source: "THEORY §8",
        promises: &[Promise::Passive, Promise::NoDrift],
        scatters: false,
        own_time: true,
        ..LawInfo::WAVES
    }];
    type State = SelfTimedState<S>;
    const PORTS_ONLY: bool = true;

    /// A packet has the slip in place of a place, and in place of a wave what an end says of itself. Sums are kept within the bound
    /// whatever moves the end: what is more it tells later.
    fn bounds(settings: &Settings) -> Bounds {
        let sums = Bounds::of_lighter_waves(settings, mass::least(settings)).counting(false);
        sums.with(MOST_TOLD_M, even::most_told(settings))
    }

    /// The line is longer than the network by what it keeps in store. Where it is long b falls, and tautness takes its share
    /// back while the tank has enough.
    fn compliance(settings: &Settings, delay_s: f64) -> [f64; 2] {
        let coordination = &settings.coordination;
        let line_s = delay_s + settings.own(&CREDIT) * settings.timing.control_period_s;
        let line = line_s / mass::impedance(settings, line_s);
        let most = 2.0 / coordination.stiffness_n_per_m + line;
        [(1.0 - settings.own(&TAUTNESS)).max(0.0) * most, most]
    }

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let coordination = &settings.coordination;
        needs_midpoint(settings, "\"midpoint\" or \"backward-euler\" where coordination.comm is \"self-timed\"")?;
        Ok(Self {
            end: End::build(settings, Carry::<S>::impedance(settings)),
            incoming: Incoming::build(settings),
            carry: Carry::build(settings),
            even: Even::build(settings),
            events: Events::build(settings),
            ticks_per_packet: settings.timing.ticks_per_packet,
            half: S::from_f64(0.5),
            period_s: S::Counter::from_f64(settings.timing.control_period_s),
            wave_to_position_s: S::Counter::from_f64(
                settings.timing.control_period_s / libm::sqrt(2.0 * coordination.wave_impedance_n_s_per_m),
            ),
            most_told: S::Counter::from_f64(WITHIN * <Self as Law<S>>::bounds(settings).integral_per_tick),
        })
    }

    fn start(&self, local: Motion<S>) -> Self::State {
        let desired = local.position.to_counter();
        let delay_line = self.incoming.start();
        let share = self.end.start(delay_line.length);
        SelfTimedState { desired, delay_line, slip: self.carry.start(), share, ..SelfTimedState::default() }
    }

    fn restart(&self, state: &mut Self::State, local: Motion<S>) {
        let SelfTimedState { sent, fresh, sent_j, live, .. } = *state;
        let slip = self.carry.restart(&state.slip);
        *state = SelfTimedState { sent, fresh, sent_j, live: restart_counter(live), slip, ..self.start(local) };
    }

    fn receive(&self, state: &mut Self::State, packet: Packet<S>) {
        if !self.incoming.receive(&mut state.delay_line, &packet, state.live) {
            return;
        }
        (state.remote_share, state.far_samples) = self.even.receive(packet.wave);
        self.end.receive(&mut state.share, state.remote_share);
        if state.remote_share < -self.half {
            self.carry.receive_idle(&mut state.slip);
        } else {
            state.desired = state.desired - self.carry.receive(&mut state.slip, packet.motion);
        }
    }

    #[inline]
    fn couple(&self, state: &mut Self::State, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        if state.phase == 0 {
            state.sent = state.sent + state.fresh;
            state.fresh = S::Counter::ZERO;
        }
        state.phase = if state.phase + 1 < self.ticks_per_packet { state.phase + 1 } else { 0 };
        // What a packet says does not depend on whether another one came just before it.
        state.own_samples = state.delay_line.came;
        state.desired = state.desired + self.carry.turn(&mut state.slip);
        let anchor = self.carry.anchor(&state.slip, state.desired);
        let pull = self.end.spring_force(S::of_counter(anchor - observed.local.position.to_counter()));
        let position = S::of_counter(anchor);
        let own = self.end.impedance_share(&mut state.share, state.delay_line.length);
        let behind_s = self.even.behind_s(state.own_samples, state.far_samples);
        let line = [S::from_i32(state.delay_line.length), own, behind_s];
        let before = state.delay_line.last;
        let (wave_in, share) = self.incoming.next_wave(&mut state.delay_line, own);
        if share == S::ZERO {
            self.incoming.hold(&mut state.delay_line, observed.age_ticks, state.remote_share > S::ONE);
            state.last_sent.held = state.last_sent.held.saturating_add(1);
            let phase = self.carry.phase_of(&state.slip, state.delay_line.is_cut_off);
            let spring = self.carry.couple_anchor(&mut state.slip, phase, pull, line);
            let terminal = Terminal::solve_grounded(spring.pull, spring.impedance, solve);
            let velocity = self.carry.update_slip(&mut state.slip, phase, &spring, &terminal);
            return Coupled { desired: Motion::new(position, velocity), force: terminal.force, ..Coupled::default() };
        }
        if state.slip.held {
            self.carry.resume(&mut state.slip, |force| self.end.unloaded_velocity([wave_in, share], force));
        } else if state.delay_line.was_held_recently() {
            self.carry.step_input(&mut state.slip, self.end.velocity_step(wave_in - S::of_counter(before)));
        }
        let spring = self.carry.couple_anchor(&mut state.slip, LinePhase::Live, pull, line);
        let Scattered { terminal, wave_out } = self.end.scatter(spring.pull, [wave_in, share], solve);
        let (taken, given) = (wave_in.to_counter(), wave_out.to_counter());
        state.desired = state.desired + self.wave_to_position_s * (taken + given);
        let untold = state.untold + self.period_s * given;
        let told = untold.limit(self.most_told);
        (state.fresh, state.untold) = (state.fresh + told, untold - told);
        state.sent_j.add(share.to_counter() * self.incoming.price_j(given));
        state.live = state.live.wrapping_add(1);
        state.last_sent.newest = given;
        let velocity = self.carry.update_slip(&mut state.slip, LinePhase::Live, &spring, &terminal);
        Coupled {
            desired: Motion::new(position, velocity),
            force: terminal.force,
            power_in: self.half * share * wave_in * wave_in,
            power_out: self.half * share * wave_out * wave_out,
        }
    }

    fn send(&self, state: &Self::State, _: Motion<S>) -> Packet<S> {
        let share = self.end.packet_field(&state.share, state.delay_line.is_cut_off);
        Packet {
            motion: self.carry.packet_field(&state.slip),
            wave: self.even.packet_field(share, state.own_samples),
            wave_integral: state.sent + state.fresh,
            energy_j: state.sent_j.total(),
            live_ticks: state.live,
        }
    }

    fn speaks(&self, state: &Self::State, packet: &Packet<S>) -> bool {
        self.events
            .as_ref()
            .is_none_or(|events| events.exceeds_threshold(&state.last_sent, state.delay_line.last, packet.live_ticks))
    }

    fn spoke(&self, state: &mut Self::State, packet: &Packet<S>) {
        if let Some(events) = &self.events {
            events.note_sent(&mut state.last_sent, packet.wave_integral, packet.live_ticks);
        }
    }

    /// Its slip is of no meaning any more.
    fn idle(&self, packet: Packet<S>, _: Motion<S>) -> Packet<S> {
        Packet { motion: Motion::REST, wave: -S::ONE, ..packet }
    }

    /// Counters that came before stay what they are.
    fn fades(&self) -> bool {
        false
    }
}
