//! How heavy the line is, and its end: an impedance that falls where the line is long (THEORY §11).
//!
//! Both ends of a line together move as a mass b·T does, T its delay each way. With `coordination.most_line_mass_kg` = m an end whose
//! line is d₀ ticks long is one of ρ·b,
//!
//! > ρ = min(1, m/(b·d₀·T_c)), and no less than [`LEAST`]
//!
//! in steps of 1/[`STEPS`]. Each end tells the other one what it would have, and goes to the lesser of both by a step a millisecond. Waves keep the
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
use crate::law::terminal::TerminalState;
use crate::num::Scalar;
use crate::object::{Port, Solve};
use crate::settings::{Key, Settings};

pub(super) const MASS: Key = Key::number("coordination.most_line_mass_kg", 4.0, [0.0, 1000.0], "kg")
    .means("Self-timed line: what the line between both hands may weigh, b·T; where it is long, b falls for that; 0 leaves b as it is.");

/// The least ρ that an end goes to: a line that would still be heavier is.
const LEAST: f64 = 0.25;
/// Steps of ρ from nothing to 1, of which it changes by one in a millisecond. Every number type has them exactly.
const STEPS: i32 = 1024;
const STEP: f64 = 1.0 / STEPS as f64;
/// The longest line that is told from longer ones, ticks: 17 minutes at 1 kHz.
const MOST_TICKS: i32 = 1 << 20;

/// ρ₀, below which no end emits: a step less than it would ever go to; 1 where b stays what it is.
pub(super) fn least(settings: &Settings) -> f64 {
    if settings.own(&MASS) > 0.0 { LEAST - STEP } else { 1.0 }
}

/// What is left of b, N·s/m, of a line of `line_s` seconds each way.
pub(super) fn impedance(settings: &Settings, line_s: f64) -> f64 {
    let (whole, most_kg) = (settings.coordination.wave_impedance_n_s_per_m, settings.own(&MASS));
    if most_kg > 0.0 { (most_kg / line_s).min(whole).max(LEAST * whole) } else { whole }
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
    /// m/(b·T_c) in steps: the ticks up to which ρ is 1, times [`STEPS`]; as many as there are where it always is.
    light: i32,
    least: S,
    /// By how much ρ changes in a tick at most.
    step: S,
}

configured!([S: Scalar] End<S> { stiffness, kappa, impedance, root, force_to_wave, light, least, step });

/// ρ of an end. No number here is asked which of two it is: a tick has one way through it, whatever the lines weigh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Share<S> {
    /// What it would have with a line of so many ticks.
    wanted: S,
    ticks: i32,
    /// What the other end would have.
    far: S,
    /// Its own, which goes to the lesser of both.
    own: S,
}

/// What came of a live tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scattered<S> {
    pub(super) terminal: TerminalState<S>,
    /// u_out, √W: what one end pushes with, to the last bit, is what the other one is told.
    pub(super) wave_out: S,
}

impl<S: Scalar> End<S> {
    /// A line whose spring has the impedance `kappa`, N·s/m.
    pub(super) fn build(settings: &Settings, kappa: f64) -> Self {
        let impedance = settings.coordination.wave_impedance_n_s_per_m;
        let most_kg = settings.own(&MASS);
        let light = if most_kg > 0.0 { most_kg / (impedance * settings.timing.control_period_s) } else { f64::MAX };
        let least = if most_kg > 0.0 { LEAST } else { 1.0 };
        let root = libm::sqrt(2.0 * impedance);
        let step = STEP * (settings.timing.control_period_s / 0.001);
        let numbers = [kappa, impedance, root, 2.0 / root, least, step];
        let [kappa, impedance, root, force_to_wave, least, step] = numbers.map(S::from_f64);
        let stiffness = Spring::build(settings).stiffness;
        // A cast saturates.
        let light = (f64::from(STEPS) * light).min(f64::from(i32::MAX - MOST_TICKS)) as i32;
        Self { stiffness, kappa, impedance, root, force_to_wave, light, least, step }
    }

    /// ρ of a line so many ticks long.
    #[inline(never)]
    fn wanted(&self, ticks: i32) -> S {
        let ticks = ticks.clamp(1, MOST_TICKS);
        let steps = (self.light + ticks / 2) / ticks;
        (S::from_i32(steps.min(STEPS)) * S::from_f64(STEP)).max(self.least)
    }

    /// An end of a line that begins, so many ticks long.
    pub(super) fn start(&self, ticks: i32) -> Share<S> {
        let wanted = self.wanted(ticks);
        Share { wanted, ticks, far: S::ONE, own: wanted }
    }

    /// What a packet says of this end: by how much the ρ that it would have is below 1; and where nothing reaches it, that much less than 2.
    pub(super) fn packet_field(&self, share: &Share<S>, is_cut_off: bool) -> S {
        let less = S::ONE - share.wanted;
        if is_cut_off { S::ONE + S::ONE - less } else { less }
    }

    /// Takes in what the other end says.
    #[inline]
    pub(super) fn receive(&self, share: &mut Share<S>, told: S) {
        share.far = (S::ONE - told.min(S::ONE + S::ONE - told)).max(self.least).min(S::ONE);
    }

    /// ρ that this end would have in this tick, of a line so many ticks long.
    #[inline]
    pub(super) fn impedance_share(&self, share: &mut Share<S>, ticks: i32) -> S {
        if ticks != share.ticks {
            (share.ticks, share.wanted) = (ticks, self.wanted(ticks));
        }
        let agreed = share.wanted.min(share.far);
        share.own = share.own + (agreed - share.own).limit(self.step);
        share.own
    }

    /// What the spring pulls with from this stretch (m) while nothing moves, N.
    #[inline]
    pub(super) fn spring_force(&self, stretch: S) -> S {
        self.stiffness * stretch
    }

    /// How much faster the line goes where a wave comes in that is so much more, √W, at ρ = 1 and the same force, m/s.
    #[inline]
    pub(super) fn velocity_step(&self, more: S) -> S {
        self.force_to_wave * more
    }

    /// How fast the line goes, m/s, with a wave coming in, √W, that is paid for at this ρ, while its spring pulls with this force, N.
    #[inline]
    pub(super) fn unloaded_velocity(&self, [wave_in, share]: [S; 2], force: S) -> S {
        (self.root * wave_in - force.over(share)).over(self.impedance)
    }

    /// A tick with a wave coming in, √W, which is paid for at this ρ, and in which the spring begins with this pull, N.
    #[inline]
    pub(super) fn scatter(&self, pull: S, [wave_in, share]: [S; 2], solve: impl Solve<S>) -> Scattered<S> {
        let impedance = share * self.impedance;
        let inverse_sum = S::ONE.over(impedance + self.kappa);
        // ρ·b·w = drive − κ·(w − v): what is left of the wave's push once the spring has taken its part.
        let drive = share * self.root * wave_in - pull;
        let part = self.kappa * inverse_sum;
        let port = Port::new(pull + part * drive, impedance * part);
        let mean = solve.velocity(port);
        let velocity = (drive + self.kappa * mean) * inverse_sum;
        let force = port.at(mean);
        Scattered {
            terminal: TerminalState { velocity, copy: mean, force },
            wave_out: wave_in - self.force_to_wave.over(share) * force,
        }
    }
}
