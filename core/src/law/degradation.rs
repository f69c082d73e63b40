//! Degradation by silence: without packets the coordination holds, fades, disengages; with packets it steps back up.
//!
//! Counted in packet periods in which no packet came: up to `safety.fade_s` the last packet stands; then the
//! coordination fades, one step a period, until the peer disengages after `safety.disengage_s`. Both
//! are times, rounded to packet periods, and there is at least one step between them. Where a step of a large force would be more than
//! [`STEP_N`] a tick, the coordination keeps as much as that. What is left of the force at the end
//! falls by [`STEP_N`], too, and when nothing is left the peer renders alone. The first packet after that starts
//! the law anew where the object is, from no force, and every packet period with a packet takes one step back, or as
//! many as were silent on purpose before it ([`super::event`]). What fading does to packets is the same for all laws ([`super::Packet::faded`])
//! but those whose packets stand ([`super::Law::fades`]).
//!
//! The degradation depends on silence alone. A link that knows that the other peer is gone, or is another one than
//! before (its session ended), takes the last step at once ([`crate::peer::Peer::part`]): what comes next is counted
//! from zero by a peer that started anew, and must not be measured by the old one's counters.

use super::{Spring, event};
use crate::num::{Motion, Scalar};
use crate::object::Port;
use crate::settings::{Allowed, Refused, Settings};

/// By how much a coordination force may fall in a tick, N, because of silence, or because the other peer is gone. The mass of the copy swings a little
/// at each step, so that the force on the hand falls by up to 0.02 N.
pub const STEP_N: f64 = 0.018;

/// Lengths of hold, fade and return, in packet periods.
#[derive(Clone, Copy, Debug)]
pub struct Degradation<S> {
    /// Periods of silence that change nothing.
    hold: u32,
    /// Steps from engaged to disengaged.
    steps: u32,
    /// One step.
    step: S,
    /// By how much a force may fall in a packet period, N.
    fall_n: S,
    /// From packet to packet at most, in packet periods, 1 where a packet is sent in each: so many steps back a packet may take.
    pub(crate) longest: u32,
}

configured!([S: Scalar] Degradation<S> { hold, steps, step, fall_n, longest });

/// How far a peer's coordination is degraded by silence.
#[derive(Clone, Copy, Debug)]
pub struct Engagement<S> {
    /// Steps above disengaged: 0 is disengaged, the most is fully engaged.
    level: u32,
    /// How far the coordination acts at least, whatever the level: no force falls faster.
    kept: S,
    /// Packet periods without a packet, since the last one.
    silent: u32,
    /// A packet has come since the peer was armed: before that there is no silence.
    heard: bool,
    /// A packet has come in this packet period.
    came: bool,
}

impl<S: Scalar> Degradation<S> {
    /// The degradation steps of the scene's settings.
    ///
    /// # Errors
    /// `safety.disengage_s` that is not more than `safety.fade_s`, or a silence on purpose (`event.longest_s`) that
    /// the times of `safety` do not allow.
    pub fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let (timing, safety) = (&settings.timing, &settings.safety);
        if safety.disengage_s <= safety.fade_s {
            return Err(settings.refuses("safety.disengage_s", Allowed::Only("more than safety.fade_s")));
        }
        let hold = timing.packet_periods(safety.fade_s);
        let steps = timing.packet_periods(safety.disengage_s).saturating_sub(hold).max(1);
        let longest = event::longest_periods(settings)?;
        let fall_n = S::from_f64(STEP_N * f64::from(timing.ticks_per_packet));
        Ok(Self { hold, steps, step: S::from_f64(1.0 / f64::from(steps)), fall_n, longest })
    }

    /// The state at arming: fully engaged, and no packet has come yet.
    pub fn engaged(&self) -> Engagement<S> {
        Engagement { level: self.steps, kept: S::ZERO, silent: 0, heard: false, came: false }
    }

    /// Takes note of a packet: the first of a packet period takes one step back, or as many as its sender may have
    /// kept silent for. True if the law has to start anew.
    pub fn hear(&self, at: &mut Engagement<S>) -> bool {
        let anew = at.level == 0;
        if !self.is_whole(at) && !at.came {
            let step = at.silent.saturating_add(1).min(self.longest);
            at.level = at.level.saturating_add(step).min(self.steps);
        }
        at.note();
        anew
    }

    /// Ends a packet period; if no packet came in it, that is silence. Whether it disengages. None of these `forces` of the law (N) is to fall faster
    /// than by [`STEP_N`] a tick.
    pub fn pass(&self, at: &mut Engagement<S>, forces: impl IntoIterator<Item = S>) -> bool {
        let came = core::mem::take(&mut at.came);
        at.silent = at.silent.saturating_add(u32::from(at.heard && !came));
        if at.silent <= self.hold || at.level == 0 {
            return false;
        }
        let most = forces.into_iter().fold(self.fall_n, |most, force| most.max(force.abs()));
        at.kept = self.share(at) * (S::ONE - self.fall_n.ratio(most));
        at.level -= 1;
        at.level == 0
    }

    /// Whether the coordination acts in full: [`Degradation::share`] is 1.
    #[inline]
    pub fn is_whole(&self, at: &Engagement<S>) -> bool {
        at.level >= self.steps
    }

    /// How far the coordination may act, from 0, disengaged, to exactly 1, engaged.
    pub fn share(&self, at: &Engagement<S>) -> S {
        let share = S::from_f64(f64::from(at.level)) * self.step;
        if self.is_whole(at) { S::ONE } else { at.kept.max(share) }
    }
}

impl<S: Scalar> Engagement<S> {
    /// Disengages at once. Silence goes on being counted.
    pub fn part(&mut self) {
        (self.level, self.kept, self.came) = (0, S::ZERO, false);
    }

    /// Takes note of a packet that ends a silence, and changes nothing else.
    pub fn note(&mut self) {
        (self.silent, self.heard, self.came) = (0, true, true);
    }

    /// Whether a packet has come since the peer was armed.
    pub fn has_heard(&self) -> bool {
        self.heard
    }

    /// Whether the coordination acts at all.
    #[inline]
    pub fn is_engaged(&self) -> bool {
        self.level > 0
    }

    /// Whether silence has begun to fade what is held.
    pub fn is_fading(&self) -> bool {
        self.silent > 0 && self.level > 0
    }

    /// Packet periods without a packet since the last one came.
    pub fn silent(&self) -> u32 {
        self.silent
    }
}

/// What is left of the coordination force when a peer or a hub has let go, whatever the law is: a spring of K_T and B_T that pulls the copy to
/// where the law would have held it, and can pull with less and less. It stores what such a force stores at most, and generates nothing. If the
/// scene has no K_T, it is a force that falls.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Remnant<S> {
    /// The most that it can pull with, to either side, and the sign of what it pulled with first, N; with 0 there is none.
    most: S,
    /// Where it is at rest, m.
    rest_m: S,
}

impl<S: Scalar> Remnant<S> {
    /// Of this force (N) in the tick before.
    pub fn of(force: S, object: Motion<S>, spring: &Spring<S>) -> Self {
        let mut remnant = Self { most: force, rest_m: object.position + force.ratio(spring.stiffness) };
        remnant.fall();
        remnant
    }

    /// Whether nothing is left.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.most == S::ZERO
    }

    /// As a port of the tick that begins with the copy there, limited by the force at the velocity that the copy has then.
    #[inline(never)]
    pub fn port(&self, object: Motion<S>, spring: &Spring<S>) -> Port<S> {
        if self.is_none() || spring.stiffness == S::ZERO {
            return Port::of_force(self.most);
        }
        let free = spring.port(Motion::at(self.rest_m), object);
        let asked = free.at(object.velocity);
        let given = asked.limit(self.most.abs());
        if given == asked { free } else { Port::of_force(given) }
    }

    /// The next tick has less of it.
    pub fn fall(&mut self) {
        let step = S::from_f64(STEP_N);
        self.most = self.most - self.most.min(step).max(-step);
    }
}
