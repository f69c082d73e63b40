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
//! The far hand holds its device still, or has let go of it, or nobody holds that device and the object takes it along: between the
//! extremes lies the range of impedances that can be felt (the Z-width of Colgate & Brown 1994, of a link instead of a wall). The network
//! is the scene's at constant delay ([`Scene::linear`]), either end may be the one that is led ([`answer`]), but laws are as they are: of
//! one that is not linear this is the describing function at that speed.
//!
//! **Passive** at a frequency is an impedance whose real part is not negative: there the hand can take out no energy that it did not put
//! in. Units: Hz, N·s/m. Left out: what the answer holds at other frequencies than the hand's.

use cohold_core::device::{AXES, Reading};
use cohold_core::num::Motion;
use cohold_core::peer::{Actuators, Sensors};
use cohold_core::settings::Refused;

use crate::device::Device;
use crate::pair::{Pair, Side};
use crate::plant::Plant;
use crate::scene::{self, Scene};

/// Largest speed of the hand, m/s.
pub const SPEED_M_PER_S: f64 = 0.02;

/// Lowest and highest frequency, Hz; the highest as far as the control rate has five ticks a period.
pub const BAND_HZ: [f64; 2] = [0.5, 200.0];

/// Number of frequencies in the band.
pub const POINTS: usize = 28;
/// Time for what the start leaves to die away, s.
const SETTLE_S: f64 = 20.0;
/// Shortest time of a projection, s.
const WINDOW_S: f64 = 1.0;
/// By how much of itself an answer may differ from one projection to the next.
const REPEATS: f64 = 0.02;

/// What the user at the far device does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RemoteEnd {
    /// Holds the device where it is.
    Held,
    /// Has let go, and there is no contact between that device and the object.
    LetGo,
    /// Is not there: the object takes the far device along.
    Alone,
}

/// Frequency response of both ends to the motion of a hand, per speed of that hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Answer {
    /// What the hand feels, N·s/m.
    pub impedance: Complex,
    /// Position of the far device over that of the device in the hand, without unit.
    pub motion: Complex,
    /// Force of the far motor on its device, along the hand's motion, per speed of the hand, N·s/m.
    pub pushed: Complex,
}

/// Amplitude and phase of a signal. Real part: in phase with the speed; imaginary part: a quarter of a period ahead of it.
pub type Complex = num_complex::Complex64;

/// The frequencies at which the impedance of a scene is measured: those whose periods are whole control periods, about evenly spaced by
/// their logarithm, without those that packets only ever meet at one or two phases.
pub fn frequencies_hz(scene: &Scene, [low, high]: [f64; 2], points: usize) -> Vec<f64> {
    let timing = &scene.peer.timing;
    let high = high.min(0.2 / timing.control_period_s);
    let at = |point: usize| low * (high / low).powf(point as f64 / (points - 1) as f64);
    let mut found: Vec<u32> = (0..points)
        .map(|point| {
            let ticks = (1.0 / (at(point) * timing.control_period_s)).round() as u32;
            if (2 * timing.ticks_per_packet).is_multiple_of(ticks) { ticks + 1 } else { ticks }
        })
        .collect();
    found.dedup();
    found.into_iter().map(|ticks| 1.0 / (f64::from(ticks) * timing.control_period_s)).collect()
}

/// Motor force for a commanded phasor `force` at `omega` (rad/s), held for a control period `period_s` (s) and delayed
/// as this device's: H·`force`.
pub fn held(device: &scene::Device, omega: f64, period_s: f64, force: Complex) -> Complex {
    let half = 0.5 * omega * period_s;
    let late = -omega * period_s * (device.force_delay_ticks + 0.5);
    let share = half.sin() / half;
    Complex::new(share * late.cos(), share * late.sin()) * force
}

/// Impedance of this device in a hand, N·s/m, with a motor commanded to resist by `resists` (N·s/m) at `omega` (rad/s).
pub fn of_device(device: &scene::Device, omega: f64, period_s: f64, resists: Complex) -> Complex {
    Complex::new(device.damping_n_s_per_m, device.mass_kg * omega) + held(device, omega, period_s, resists)
}

/// A hand that leads its device, whatever the motor does, and what the motor did; or a device that nobody holds.
#[derive(Clone, Debug)]
pub(super) struct Hand {
    angle_per_tick: f64,
    amplitude_m: f64,
    speed_m_per_s: f64,
    tick: u64,
    /// The device that nobody holds.
    alone: Option<Plant>,
    /// Resisting force, and position, projected: what goes with the sine, and with the cosine.
    pub(super) sums: [Complex; 2],
}

impl Hand {
    /// Moves at `omega` (rad/s) with up to this speed.
    pub(super) fn new(angle_per_tick: f64, omega: f64, speed_m_per_s: f64, alone: Option<Plant>) -> Self {
        let amplitude_m = speed_m_per_s / omega;
        Self { angle_per_tick, amplitude_m, speed_m_per_s, tick: 0, alone, sums: [Complex::default(); 2] }
    }

    fn angle(&self) -> f64 {
        self.angle_per_tick * self.tick as f64
    }
}

impl Device<f64> for Hand {
    fn sensors(&self) -> Sensors<f64> {
        if let Some(plant) = &self.alone {
            return plant.sensors();
        }
        let (sine, cosine) = libm::sincos(self.angle());
        let mut axes = [Motion::REST; AXES];
        axes[0] = Motion::new(self.amplitude_m * (1.0 - cosine), self.speed_m_per_s * sine);
        Sensors::of(Reading::Exact(axes))
    }

    fn step(&mut self, time_s: f64, actuators: &Actuators<f64>) {
        let (sine, cosine) = libm::sincos(self.angle());
        let position_m = self.alone.as_ref().map_or(0.0, |plant| plant.motions()[0].position);
        for (sum, number) in self.sums.iter_mut().zip([-actuators.forces[0], position_m]) {
            *sum += Complex::new(number * sine, number * cosine);
        }
        if let Some(plant) = &mut self.alone {
            plant.step(time_s, actuators);
        }
        self.tick += 1;
    }
}

/// Impedance (N·s/m) that a hand at peer 1 feels which moves at `frequency_hz` with up to `speed_m_per_s`; none where a
/// peer stopped or the answer does not repeat.
///
/// # Errors
/// The first key whose value is out of range or impossible beside the others.
pub fn felt(
    scene: &Scene,
    far: RemoteEnd,
    frequency_hz: f64,
    speed_m_per_s: f64,
) -> Result<Option<Complex>, Refused<'static>> {
    Ok(answer(scene, 0, far, frequency_hz, speed_m_per_s)?.map(|answer| answer.impedance))
}

/// Response of both ends to a hand at end `near` (0 or 1) that moves as in [`felt`]; none where [`felt`] gives none.
///
/// # Errors
/// The first key whose value is out of range or impossible beside the others.
pub fn answer(
    scene: &Scene,
    near: usize,
    far: RemoteEnd,
    frequency_hz: f64,
    speed_m_per_s: f64,
) -> Result<Option<Answer>, Refused<'static>> {
    let mut linear = scene.linear();
    // Hands are what is said here, and no others.
    linear.users = Default::default();
    let (timing, devices) = (&linear.peer.timing, linear.devices());
    let period_s = timing.control_period_s;
    let ticks = (1.0 / (frequency_hz * period_s)).round().max(2.0);
    let angle_per_tick = core::f64::consts::TAU / ticks;
    let omega = angle_per_tick / period_s;
    let side = |index: usize| {
        let mut settings = linear.peers()[index];
        if index != near && far == RemoteEnd::LetGo {
            (settings.contact.stiffness_n_per_m, settings.contact.damping_n_s_per_m) = (0.0, 0.0);
        }
        let peer = linear.laws.peer::<f64, 1, AXES>(&settings, [Motion::REST; AXES])?;
        let alone = (index != near && far == RemoteEnd::Alone).then(|| Plant::new(&linear, index));
        let speed_m_per_s = if index == near { speed_m_per_s } else { 0.0 };
        Ok(Side::of(&linear, peer, Hand::new(angle_per_tick, omega, speed_m_per_s, alone), 1 - index))
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
        pair.sides_mut().for_each(|side| side.plant.sums = [Complex::default(); 2]);
        (0..window).for_each(|_| pair.step());
        let over = 2.0 / (window as f64 * speed_m_per_s);
        pair.sides().map(|side| side.plant.sums.map(|sum| sum * over))
    });
    let ([resists, _], [pulls, moves]) = (second[near], second[1 - near]);
    let change = (resists - first[near][0]).norm();
    let own = of_device(&devices[near], omega, period_s, Complex::default());
    let repeats = change <= REPEATS * (resists.norm() + own.norm());
    if pair.fault().is_some() || !repeats {
        return Ok(None);
    }
    Ok(Some(Answer {
        impedance: of_device(&devices[near], omega, period_s, resists),
        motion: moves * Complex::new(0.0, omega),
        pushed: held(&devices[1 - near], omega, period_s, -pulls),
    }))
}
