//! How heavy the line is, and its end: an impedance that falls where the line is long (THEORY §11).
//!
//! Both ends of a line together move as a mass b·T does, T its delay each way. With `coordination.most_line_mass_kg` = m an end whose
//! line is d₀ ticks long is one of ρ·b,
//!
//! > ρ = min(1, m/(b·d₀·T_c)), and no less than [`LEAST`]
//!
//! in steps of [`STEP`]. Each end tells the other one what it would have, and goes to the lesser of both by a step a tick. Waves keep the
//! unit that they have at ρ = 1, so that x_d, the sum of both over √(2b), is what it was, whatever ρ is at either end, and whenever it changes:
//!
//! > ρ·b·w + F_T = ρ·√(2b)·u_in,   u_out = √(2b)·w − u_in = u_in − √(2/b)·F_T/ρ,   F_T·w = ½ρ·(u_in² − u_out²)
//!
//! **Passive whatever the other end's ρ is**, while they differ, too. A wave carries ½ρ·u², with the ρ of the end that sends it, and the
//! counter of that energy comes with the waves. An end that takes in more than its own ρ would emit loses the rest; one that would emit more
//! than what came takes the ρ that this pays for, and stands where that is less than any end has, ρ₀ ([`super::incoming`]). So ρ falls whenever it
//! should, and rises at rest, where it costs nothing, or at the expense of what averaging has saved. And no end that pulls with F and whose line moves at w
//! ever says more than b·w + F/ρ₀, whatever it was told ([`crate::law::bounds`]).

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

/// The least ρ that an end goes to: a line that would still be heavier is.
const LEAST: f64 = 0.25;
/// Step of ρ, and its change in a tick: a second at 1 kHz from 1 to nothing. Every number type has it exactly.
const STEP: f64 = 1.0 / 1024.0;

/// ρ₀, below which no end emits: a step less than it would ever go to; 1 where b stays what it is.
pub(in crate::law) fn least(settings: &Settings) -> f64 {
    if settings.own(&MASS) > 0.0 { LEAST - STEP } else { 1.0 }
}

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
    /// √(2/b).
    force_to_wave: S,
    /// m/(b·T_c): the ticks up to which ρ is 1; 0 where it always is.
    light_ticks: S,
    least: S,
    step: S,
}

configured!([S: Scalar] End<S> { stiffness, kappa, impedance, root, force_to_wave, light_ticks, least, step });

/// ρ of an end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Share<S> {
    /// What it would have with a line of so many ticks, what the other end would have, and the lesser of both.
    wanted: S,
    ticks: i32,
    far: S,
    agreed: S,
    /// Its own, which goes there.
    own: S,
    /// The one of the newest tick, which was paid for; 1/(ρ·b + κ), and √(2/b)/ρ, the part of u_out that is force.
    paid: S,
    inverse_sum: S,
    force_to_wave: S,
}

impl<S: Scalar> Share<S> {
    /// The other end would have less than 1.
    #[inline]
    pub(super) fn is_told(&self) -> bool {
        self.far != S::ONE
    }
}

impl<S: Scalar> End<S> {
    /// A line whose spring has the impedance `kappa`, N·s/m.
    pub(super) fn build(settings: &Settings, kappa: f64) -> Self {
        let impedance = settings.coordination.wave_impedance_n_s_per_m;
        let light_ticks = settings.own(&MASS) / (impedance * settings.timing.control_period_s);
        let least = if light_ticks > 0.0 { LEAST } else { 1.0 };
        let root = libm::sqrt(2.0 * impedance);
        let numbers = [kappa, impedance, root, 2.0 / root, light_ticks, least, STEP];
        let [kappa, impedance, root, force_to_wave, light_ticks, least, step] = numbers.map(S::from_f64);
        let stiffness = Spring::build(settings).stiffness;
        Self { stiffness, kappa, impedance, root, force_to_wave, light_ticks, least, step }
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
        let mut share = Share { wanted, ticks, far: S::ONE, agreed: wanted, own: wanted, ..Share::default() };
        self.take(&mut share, wanted);
        share
    }

    /// Takes in what the other end says: by how much its ρ would be below 1, and 1 more where it hears nothing.
    #[inline(never)]
    pub(super) fn hear(&self, share: &mut Share<S>, told: S) {
        let less = if told >= S::ONE { told - S::ONE } else { told };
        share.far = (S::ONE - less).max(self.least).min(S::ONE);
        share.agreed = share.wanted.min(share.far);
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
            share.agreed = share.wanted.min(share.far);
        }
        if share.own != share.agreed {
            share.own = share.own + (share.agreed - share.own).limit(self.step);
        }
        share.own
    }

    /// Goes over to the ρ that was paid for.
    #[inline]
    fn take(&self, share: &mut Share<S>, paid: S) {
        if paid != share.paid {
            share.paid = paid;
            share.inverse_sum = S::ONE.over(paid * self.impedance + self.kappa);
            share.force_to_wave = self.force_to_wave.over(paid);
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

    /// Outgoing wave u_out, √W, of what the force on the copy was: what one end pushes with, to the last bit, is what the other one is told.
    #[inline]
    pub(super) fn wave_out(share: &Share<S>, wave_in: S, force: S) -> S {
        wave_in - share.force_to_wave * force
    }
}
