//! Bounds on the numbers in a received packet, from the physical limits of its sender; checked once, on reception.
//!
//! An authentic packet may still contain any numbers. Only those are accepted that the scene's limits allow. With V =
//! [`fastest_m_per_s`], F = `safety.max_force_n` and b = `coordination.wave_impedance_n_s_per_m`, an end of a
//! line that moves no faster than V and pulls no harder than F sends waves of
//!
//! > |u_out| = |b·ẋ_d − F_T|/√(2b) ≤ (b·V + F)/√(2b) = U
//!
//! and over n ticks changes their integral by at most n·T_c·U, whatever was lost in between: a tick that stands adds nothing.
//! So every mean that a receiver forms of them is at most U, and moves a free end at no more than √(2/b)·U = V + F/b.
//!
//! N lines of b that meet send 2/N·Σu − u_i back into each (see [`super::node`]), at most 3·U: a peer accepts that
//! much, since its other end may be a hub ([`Bounds::beyond_a_junction`]); a hub accepts U.
//!
//! A line of [`Sends::Counters`] sends its slip and how fast it goes on beside them ([`super::self_timed`]), and for a wave by how much
//! less its impedance should be, or 2 less that where it hears nothing, and how many samples it had left. It keeps the bound on its sums
//! whatever moves it: what is more it tells later. Where its impedance falls to ρ·b its waves keep the unit of b, and a pull of F is one
//! of F/ρ in them: such a line is bounded with the least ρ that an end goes to, a quarter: U = (b·V + F/ρ₀)/√(2b). Whoever lies pushes
//! with 760 N instead of 640 at the most, in `any-network`, before the limits of whoever is pushed.
//!
//! Sums without a stated number of ticks are bounded as if over [`MOST_TICKS`], so that the difference of two stays within the
//! range of numbers. What a law of [`Sends::Motion`] sends beside the motion has a unit of its own, and need only be finite.
//!
//! **Limits**: a hand at V or F, or a spring that is released, moves a light copy faster for a moment; a peer at its own limits is
//! about to be stopped by them ([`crate::safety`]), and is disconnected if its copy was faster. Tick counters wrap after 49 days.

use super::self_timed::{MOST_TOLD_M, least_share, most_told};
use super::{Packet, Sends};
use crate::num::Scalar;
use crate::safety::fastest_m_per_s;
use crate::settings::Settings;

/// Largest number of ticks that a sum may cover, 2³², after which its counter wraps: 49 days at 1 kHz.
pub const MOST_TICKS: f64 = 4_294_967_296.0;

/// Share of a bound that a law says which would say more.
pub(super) const WITHIN: f64 = 0.999;

/// Factor by which several lines that meet may raise the speed and the wave of one.
const JUNCTION: f64 = 3.0;

/// Bounds on the numbers in a packet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Twice the workspace: from its one end to the other, m; or the largest slip that a line with a time of its own tells.
    place_m: f64,
    speed_m_per_s: f64,
    /// U, √W, or any number.
    wave: f64,
    /// U·T_c, √W·s.
    pub(super) integral_per_tick: f64,
    /// ½·T_c·U², J.
    energy_per_tick_j: f64,
    /// Ticks that the integral is over are in the packet.
    counts: bool,
    /// The sums of the first packet count from nothing.
    brings_past: bool,
}

/// Sums in the newest packet that the other end has sent since it started.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    ticks: u32,
    integral: f64,
}

impl Bounds {
    /// Bounds on the packets of an end with the limits of these settings, whose law sends `sends`.
    pub fn build(settings: &Settings, sends: Sends) -> Self {
        let (world, impedance) = (settings.in_the_world(), settings.coordination.wave_impedance_n_s_per_m);
        let safety = &world.safety;
        let (speed_m_per_s, period_s) = (fastest_m_per_s(&world), settings.timing.control_period_s);
        // What a newton is in the waves of a line that may be lighter than b.
        let share = if sends == Sends::Counters { least_share(settings) } else { 1.0 };
        let wave = (impedance * speed_m_per_s + safety.max_force_n / share) / libm::sqrt(2.0 * impedance);
        Self {
            place_m: if sends == Sends::Counters { MOST_TOLD_M } else { 2.0 * safety.workspace_m },
            speed_m_per_s,
            wave: match sends {
                Sends::Motion => f64::MAX,
                // No wave, but what an end says of itself ([`super::self_timed`]).
                Sends::Counters => wave.max(most_told(settings)),
                _ => wave,
            },
            integral_per_tick: period_s * wave,
            energy_per_tick_j: 0.5 * period_s * wave * wave,
            counts: matches!(sends, Sends::Counters | Sends::Integrals),
            brings_past: sends == Sends::Integrals,
        }
    }

    /// The same bounds for an end at which several such lines may meet (a hub): three times the speeds and waves.
    pub fn beyond_a_junction(self) -> Self {
        Self {
            speed_m_per_s: JUNCTION * self.speed_m_per_s,
            wave: (JUNCTION * self.wave).min(f64::MAX),
            integral_per_tick: JUNCTION * self.integral_per_tick,
            energy_per_tick_j: JUNCTION * JUNCTION * self.energy_per_tick_j,
            ..self
        }
    }

    /// Largest wave U that is accepted, √W; the largest number where a law sends motion alone.
    pub fn wave(&self) -> f64 {
        self.wave
    }

    /// Checks a packet against these bounds and the sums in `newest`, which a newer packet then replaces by its own.
    ///
    /// # Errors
    /// The name of the number that is out of bounds; `newest` is then unchanged.
    pub fn take<S: Scalar>(&self, newest: &mut Option<Sums>, packet: &Packet<S>) -> Result<(), &'static str> {
        let (integral, energy_j) = (packet.wave_integral.to_f64(), packet.energy_j.to_f64());
        // No number is within no bound.
        for (name, value, most) in [
            ("position", packet.motion.position.to_f64(), self.place_m),
            ("velocity", packet.motion.velocity.to_f64(), self.speed_m_per_s),
            ("wave", packet.wave.to_f64(), self.wave),
            ("wave_integral", integral, MOST_TICKS * self.integral_per_tick),
            ("energy_sent", energy_j, MOST_TICKS * self.energy_per_tick_j),
        ] {
            if !(-most..=most).contains(&value) {
                return Err(name);
            }
        }
        let now = Sums { ticks: packet.live_ticks, integral };
        // The first sums of a life are over any ticks, unless the law takes them as begun with it.
        if let Some(before) = newest.or(self.brings_past.then(Sums::default)).filter(|_| self.counts) {
            let ticks = now.ticks.wrapping_sub(before.ticks).cast_signed();
            if newest.is_some() && ticks <= 0 {
                // Old, and nothing to the law.
                return Ok(());
            }
            let rounding = f64::EPSILON * (now.integral.abs() + before.integral.abs());
            let most = f64::from(ticks) * self.integral_per_tick + rounding;
            if ticks > 0 && (now.integral - before.integral).abs() > most {
                return Err("wave_integral");
            }
        }
        *newest = Some(now);
        Ok(())
    }
}
