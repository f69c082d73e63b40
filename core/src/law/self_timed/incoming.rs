//! The receiving half of a self-timed line: what has been heard and is not yet emitted, and how much of it a tick emits.
//!
//! A tick emits the mean of what is outstanding, u_in = R/(k·T_c), where R is the integral and k the number of samples that
//! were heard and not yet emitted: every sample that was sent comes out with weight one in the end (nothing drifts), and a mean
//! never has more energy than what it is the mean of (Jensen; passive), at the impedance of the end that sent it: at a higher one it is paid
//! for from the sender's counter of energy, or comes out at the one that this pays for ([`super::mass`]). No sample, or samples of which the
//! sender says that they have less energy than any impedance may have: the line stands, and nothing is counted.
//!
//! Each end begins with d₀ samples of zero to its credit, whichever hears the other one first. Their number never changes by itself: in line time the line is one
//! of constant delay, whatever the network does.
//!
//! **Following the network** (`coordination.credit_ticks = 0`, beginning with [`FIRST_S`]). A zero sample more costs nothing. An
//! end that stands for more than a tenth of the time although packets come, there and at the other end ([`DelayLine::impatience`]; what is
//! lost in bursts is stood through: a line that bridged it would be slow where nothing is lost) adds half as many samples as it stood, for the other end stands as long and adds its half, and [`SPARE`]
//! more. Where a line begins, whose hands rest, it adds them at once ([`FIRST_AT_ONCE`]): a delay is learned in one round trip. After a quiet time it
//! adds no more than [`LEAST_AT_ONCE`], then twice as many each time. A sample less costs energy: where for a [`WINDOW_S`] nothing stood and more than [`KEPT`] was always left, half
//! of what is left over goes, each over [`SLICES`] ticks, so that hands feel no step, if averaging has saved what that costs and the line is
//! nearly at rest.

use super::events::Events;
use crate::law::Packet;
use crate::law::event::LONGEST;
use crate::num::Scalar;
use crate::settings::{Key, Settings};

pub(super) const CREDIT: Key = Key::whole("coordination.credit_ticks", 0, [0, 2000], "ticks")
    .means("Self-timed line: its delay each way in its own time, as samples of zero that an end begins with; 0 follows the network.");
/// What is added beside what was missing, ms.
const SPARE: i32 = 2;
/// What may always be left before the line is made shorter, ms: 20 % of single losses are bridged without standing.
const KEPT: i32 = 8;
/// For how long it must have been left, s.
const WINDOW_S: f64 = 1.0;
/// The credit that following begins with, beside a packet's ticks, s.
const FIRST_S: f64 = 0.015;
/// What a tick that stands adds to impatience, and a live one takes from it: balanced at a tenth of the time.
const STANDING: i32 = 10;
/// Impatience from which on the line is made longer, and the most there is: 100 and 200 ms in a row.
const IMPATIENT: i32 = 100 * STANDING;
/// What may be added at once after a quiet time, and at most, ms.
const LEAST_AT_ONCE: i32 = 4;
const MOST_AT_ONCE: i32 = 128;
/// And where a line begins: half of a round trip of a second.
const FIRST_AT_ONCE: i32 = 512;
/// The largest wave at which more than one sample may come out in a tick, √W.
const NEARLY_AT_REST: f64 = 0.25;
/// What a line begins with beside what came, once and for all, J: the last bit of a sum of a million joules, several times.
const ROUNDING_J: f64 = 5e-10;
/// Ticks over which a sample more comes out: each takes one and a slice.
const SLICES: i32 = 16;
/// Counters of live ticks begin at a multiple of this; that of a peer that begins anew jumps to the next but one, further than a line can ever hold.
const ANEW: u32 = 1 << 20;

/// Where the counter of a peer goes on that begins anew after `live` ticks.
#[inline]
pub(super) fn restart_counter(live: u32) -> u32 {
    (live | (ANEW - 1)).wrapping_add(1 + ANEW)
}

/// How samples come out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Incoming<C> {
    /// T_c, s.
    period_s: C,
    /// d₀, or what following begins with.
    credit: i32,
    follows: bool,
    /// What may always be left: [`KEPT`], less what silence uses up.
    kept: i32,
    /// Ticks of a millisecond, and of [`WINDOW_S`].
    per_ms: i32,
    window: i32,
    /// [`NEARLY_AT_REST`].
    nearly_at_rest: C,
    /// ½·T_c, s.
    half_period_s: C,
    /// ρ₀; 1 where b stays what it is.
    least: C,
    /// 1/[`SLICES`].
    slice: C,
    /// Ticks without a packet after which nothing comes any more.
    gap: u32,
}

configured!([C: Scalar] Incoming<C> {
    period_s, credit, follows, kept, per_ms, window, nearly_at_rest, half_period_s, least, slice, gap
});

/// The other end's counters, as they came.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Counters<C> {
    live: u32,
    integral: C,
    energy_j: C,
}

/// What was heard and has not been emitted yet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct DelayLine<C> {
    /// The newest that was heard; nothing comes out before.
    heard: Option<Counters<C>>,
    /// Wave integral outstanding R, √W·s.
    pub(super) integral: C,
    /// k, and what it was when the newest packet had come.
    pub(super) samples: i32,
    pub(super) came: u16,
    /// What was heard less what was emitted, J: what averaging has saved, and what is outstanding.
    account_j: C,
    /// The sample that came out last, √W.
    pub(super) last: C,
    /// d₀: how long the line to this end is, ticks.
    pub(super) length: i32,
    /// It stands because nothing reaches it.
    pub(super) is_cut_off: bool,
    /// Ticks that the line has stood since something came.
    held: i32,
    /// How much more than a tenth of the time it has stood lately.
    impatience: i32,
    /// What may be added at once, ms.
    reach: i32,
    /// Fewest samples left in this window, and ticks of it.
    fewest: i32,
    watched: i32,
    /// Samples by which the line is to be made shorter, and slices of the next of them that have come out.
    surplus: i32,
    sliced: i32,
}

impl<C> DelayLine<C> {
    /// It has stood lately although packets came.
    #[inline]
    pub(super) fn was_held_recently(&self) -> bool {
        self.impatience > 0
    }
}

impl<C: Scalar> Incoming<C> {
    pub(super) fn build(settings: &Settings) -> Self {
        let timing = &settings.timing;
        let credit = settings.own(&CREDIT) as i32;
        let per_ms = (libm::round(0.001 / timing.control_period_s) as i32).max(1);
        let kept = (KEPT * per_ms).cast_unsigned();
        // A cast saturates; a tick is at least 10 µs and a packet at most 1000 of them.
        // Where packets come by events, silence uses up what may always be left.
        let events = Events::<C>::build(settings);
        let silence = (settings.own(&LONGEST) / timing.control_period_s) as u32;
        let longest = silence.max(timing.ticks_per_packet);
        let together = events.map_or(timing.ticks_per_packet, |events| events.excess_ticks(kept) + 1);
        let first = together.cast_signed() + libm::round(FIRST_S / timing.control_period_s) as i32;
        Self {
            period_s: C::from_f64(timing.control_period_s),
            credit: if credit > 0 { credit } else { first },
            follows: credit == 0,
            kept: events.map_or(kept, |events| events.remaining_ticks(kept)).cast_signed(),
            per_ms,
            window: (WINDOW_S / timing.control_period_s) as i32,
            nearly_at_rest: C::from_f64(NEARLY_AT_REST),
            half_period_s: C::from_f64(0.5 * timing.control_period_s),
            least: C::from_f64(super::mass::least(settings)),
            slice: C::from_f64(1.0 / f64::from(SLICES)),
            gap: longest.saturating_add(kept),
        }
    }

    /// Takes in the counters of a packet, after `own` live ticks of this end. The first, or a jump: both ends begin anew. False if it is older than
    /// the newest.
    #[inline]
    pub(super) fn receive<S: Scalar<Counter = C>>(
        &self,
        state: &mut DelayLine<C>,
        packet: &Packet<S>,
        own: u32,
    ) -> bool {
        let Packet { wave_integral: integral, energy_j, live_ticks: live, .. } = *packet;
        let heard = Counters { live, integral, energy_j };
        let Some(newest) = &mut state.heard else {
            *state = self.begin(heard, own);
            return true;
        };
        let new = heard.live.wrapping_sub(newest.live).cast_signed();
        if new > (ANEW / 2).cast_signed() {
            *state = self.begin(heard, own);
            return true;
        }
        if new < 0 {
            return false;
        }
        if new > 0 {
            let before = core::mem::replace(newest, heard);
            state.samples = state.samples.saturating_add(new);
            state.integral = state.integral + (heard.integral - before.integral);
            state.account_j = state.account_j + (heard.energy_j - before.energy_j);
            if self.follows && state.held > 0 && state.impatience >= IMPATIENT * self.per_ms {
                // The other end stands as long and adds its half, in whole milliseconds.
                let twice = 2 * self.per_ms;
                let half = state.held.saturating_add(twice - 1).checked_div(twice);
                let more = self.per_ms * (half.unwrap_or(0).min(state.reach) + SPARE);
                (state.samples, state.length) = (state.samples.saturating_add(more), state.length.saturating_add(more));
                state.reach = (2 * state.reach).min(MOST_AT_ONCE);
                (state.fewest, state.watched, state.surplus) = (i32::MAX, 0, 0);
            }
            (state.held, state.came) = (0, state.samples as u16);
        }
        true
    }

    /// A line to which nothing has come yet.
    pub(super) fn start(&self) -> DelayLine<C> {
        DelayLine { length: self.credit, ..DelayLine::default() }
    }

    /// A line begins here, with what the other end has said of itself, after `own` live ticks. It holds d₀ samples of each end, whichever heard the
    /// other first: what this end has emitted of its own already is under way or counted, and what the other one had emitted when it said so is
    /// counted nowhere else.
    fn begin(&self, heard: Counters<C>, own: u32) -> DelayLine<C> {
        DelayLine {
            heard: Some(heard),
            samples: (self.credit + self.of_first(heard.live) - self.of_first(own)).max(0),
            length: self.credit,
            account_j: C::from_f64(ROUNDING_J),
            reach: FIRST_AT_ONCE,
            fewest: i32::MAX,
            ..DelayLine::default()
        }
    }

    /// How many of the first samples of a line are out after so many live ticks: at most those of both ends, which one end has where it heard the
    /// other one last. None where it has emitted more, on a line before this.
    #[inline]
    fn of_first(&self, live: u32) -> i32 {
        let emitted = (live % ANEW).cast_signed();
        if emitted > 2 * self.credit { 0 } else { emitted }
    }

    /// u_in of this tick, √W, and the ρ, `own` or less, at which it is paid for: ρ₀ or more, or 0, and the line stands. Two numbers come back in
    /// registers. Once in the image, not once for each kind of tick: it is 400 bytes of ITCM.
    #[inline(never)]
    pub(super) fn next_wave<S: Scalar<Counter = C>>(&self, state: &mut DelayLine<C>, own: S) -> (S, S) {
        if state.samples <= 0 {
            return (S::ZERO, S::ZERO);
        }
        state.is_cut_off = false;
        if state.samples == 1 {
            // Of the last what is left comes out.
            state.sliced = 0;
        }
        let outstanding = C::from_i32(state.samples) - C::from_i32(state.sliced) * self.slice;
        let mean = state.integral.over(outstanding * self.period_s);
        let all_j = outstanding * self.price_j(mean);
        if self.least * all_j > state.account_j {
            return (S::ZERO, S::ZERO);
        }
        // Where all have the same ρ it pays by itself (Jensen). Nothing by nothing is no number, and no less than its own.
        let pays = state.account_j.over(all_j.max(state.account_j));
        let share = S::of_counter(pays.min(own.to_counter()).max(self.least));
        let paid = share.to_counter();
        let wave = if self.follows { self.follow(state, mean, [outstanding, paid]) } else { mean };
        state.impatience = (state.impatience - 1).max(0);
        // What comes out is what is booked, to the bit.
        let wave = S::of_counter(wave);
        state.last = wave.to_counter();
        state.integral = state.integral - self.period_s * state.last;
        state.samples -= 1;
        if state.sliced == SLICES {
            (state.sliced, state.surplus) = (0, state.surplus - 1);
            (state.samples, state.length) = (state.samples - 1, state.length - 1);
        }
        state.account_j = state.account_j - paid * self.price_j(state.last);
        (wave, share)
    }

    /// A tick in which nothing came out; `far_is_cut_off`: the other end says that nothing reaches it.
    #[inline(never)]
    pub(super) fn hold(&self, state: &mut DelayLine<C>, age_ticks: u32, far_is_cut_off: bool) {
        if state.heard.is_none() || state.samples > 0 {
            return;
        }
        state.is_cut_off = age_ticks > self.gap;
        if !state.is_cut_off && !far_is_cut_off {
            state.held = state.held.saturating_add(1);
            state.impatience = (state.impatience + STANDING).min(2 * IMPATIENT * self.per_ms);
        }
        state.fewest = 0;
        state.last = C::ZERO;
    }

    /// Energy of this wave through one tick at ρ = 1, ½·T_c·u², J.
    #[inline]
    pub(super) fn price_j(&self, wave: C) -> C {
        self.half_period_s * wave * wave
    }

    /// What comes out in this tick: a slice more than the mean where the line is longer than it need be and can afford to be shorter.
    #[inline]
    fn follow(&self, state: &mut DelayLine<C>, mean: C, [outstanding, share]: [C; 2]) -> C {
        state.fewest = state.fewest.min(state.samples);
        state.watched += 1;
        if state.watched >= self.window {
            state.surplus = (state.fewest - self.kept).max(0) / 2;
            state.reach = LEAST_AT_ONCE;
            (state.fewest, state.watched) = (i32::MAX, 0);
        }
        if state.surplus == 0 || state.samples < 2 || mean.abs() > self.nearly_at_rest {
            return mean;
        }
        let more = mean + self.slice * mean;
        let left = (outstanding - C::ONE - self.slice) * self.price_j(mean);
        if state.account_j < share * (self.price_j(more) + left) {
            return mean;
        }
        state.sliced += 1;
        more
    }
}
