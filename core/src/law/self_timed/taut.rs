//! Tautness: what line and spring give way under a lasting force is taken back (THEORY §15).
//!
//! At rest under a force F both copies stand apart by C·F, C = d₀·T_c/(ρ·b) + 2/K_T. Each end knows its half of that, and lets a part g of
//! its slip ([`super::carry`]) go the other way, through three poles:
//!
//! > f₁ ← f₁ + (T_c/τ)·(F₋ − f₂ − f₁),  f₂ ← f₂ + (T_c/τ)·f₁,  ġ = (½α·s·C·f₂ − g)/τ, within [`FASTEST_M_PER_S`]
//!
//! An end tells nobody of g, and moves it while it is live. The tank pays for it as for the rest of the slip, and s lets go of it before
//! [`KEPT`] of what the tank began with is touched, which is for carrying on.
//!
//! **Why so slowly.** A lag feeds some band of frequencies, and beyond 180°, ωτ = √2, the slip damps. All that moves has to lie there: what
//! hands do, down to half a hertz, the mode of [`HEAVY_KG`] on the spring, and that of the line, τ ≥ [`SLOWER`]·d₀·T_c. What is fed empties the
//! tank, and then nothing carries on.

use crate::num::{Scalar, StateVector};
use crate::settings::{Key, Settings};

/// α, which the analyser judges at what the tank may leave of it.
pub const TAUTNESS: Key = Key::number("coordination.tautness", 0.0, [0.0, 1.5], "")
    .means("Self-timed line: share of what line and spring give way under a lasting force that is taken back.");
pub(super) const SLOWNESS: Key = Key::number("coordination.taut_s", 0.5, [0.001, 10.0], "s")
    .means("Self-timed line: time constant τ at least with which it is taken back; motions faster than 0.225/τ are damped by it.");

/// τ as a multiple of the line's delay.
const SLOWER: f64 = 1.8;
/// Share of what the tank began with that is kept for carrying on; over a fifth of it more tautness sets in.
const KEPT: f64 = 0.5;
/// What is on a soft spring at the most, kg.
const HEAVY_KG: f64 = 4.0;
/// Fastest of it, m/s.
const FASTEST_M_PER_S: f64 = 0.1;

/// How an end takes back its half.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taut<S> {
    period_s: S,
    /// α.
    share: S,
    /// What an end's own spring and slip give way, and half of what the line does per tick of it at ρ = 1, m/N.
    spring_m_per_n: S,
    tick_m_per_n: S,
    /// Least τ, and that of a line per tick, s.
    least_s: S,
    tick_s: S,
    kept_j: S,
    per_band: S,
    fastest_m_per_s: S,
}

configured!([S: Scalar] Taut<S> {
    period_s, share, spring_m_per_n, tick_m_per_n, least_s, tick_s, kept_j, per_band, fastest_m_per_s
});

/// What an end has taken back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Taken<S> {
    /// The line is taut.
    is_taut: bool,
    /// f₁ and f₂, N.
    sooner: S,
    force: S,
    /// g, m.
    pub(super) way_m: S,
}

impl<S: Scalar> StateVector<S> for Taken<S> {
    #[inline]
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        if self.is_taut {
            each(&mut self.sooner);
            each(&mut self.force);
            each(&mut self.way_m);
        }
    }
}

impl<S: Scalar> Taut<S> {
    /// Of an end that begins with `capital_j` (J), and whose slip is elastic by so many m/N; 0 is a wall, which takes nothing back.
    pub(super) fn build(settings: &Settings, elastic: f64, capital_j: f64) -> Self {
        let (period_s, coordination) = (settings.timing.control_period_s, &settings.coordination);
        let stiffness = coordination.stiffness_n_per_m;
        let (soft, is_taut) = (1.0 / stiffness.max(1.0), elastic > 0.0 && stiffness > 0.0);
        let least_s = settings.own(&SLOWNESS).max(SLOWER * libm::sqrt(2.0 * HEAVY_KG * soft));
        let number = S::from_f64;
        Self {
            period_s: number(period_s),
            share: number(if is_taut { settings.own(&TAUTNESS) } else { 0.0 }),
            spring_m_per_n: number(elastic + soft),
            tick_m_per_n: number(0.5 * period_s / coordination.wave_impedance_n_s_per_m),
            least_s: number(least_s),
            tick_s: number(SLOWER * period_s),
            kept_j: number(KEPT * capital_j),
            per_band: number(5.0 / (KEPT * capital_j).max(1e-6)),
            fastest_m_per_s: number(FASTEST_M_PER_S),
        }
    }

    /// Of an end that begins.
    pub(super) fn start(&self) -> Taken<S> {
        Taken { is_taut: self.share > S::ZERO, ..Taken::default() }
    }

    /// ġ of a tick, m/s, of a line so many ticks long with ρ (what else is said of it is of no meaning here), after a tick in which the spring pulled with this force, N; the tank holds so
    /// much, J.
    #[inline(never)]
    pub(super) fn slip_rate(&self, taken: &mut Taken<S>, [ticks, share, _]: [S; 3], force: S, tank_j: S) -> S {
        if !taken.is_taut {
            return S::ZERO;
        }
        let compliance = self.spring_m_per_n + (self.tick_m_per_n * ticks).over(share);
        let slow_s = self.least_s.max(self.tick_s * ticks);
        let soon = self.period_s.over(slow_s);
        taken.sooner = taken.sooner + soon * (force - taken.force - taken.sooner);
        taken.force = taken.force + soon * taken.sooner;
        let pays = ((tank_j - self.kept_j) * self.per_band).max(S::ZERO).min(S::ONE);
        let way_m = self.share * pays * compliance * taken.force;
        (way_m - taken.way_m).over(slow_s).limit(self.fastest_m_per_s)
    }
}
