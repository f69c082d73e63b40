//! How heavy the line is, and its end: an impedance that falls where the line is long (THEORY §11).
//!
//! Both ends of a line together move as a mass b·T does, T its delay each way. With `coordination.most_line_mass_kg` = m an end whose
//! line is d₀ ticks long is one of ρ·b,
//!
//! > ρ = min(1, m/(b·d₀·T_c)), and no less than [`LEAST`],
//!
//! in steps of [`STEP`]. Each end tells the other one what it would have, and goes to the lesser of both by a step a tick. Waves keep the unit that they have at ρ = 1, so that x_d, the sum of both over √(2b), is what it
//! was, whatever ρ is at either end, and whenever it changes:
//!
//! > ρ·b·w + F_T = ρ·√(2b)·u_in,   u_out = √(2b)·w − u_in,   F_T·w = ½ρ·(u_in² − u_out²)
//!
//! **Passive whatever the other end's ρ is**, while they differ, too. A wave carries ½ρ·u², with the ρ of the end that sends it, and the
//! counter of that energy comes with the waves. An end that takes in more than its own ρ would emit loses the rest; one that would emit more
//! than what came takes the ρ that this pays for ([`super::incoming`]). So ρ falls whenever it should, and rises at rest, where it costs nothing,
//! or at the expense of what averaging has saved.

use crate::law::Spring;
use crate::law::terminal::Ended;
use crate::num::Scalar;
use crate::object::{Port, Solve};
use crate::settings::{Key, Settings};

pub(super) const MASS: Key = Key::number(
    "coordination.most_line_mass_kg",
    4.0,
    [0.0, 1000.0],
    "kg",
    "Self-timed line: what the line between both hands may weigh, b·T; where it is long, b falls for that; 0 leaves b as it is.",
);

/// The least ρ: a line that would still be heavier is.
const LEAST: f64 = 1.0 / 16.0;
/// Step of ρ, and its change in a tick: a second at 1 kHz from 1 to nothing. Every number type has it exactly.
const STEP: f64 = 1.0 / 1024.0;

/// The end of a line behind the coordination spring, as a port of the object ([`crate::law::terminal`]), for any ρ.
#[derive(Clone, Copy, Debug)]
pub(super) struct End<S> {
    /// K_T, N/m.
    stiffness: S,
    /// κ of the spring with what is in a row with it, N·s/m.
    kappa: S,
    /// b, N·s/m, and √(2b).
    impedance: S,
    root: S,
    /// m/(b·T_c): the ticks up to which ρ is 1; 0 where it always is.
    light_ticks: S,
    least: S,
    step: S,
}

configured!([S: Scalar] End<S> { stiffness, kappa, impedance, root, light_ticks, least, step });

/// ρ of an end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Share<S> {
    /// What it would have with a line of so many ticks, and what the other end would have.
    wanted: S,
    ticks: i32,
    far: S,
    /// Its own.
    own: S,
    /// The one of the newest tick, which was paid for, and 1/(ρ·b + κ).
    paid: S,
    inverse_sum: S,
}

impl<S: Scalar> End<S> {
    /// A line whose spring has the impedance `kappa`, N·s/m.
    pub(super) fn build(settings: &Settings, kappa: f64) -> Self {
        let impedance = settings.coordination.wave_impedance_n_s_per_m;
        let light_ticks = settings.own(&MASS) / (impedance * settings.timing.control_period_s);
        let numbers = [kappa, impedance, libm::sqrt(2.0 * impedance), light_ticks, LEAST, STEP];
        let [kappa, impedance, root, light_ticks, least, step] = numbers.map(S::from_f64);
        Self { stiffness: Spring::build(settings).stiffness, kappa, impedance, root, light_ticks, least, step }
    }

    /// ρ of a line so many ticks long.
    fn wanted(&self, ticks: i32) -> S {
        let ticks = S::from_i32(ticks);
        if ticks <= self.light_ticks || self.light_ticks == S::ZERO {
            return S::ONE;
        }
        let steps = self.light_ticks.ratio(ticks * self.step).round_to_i32();
        (S::from_i32(steps) * self.step).max(self.least)
    }

    /// An end of a line that begins, so many ticks long.
    pub(super) fn start(&self, ticks: i32) -> Share<S> {
        let wanted = self.wanted(ticks);
        let mut share = Share { wanted, ticks, far: S::ONE, own: wanted, ..Share::default() };
        self.take(&mut share, wanted);
        share
    }

    /// Takes in what the other end says: by how much its ρ would be below 1.
    pub(super) fn hear(&self, share: &mut Share<S>, less: S) {
        share.far = (S::ONE - less).max(self.least).min(S::ONE);
    }

    /// By how much the ρ that this end would have is below 1.
    pub(super) fn says(&self, share: &Share<S>) -> S {
        S::ONE - share.wanted
    }

    /// ρ that this end would have in this tick, of a line so many ticks long.
    #[inline]
    pub(super) fn own(&self, share: &mut Share<S>, ticks: i32) -> S {
        if ticks != share.ticks {
            (share.ticks, share.wanted) = (ticks, self.wanted(ticks));
        }
        let more = share.wanted.min(share.far) - share.own;
        if more != S::ZERO {
            share.own = share.own + more.limit(self.step);
        }
        share.own
    }

    /// Goes over to the ρ that was paid for.
    #[inline]
    fn take(&self, share: &mut Share<S>, paid: S) {
        if paid != share.paid {
            share.paid = paid;
            share.inverse_sum = S::ONE.over(paid * self.impedance + self.kappa);
        }
    }

    /// What the spring pulls with from this stretch (m) while nothing moves, N.
    #[inline]
    pub(super) fn pull(&self, stretch: S) -> S {
        self.stiffness * stretch
    }

    /// A tick with a wave coming in, √W, which is paid for at this ρ, and in which the spring begins with this pull, N.
    #[inline]
    pub(super) fn meet(
        &self,
        share: &mut Share<S>,
        pull: S,
        [wave_in, paid]: [S; 2],
        solve: impl Solve<S>,
    ) -> Ended<S> {
        self.take(share, paid);
        // ρ·b·w = drive − κ·(w − v): what is left of the wave's push once the spring has taken its part.
        let drive = paid * self.root * wave_in - pull;
        let part = self.kappa * share.inverse_sum;
        let port = Port { force: pull + part * drive, impedance: paid * self.impedance * part };
        let mean = solve.velocity(port);
        let velocity = (drive + self.kappa * mean) * share.inverse_sum;
        Ended { velocity, copy: mean, force: port.at(mean) }
    }

    /// Outgoing wave u_out, √W.
    #[inline]
    pub(super) fn wave_out(&self, velocity: S, wave_in: S) -> S {
        self.root * velocity - wave_in
    }
}
