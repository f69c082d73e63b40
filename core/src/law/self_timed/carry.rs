//! Carrying on where nothing comes (THEORY §11): the point to which the spring K_T is tied goes on as it went and yields to what pulls
//! harder than before, instead of standing like a wall.
//!
//! Between the line's end and the spring lies a **slip** e, F_T = K_T·(x_d + e − x_o) + B_T·(w + ė − v). It moves like a damper that
//! something drives, in series with the spring:
//!
//! > ė = (A − F_T)/D,   A = F + D·r
//!
//! | the end | D | F | r goes to |
//! |---|---|---|---|
//! | stands, and has not heard of the other end's slip yet | ∞ | | |
//! | stands, and hears nothing | `coordination.carry_damping_n_s_per_m` | F̄ | w̄ + [`BLIND`]·c |
//! | stands, and hears the other end, which stands | [`HEARD`] times it | F̄ | w_far + c |
//! | is live | [`LIVE`] times κ | F₋ | c |
//!
//! with F̄ and w̄ the force (within [`MOST_N`]) and the line's velocity lately (one pole of [`LATELY_S`]), of which w̄ fades while the end
//! stands, F₋ the force of the tick before, w_far how fast the other end's point goes, as its newest packet said, and
//! c = (e_far − e)/2τ_c the way to the slip of the other end: only the difference of both slips holds the copies apart, and what both ends
//! coast alike is none. An end that hears nothing takes it that the other one coasts as it would itself, e_far going on at w̄: what it
//! yields to a hand beyond that it takes back. The one that hears it follows, and resists its own hand more. Of a live end F₋ − F_T
//! makes a spring of stiffness D/T_c, 1 % of the compliance of K_T: that part of e, −F₋·T_c/D, is the end's own. What is told of e, and
//! drawn to the other's, is the rest, which goes at c whatever pulls: nothing goes round a loop.
//!
//! **Without a jolt.** Where the line begins or ceases to go, or goes faster than a hand can make it go ([`JOLT_M_PER_S2`]), the point goes on as it
//! went: r takes up the difference, and then goes to where it should be with one pole ([`STANDING_S`], [`LIVE_S`]).
//!
//! **Passive by its own account.** A tick of it costs F_T·ė·T_c, whatever F_T comes to be at most A²·T_c/4D. A tank E begins with E₀, pays what a
//! tick costs, and takes what it brings and what the damper B_T took. Where it may not pay, E < A²·T_c/4D, an end that stands has a D that is
//! larger by as much: an empty tank leaves a wall, which what pulls harder than A softens and fills (one that left a damper would let two hands
//! that push against each other part the ends). A live end, whose D is the line's, has an A that is smaller by the root of it. E is never below 0, nothing
//! is solved twice, and nothing switches.
//!
//! With `coordination.carry_damping_n_s_per_m = 0` D is infinite: e stays 0, and an end that stands is a wall (THEORY §8).

use super::taut::{Taken, Taut};
use crate::law::Spring;
use crate::law::bounds::WITHIN;
use crate::law::credit::CAP_J;
use crate::law::terminal::TerminalState;
use crate::num::{Motion, Scalar};
use crate::settings::{Key, Settings};

pub(super) const DAMPING: Key = Key::number("coordination.carry_damping_n_s_per_m", 5.0, [0.0, 1000.0], "N·s/m")
    .means("Self-timed line, where nothing comes: damping with which the point that the copy is tied to goes another way than on; 0 is a wall.");
pub(super) const FADE: Key = Key::number("coordination.carry_s", 0.35, [0.001, 100.0], "s")
    .means("Self-timed line, where nothing comes: time in which going on as before fades.");
pub(super) const RETURN: Key = Key::number("coordination.carry_return_s", 0.05, [0.001, 100.0], "s")
    .means("Self-timed line: time in which both ends come together again, where they have gone different ways.");
pub(super) const ENERGY: Key = Key::number("coordination.carry_energy_j", 0.03, [0.0, 1.0], "J")
    .means("Self-timed line: what carrying on may give at most before it has taken anything, at each end.");

/// D of an end that hears the other one, as a multiple of that of an end that hears nothing.
const HEARD: f64 = 1.6;
/// How much faster an end that hears nothing comes back to where the other one should be.
const BLIND: f64 = 8.0;
/// D of a live end, as a multiple of κ of its spring.
const LIVE: f64 = 200.0;
/// How long ago "lately" is, s.
const LATELY_S: f64 = 0.004;
/// The most force that goes on while an end stands, N: what a hand pushes with, and not a jolt.
const MOST_N: f64 = 10.0;
/// Fastest way to the other end's slip while the line is live, and while it stands, m/s.
const LIVE_M_PER_S: f64 = 0.3;
const STANDING_M_PER_S: f64 = 1.0;
/// Time constants of r while the line stands, and while it is live, s.
const STANDING_S: f64 = 0.002;
const LIVE_S: f64 = 0.011;
/// And at most this share of τ_c: from τ_c on the loop of both slips would swing over a long delay.
const SOONER: f64 = 0.25;
/// What a line's speed changes by, and is no jolt, m/s².
const JOLT_M_PER_S2: f64 = 2.5;
/// Slips are told modulo this, m: of two that are less than half of it apart the difference is known, however far both have gone.
pub(crate) const MODULUS_M: f64 = 16.0;

/// What the end of a line does in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LinePhase {
    /// It emits.
    Live,
    /// It stands, and packets come.
    Hears,
    /// It stands, and nothing comes.
    Blind,
    /// It stands, and the other end has not said anything of its slip yet.
    Alone,
}

/// Spring and slip in a row, with a damping of its own: F_T = σ·K_T·s + (1 − σ)·A + z·(w − v), z = σ·κ.
#[derive(Clone, Copy, Debug)]
struct Series<S> {
    /// D, N·s/m, and 1/D.
    damping: S,
    inverse: S,
    /// σ = D/(D + κ).
    stiff: S,
    /// z, N·s/m.
    impedance: S,
    /// T_c/4D: what a tick may cost at most, as a share of A², J/N².
    costs: S,
    /// Share of its way that r goes in a tick.
    soon: S,
}

configured!([S: Scalar] Series<S> { damping, inverse, stiff, impedance, costs, soon });

impl<S: Scalar> Series<S> {
    /// Of a damping D, N·s/m, and κ, in a period of T_c, s, with a time constant of r, s; D = 0 for a wall.
    fn build(damping: f64, kappa: f64, [period_s, soon_s]: [f64; 2]) -> Self {
        let (inverse, stiff) = if damping == 0.0 { (0.0, 1.0) } else { (1.0 / damping, damping / (damping + kappa)) };
        let soon = 1.0 - libm::exp(-period_s / soon_s);
        let numbers = [damping, inverse, stiff, stiff * kappa, 0.25 * period_s * inverse, soon];
        let [damping, inverse, stiff, impedance, costs, soon] = numbers.map(S::from_f64);
        Self { damping, inverse, stiff, impedance, costs, soon }
    }
}

/// How an end carries on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carry<S: Scalar> {
    period_s: S,
    /// κ and B_T, N·s/m.
    kappa: S,
    spring_damping: S,
    blind: Series<S>,
    hears: Series<S>,
    live: Series<S>,
    taut: Taut<S>,
    /// T_c/D of a live end, m/N.
    elastic_m_per_n: S,
    /// Share of w̄ that is left after a tick, and of what is new in F̄ and w̄.
    left: S,
    new: S,
    /// 1/2τ_c, and of an end that hears nothing, 1/s.
    back: S,
    blind_back: S,
    live_m_per_s: S,
    standing_m_per_s: S,
    most_n: S,
    /// What a tick changes of the line's speed and is no jolt, m/s.
    jolt_m_per_s: S,
    capital_j: S,
    most_j: S,
    /// The fastest that a packet may say, m/s.
    within_m_per_s: S,
    half_m: S::Counter,
}

configured!([S: Scalar] Carry<S> {
    period_s, kappa, spring_damping, blind, hears, live, taut, elastic_m_per_n, left, new, back, blind_back, live_m_per_s,
    standing_m_per_s, most_n, jolt_m_per_s, capital_j, most_j, within_m_per_s, half_m
});

/// What an end knows of the other one's slip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Slips {
    /// Nothing: both begin together.
    #[default]
    Nothing,
    /// Nothing: this end begins anew where it is, and the other one goes on.
    Anew,
    Known,
}

/// Slip and tank of an end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Slip<S: Scalar> {
    /// e, but for what is elastic in it, m.
    own_m: S::Counter,
    /// What the other end's slip is more, m; w_far, m/s.
    ahead_m: S,
    far_m_per_s: S,
    /// How far the other end should have coasted since it was heard last, m.
    coasted_m: S,
    /// F₋, F̄, N.
    force: S,
    lately_force: S,
    /// w̄, m/s.
    lately_m_per_s: S,
    /// w + ė, m/s.
    anchor_m_per_s: S,
    /// r, m/s.
    rate_m_per_s: S,
    /// What of it nobody is told, and how far that went in this tick, m.
    taken: Taken<S>,
    took_m: S,
    /// It stood in the tick before.
    pub(super) held: bool,
    /// E, J.
    tank_j: S,
    /// It has begun, or begun anew, and heard nothing of the other end's slip since.
    heard: Slips,
}

// F₋, all that a live line feels of it. What is told of slips is driven by nothing while both ends are live, and rests where it began: a
// loop of its own, ė = (e_far(t − T) − e)/2τ_c at both ends, whose roots but for the common slip decay at any delay T. That an end is behind drives
// it, and no linear line has such an end: as many samples are outstanding at both.
visited!([S: Scalar] Slip<S> { force, taken });

/// The spring of a tick, in a row with what it is tied to.
#[derive(Clone, Copy, Debug)]
pub(super) struct AnchorForce<S> {
    /// A and 1/D.
    drive: S,
    inverse: S,
    /// What it pulls with while nothing moves, N, and its impedance z, N·s/m.
    pub(super) pull: S,
    pub(super) impedance: S,
}

impl<S: Scalar> Carry<S> {
    pub(super) fn build(settings: &Settings) -> Self {
        let (period_s, damping) = (settings.timing.control_period_s, settings.own(&DAMPING));
        let return_s = settings.own(&RETURN);
        let (live, kappa) = (Self::live(settings), Spring::<S>::impedance(settings));
        let (capital_j, safety) = (settings.own(&ENERGY), settings.in_the_world().safety);
        let elastic_m_per_n = if damping > 0.0 { period_s / live } else { 0.0 };
        let number = S::from_f64;
        Self {
            period_s: number(period_s),
            spring_damping: number(settings.coordination.damping_n_s_per_m),
            kappa: number(kappa),
            blind: Series::build(damping, kappa, [period_s, STANDING_S]),
            hears: Series::build(HEARD * damping, kappa, [period_s, STANDING_S]),
            live: Series::build(live, kappa, [period_s, LIVE_S.min(SOONER * return_s)]),
            taut: Taut::build(settings, elastic_m_per_n, capital_j),
            elastic_m_per_n: number(elastic_m_per_n),
            left: number(libm::exp(-period_s / settings.own(&FADE))),
            new: number(1.0 - libm::exp(-period_s / LATELY_S)),
            back: number(0.5 / return_s),
            blind_back: number(BLIND * 0.5 / return_s),
            live_m_per_s: number(LIVE_M_PER_S),
            standing_m_per_s: number(STANDING_M_PER_S),
            most_n: number(MOST_N),
            jolt_m_per_s: number(JOLT_M_PER_S2 * period_s),
            capital_j: number(capital_j),
            most_j: number(capital_j.max(CAP_J)),
            within_m_per_s: number(WITHIN * safety.max_speed_m_per_s),
            half_m: S::Counter::from_f64(0.5 * MODULUS_M),
        }
    }

    /// Impedance of a live end's spring, z, N·s/m.
    pub(super) fn impedance(settings: &Settings) -> f64 {
        let kappa = Spring::<S>::impedance(settings);
        Series::<f64>::build(Self::live(settings), kappa, [settings.timing.control_period_s, LIVE_S]).impedance
    }

    /// D of a live end, N·s/m; 0 for a wall.
    fn live(settings: &Settings) -> f64 {
        if settings.own(&DAMPING) > 0.0 { LIVE * Spring::<S>::impedance(settings) } else { 0.0 }
    }

    /// An end that has not slipped.
    pub(super) fn start(&self) -> Slip<S> {
        Slip { tank_j: self.capital_j, taken: self.taut.start(), ..Slip::default() }
    }

    /// An end that begins anew, with what is left in its tank.
    pub(super) fn restart(&self, slip: &Slip<S>) -> Slip<S> {
        Slip { tank_j: slip.tank_j, heard: Slips::Anew, ..self.start() }
    }

    /// A slip within what may be told, and by how much it was more, m: [`MODULUS_M`], or nothing.
    #[inline]
    fn within(&self, slip_m: S::Counter) -> (S::Counter, S::Counter) {
        if slip_m.abs() <= self.half_m {
            return (slip_m, S::Counter::ZERO);
        }
        let twice_m = slip_m + slip_m;
        let turn_m = twice_m.limit(self.half_m + self.half_m);
        // However far it jumped.
        ((slip_m - turn_m).limit(self.half_m), turn_m)
    }

    /// A slip that cannot be told is the line's own: gives by how much x_d is more then, m.
    #[inline]
    pub(super) fn turn(&self, slip: &mut Slip<S>) -> S::Counter {
        let (own_m, turn_m) = self.within(slip.own_m);
        slip.own_m = own_m;
        turn_m
    }

    /// Where the point is that the spring is tied to, for an x_d, m.
    #[inline]
    pub(super) fn anchor(&self, slip: &Slip<S>, desired: S::Counter) -> S::Counter {
        desired + slip.own_m + (slip.taken.way_m - self.elastic_m_per_n * slip.force).to_counter()
    }

    /// What a packet says of this end.
    pub(super) fn packet_field(&self, slip: &Slip<S>) -> Motion<S> {
        Motion::new(S::of_counter(slip.own_m), slip.anchor_m_per_s.limit(self.within_m_per_s))
    }

    /// The other end is not engaged: it will begin anew as well, from this end's slip.
    pub(super) fn receive_idle(&self, slip: &mut Slip<S>) {
        if slip.heard == Slips::Anew {
            slip.heard = Slips::Nothing;
        }
    }

    /// Takes in what the other end says of its own. One that has just begun anew calls its point's place what the other end calls its own:
    /// gives by how much x_d is less then, m.
    pub(super) fn receive(&self, slip: &mut Slip<S>, told: Motion<S>) -> S::Counter {
        slip.far_m_per_s = told.velocity;
        let ahead_m = S::of_counter(self.within(told.position.to_counter() - slip.own_m).0);
        if core::mem::replace(&mut slip.heard, Slips::Known) == Slips::Anew {
            let less_m = ahead_m.to_counter();
            slip.own_m = slip.own_m + less_m;
            slip.ahead_m = S::ZERO;
            return less_m;
        }
        slip.ahead_m = ahead_m;
        S::Counter::ZERO
    }

    /// What an end does that has nothing to emit, and to which nothing comes or does.
    #[inline]
    pub(super) fn phase_of(&self, slip: &Slip<S>, is_cut_off: bool) -> LinePhase {
        match slip.heard {
            Slips::Known if is_cut_off => LinePhase::Blind,
            Slips::Known => LinePhase::Hears,
            _ => LinePhase::Alone,
        }
    }

    /// The line goes on after it stood, as fast as `line` says for a force (N) that it pulls with: the point goes on as it went.
    #[inline]
    pub(super) fn resume(&self, slip: &mut Slip<S>, line: impl FnOnce(S) -> S) {
        slip.held = false;
        slip.rate_m_per_s = slip.anchor_m_per_s - line(slip.force);
    }

    /// The line goes faster than in the tick before, m/s: what of it is a jolt the point does not do at once.
    #[inline]
    pub(super) fn step_input(&self, slip: &mut Slip<S>, more: S) {
        slip.rate_m_per_s = slip.rate_m_per_s - (more - more.max(-self.jolt_m_per_s).min(self.jolt_m_per_s));
    }

    /// The spring of this tick, which begins with this pull, N, at the end of a line so many ticks long with ρ, so many s behind the other end.
    #[inline]
    pub(super) fn couple_anchor(&self, slip: &mut Slip<S>, phase: LinePhase, pull: S, line: [S; 3]) -> AnchorForce<S> {
        let mut taut_m_per_s = S::ZERO;
        if phase == LinePhase::Live {
            taut_m_per_s = self.taut.slip_rate(&mut slip.taken, line, slip.force, slip.tank_j);
        } else if !core::mem::replace(&mut slip.held, true) {
            slip.rate_m_per_s = slip.anchor_m_per_s;
        }
        slip.took_m = self.period_s * taut_m_per_s;
        let (series, force, goal) = match phase {
            LinePhase::Live => {
                let ahead_m = slip.ahead_m + line[2] * slip.lately_m_per_s;
                (&self.live, slip.force, (self.back * ahead_m).limit(self.live_m_per_s))
            }
            LinePhase::Hears => {
                let back = (self.back * slip.ahead_m).limit(self.standing_m_per_s);
                (&self.hears, slip.lately_force.limit(self.most_n), slip.far_m_per_s + back)
            }
            LinePhase::Blind => {
                let back = (self.blind_back * (slip.ahead_m + slip.coasted_m)).limit(self.standing_m_per_s);
                (&self.blind, slip.lately_force.limit(self.most_n), slip.lately_m_per_s + back)
            }
            LinePhase::Alone => return AnchorForce { drive: S::ZERO, inverse: S::ZERO, pull, impedance: self.kappa },
        };
        let Series { damping, mut inverse, mut stiff, mut impedance, costs, soon } = *series;
        slip.rate_m_per_s = slip.rate_m_per_s + soon * (goal - slip.rate_m_per_s);
        let mut drive = force + damping * (slip.rate_m_per_s + taut_m_per_s);
        let most_j = costs * drive * drive;
        if most_j > slip.tank_j {
            let share = slip.tank_j.over(most_j);
            slip.took_m = share * slip.took_m;
            if phase == LinePhase::Live {
                drive = share.sqrt() * drive;
            } else {
                inverse = share * inverse;
                stiff = S::ONE.over(S::ONE + self.kappa * inverse);
                impedance = stiff * self.kappa;
            }
        }
        let pull = stiff * pull + (S::ONE - stiff) * drive;
        AnchorForce { drive, inverse, pull, impedance }
    }

    /// Books what came of a tick; gives how fast the point went, w + ė, m/s.
    #[inline]
    pub(super) fn update_slip(
        &self,
        slip: &mut Slip<S>,
        phase: LinePhase,
        spring: &AnchorForce<S>,
        terminal: &TerminalState<S>,
    ) -> S {
        let TerminalState { velocity: line, copy, force } = *terminal;
        let rate = (spring.drive - force) * spring.inverse;
        let step = self.period_s * rate + self.elastic_m_per_n * (force - slip.force) - slip.took_m;
        slip.taken.way_m = slip.taken.way_m + slip.took_m;
        slip.own_m = slip.own_m + step.to_counter();
        slip.ahead_m = slip.ahead_m - step;
        slip.anchor_m_per_s = line + rate;
        let through = slip.anchor_m_per_s - copy;
        let saved = self.spring_damping * through * through - force * rate;
        slip.tank_j = (slip.tank_j + self.period_s * saved).min(self.most_j).max(S::ZERO);
        slip.force = force;
        if phase == LinePhase::Live {
            slip.coasted_m = S::ZERO;
            slip.lately_force = slip.lately_force + self.new * (force - slip.lately_force);
            slip.lately_m_per_s = slip.lately_m_per_s + self.new * (line - slip.lately_m_per_s);
        } else {
            let blind = phase == LinePhase::Blind;
            slip.coasted_m = if blind { slip.coasted_m + self.period_s * slip.lately_m_per_s } else { S::ZERO };
            slip.lately_m_per_s = self.left * slip.lately_m_per_s;
        }
        slip.anchor_m_per_s
    }
}
