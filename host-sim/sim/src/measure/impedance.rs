//! The impedance that a hand feels: force over speed, frequency by frequency, of two peers as they run.
//!
//! The device of peer 1 is led along x = A·(1 − cos ωt), at the same largest speed A·ω for every frequency; what its motor is
//! commanded meanwhile is projected on that speed over whole periods and whole packets. With the device's own mass and damping and with H,
//! by which a motor that holds each force for a control period, τ ticks late, answers,
//!
//! ```text
//! Z(jω) = m·jω + b + H(jω)·F/v,   H = e^(−jωT_c·(τ + ½))·sin(ωT_c/2)/(ωT_c/2).
//! ```
//!
//! The far hand holds its device still, or has let go of it: between these two lies what the object and whatever is done
//! to it can be felt as (the Z-width of Colgate & Brown 1994, of a link instead of a wall). The network is the scene's at constant delay
//! ([`Scene::linear`]), but laws are as they are: of one that is not linear this is the describing function at that speed.
//!
//! **Passive** at a frequency is an impedance whose real part is not negative: there the hand can take out no energy that it did not put
//! in. Units: Hz, N·s/m. Left out: what the answer holds at other frequencies than the hand's.

use haptic_core::device::{AXES, Reading};
use haptic_core::num::Motion;
use haptic_core::peer::{Actuators, Sensors};
use haptic_core::settings::Refused;

use crate::pair::{Device, Pair, Side};
use crate::scene::Scene;

/// Largest speed of the hand, m/s.
pub const SPEED_M_PER_S: f64 = 0.02;

/// Lowest and highest frequency, Hz; the highest as far as the control rate has five ticks a period.
pub const BAND_HZ: [f64; 2] = [0.5, 200.0];

/// Frequencies.
const POINTS: usize = 28;
/// Time for what the start leaves to die away, s.
const SETTLE_S: f64 = 20.0;
/// Shortest time of a projection, s.
const WINDOW_S: f64 = 1.0;
/// By how much of itself an answer may differ from one projection to the next.
const REPEATS: f64 = 0.02;

/// What the other user does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Far {
    /// Holds the device where it is.
    Held,
    /// Has let go: no contact at peer 2.
    LetGo,
}

/// A number of two parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Complex {
    /// Part in phase with the speed.
    pub re: f64,
    /// Part a quarter of a period before it.
    pub im: f64,
}

impl Complex {
    /// Size.
    pub fn abs(self) -> f64 {
        self.re.hypot(self.im)
    }

    /// Phase, rad.
    pub fn phase(self) -> f64 {
        self.im.atan2(self.re)
    }

    fn times(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

/// The frequencies at which the impedance of a scene is measured: those whose periods are whole control periods, about evenly spaced by
/// their logarithm, without those that packets only ever meet at one or two phases.
pub fn frequencies_hz(scene: &Scene) -> Vec<f64> {
    let timing = &scene.peer.timing;
    let [low, high] = BAND_HZ;
    let high = high.min(0.2 / timing.control_period_s);
    let at = |point: usize| low * (high / low).powf(point as f64 / (POINTS - 1) as f64);
    let mut found: Vec<u32> = (0..POINTS)
        .map(|point| {
            let ticks = (1.0 / (at(point) * timing.control_period_s)).round() as u32;
            if (2 * timing.ticks_per_packet).is_multiple_of(ticks) { ticks + 1 } else { ticks }
        })
        .collect();
    found.dedup();
    found.into_iter().map(|ticks| 1.0 / (f64::from(ticks) * timing.control_period_s)).collect()
}

/// A hand that leads its device, whatever the motor does, and what the motor did.
#[derive(Clone, Copy, Debug)]
struct Hand {
    angle_per_tick: f64,
    amplitude_m: f64,
    speed_m_per_s: f64,
    tick: u64,
    /// Resisting force, projected: what goes with the cosine and with the sine.
    sums: [f64; 2],
}

impl Hand {
    fn angle(&self) -> f64 {
        self.angle_per_tick * self.tick as f64
    }
}

impl Device<f64> for Hand {
    fn sensors(&self) -> Sensors<f64> {
        let (sine, cosine) = libm::sincos(self.angle());
        let mut axes = [Motion::REST; AXES];
        axes[0] = Motion { position: self.amplitude_m * (1.0 - cosine), velocity: self.speed_m_per_s * sine };
        Sensors::of(Reading::Exact(axes))
    }

    fn step(&mut self, _: f64, actuators: &Actuators<f64>) {
        let (sine, cosine) = libm::sincos(self.angle());
        self.sums[0] -= actuators.forces[0] * cosine;
        self.sums[1] -= actuators.forces[0] * sine;
        self.tick += 1;
    }
}

/// What a hand that moves at `frequency_hz` with up to `speed_m_per_s` feels; none where a peer stopped or the answer does not repeat.
///
/// # Errors
/// Settings that no peer accepts.
pub fn felt(
    scene: &Scene,
    far: Far,
    frequency_hz: f64,
    speed_m_per_s: f64,
) -> Result<Option<Complex>, Refused<'static>> {
    let linear = scene.linear();
    let (timing, device) = (&linear.peer.timing, &linear.world.device);
    let period_s = timing.control_period_s;
    let ticks = (1.0 / (frequency_hz * period_s)).round().max(2.0);
    let angle_per_tick = core::f64::consts::TAU / ticks;
    let omega = angle_per_tick / period_s;
    let hand = |speed_m_per_s: f64| {
        let amplitude_m = speed_m_per_s / omega;
        Hand { angle_per_tick, amplitude_m, speed_m_per_s, tick: 0, sums: [0.0; 2] }
    };
    let side = |index: usize| {
        let mut settings = linear.peers()[index];
        if index == 1 && far == Far::LetGo {
            (settings.contact.stiffness_n_per_m, settings.contact.damping_n_s_per_m) = (0.0, 0.0);
        }
        let peer = linear.laws.peer(&settings, [Motion::REST; AXES])?;
        Ok(Side::of(&linear, peer, hand(if index == 0 { speed_m_per_s } else { 0.0 }), 1 - index))
    };
    let mut pair = Pair::of(&linear, [side(0)?, side(1)?]);
    // Whole periods, at least two, that are whole packets: M of them always are.
    let packet = u64::from(timing.ticks_per_packet);
    let ticks = ticks as u64;
    let least = (2 * ticks).max((WINDOW_S / period_s).round() as u64);
    let window = (1..=packet).map(|periods| periods * ticks).find(|window| window % packet == 0).unwrap_or(ticks);
    let window = window * least.div_ceil(window);
    // The hand's angle counts from 0, so that the time to settle is whole periods too.
    let settle = ticks * ((SETTLE_S / period_s) as u64).max(6 * ticks).div_ceil(ticks);
    (0..settle).for_each(|_| pair.step());
    let [first, second] = [(); 2].map(|()| {
        pair.sides_mut().for_each(|side| side.plant.sums = [0.0; 2]);
        (0..window).for_each(|_| pair.step());
        let [cosine, sine] = pair.sides()[0].plant.sums.map(|sum| 2.0 * sum / window as f64 / speed_m_per_s);
        Complex { re: sine, im: cosine }
    });
    let change = Complex { re: second.re - first.re, im: second.im - first.im }.abs();
    let own = Complex { re: device.damping_n_s_per_m, im: device.mass_kg * omega };
    let repeats = change <= REPEATS * (second.abs() + own.abs());
    if pair.fault().is_some() || !repeats {
        return Ok(None);
    }
    let half = 0.5 * omega * period_s;
    let late = -omega * period_s * (device.force_delay_ticks + 0.5);
    let hold = Complex { re: late.cos(), im: late.sin() };
    let rendered = hold.times(second);
    let share = half.sin() / half;
    Ok(Some(Complex { re: own.re + share * rendered.re, im: own.im + share * rendered.im }))
}

#[cfg(test)]
#[path = "../../tests/inside/measure_impedance.rs"]
mod tests;
