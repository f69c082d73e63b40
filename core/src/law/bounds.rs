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
//! N lines of b that meet send 2/N·Σu − u_i back into each, at most 3·U: a peer accepts that
//! much, since its other end may be a hub ([`Bounds::beyond_a_junction`]); a hub accepts U.
//!
//! A law says which of these are its own ([`super::Law::bounds`]). Where the impedance of its line falls to ρ·b its waves keep the unit of b,
//! and a pull of F is one of F/ρ in them: it is bounded with the least ρ that an end goes to, U = (b·V + F/ρ₀)/√(2b)
//! ([`Bounds::of_lighter_waves`]). With a quarter, in `any-network`, whoever lies pushes with 760 N instead of 640 at the most, before the
//! limits of whoever is pushed.
//!
//! Sums without a stated number of ticks are bounded as if over [`MOST_TICKS`], so that the difference of two stays within the
//! range of numbers. What a law of motion sends beside the motion has a unit of its own, and need only be finite.
//!
//! **Limits**: a hand at V or F, or a spring that is released, moves a light copy faster for a moment; a peer at its own limits is
//! about to be stopped by them ([`crate::safety`]), and is disconnected if its copy was faster. Tick counters wrap after 49 days.

use super::Packet;
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
    /// Twice the workspace: from its one end to the other, m; or what the law tells as a place.
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
    /// Bounds on the packets of an end with the limits of these settings that sends motion, and for a wave any number.
    pub fn of_motion(settings: &Settings) -> Self {
        Self { wave: f64::MAX, ..Self::of_waves(settings) }
    }

    /// The same for an end that sends waves.
    pub fn of_waves(settings: &Settings) -> Self {
        Self::of_lighter_waves(settings, 1.0)
    }

    /// The same where the impedance of the line may fall to this share of b.
    #[inline(never)]
    pub fn of_lighter_waves(settings: &Settings, share: f64) -> Self {
        let (world, impedance) = (settings.in_the_world(), settings.coordination.wave_impedance_n_s_per_m);
        let safety = &world.safety;
        let (speed_m_per_s, period_s) = (fastest_m_per_s(&world), settings.timing.control_period_s);
        let wave = (impedance * speed_m_per_s + safety.max_force_n / share) / libm::sqrt(2.0 * impedance);
        Self {
            place_m: 2.0 * safety.workspace_m,
            speed_m_per_s,
            wave,
            integral_per_tick: period_s * wave,
            energy_per_tick_j: 0.5 * period_s * wave * wave,
            counts: false,
            brings_past: false,
        }
    }

    /// The same for packets that say over how many ticks their sums are; those of the first are over any, unless it `brings_past`.
    #[must_use]
    pub fn counting(self, brings_past: bool) -> Self {
        Self { counts: true, brings_past, ..self }
    }

    /// The same for packets whose place is within `place_m` (m), and that have `wave` at least in the place of a wave.
    #[must_use]
    pub fn with(self, place_m: f64, wave: f64) -> Self {
        Self { place_m, wave: self.wave.max(wave), ..self }
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

    /// Whether packets say over how many ticks their sums are, so that the newest makes up for every lost one.
    pub fn counts(&self) -> bool {
        self.counts
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
