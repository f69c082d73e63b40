//! What a hand alone feels of the shared object as the scene has it: the impedance of its device with the other hand off.
//!
//! The device of peer 1 is led along x = A·(1 − cos ωt) with up to [`SPEED_M_PER_S`], and what its motor is commanded is projected on that speed, as
//! in [`super::impedance`]. There a scene is made linear first, its budgets of energy without end; here it is run as it is, network, limits, tanks
//! and all, for what a law that spends energy lets a hand feel depends on what it has. So no answer need repeat: it is the mean of a window of whole
//! periods, at least two of them and four seconds. The other device stands, and there is no contact between it and its copy.

use haptic_core::device::{AXES, Reading};
use haptic_core::num::Motion;
use haptic_core::peer::{Actuators, Sensors};

use super::impedance::{Complex, of_device};
use crate::Error;
use crate::device::Device;
use crate::pair::Pair;
use crate::scene::Scene;

/// Largest speed of the hand, m/s: that of a hand that moves things about.
pub const SPEED_M_PER_S: f64 = 0.1;
/// Fewest periods of a projection, and its shortest time, s.
const PERIODS: u32 = 2;
const WINDOW_S: f64 = 4.0;
/// Shortest time for what the start leaves to die away, s.
const SETTLE_S: f64 = 4.0;

/// A device that is where it is led, whatever its motor does.
struct Led {
    angle_per_tick: f64,
    amplitude_m: f64,
    speed_m_per_s: f64,
    tick: u64,
    /// Resisting force, projected on the speed and on a quarter of a period ahead of it.
    sum: Complex,
}

impl Led {
    fn sincos(&self) -> (f64, f64) {
        libm::sincos(self.angle_per_tick * self.tick as f64)
    }
}

impl Device<f64> for Led {
    fn sensors(&self) -> Sensors<f64> {
        let (sine, cosine) = self.sincos();
        let mut axes = [Motion::REST; AXES];
        axes[0] = Motion { position: self.amplitude_m * (1.0 - cosine), velocity: self.speed_m_per_s * sine };
        Sensors::of(Reading::Exact(axes))
    }

    fn step(&mut self, _: f64, actuators: &Actuators<f64>) {
        let (sine, cosine) = self.sincos();
        let resists = -actuators.forces[0];
        self.sum = Complex { re: self.sum.re + resists * sine, im: self.sum.im + resists * cosine };
        self.tick += 1;
    }
}

/// Impedance that the hand at peer 1 feels at this frequency, its device's own included, N·s/m; none where a peer stopped.
///
/// # Errors
/// The first key whose value is out of range or impossible beside the others.
pub fn felt(scene: &Scene, frequency_hz: f64) -> Result<Option<Complex>, Error> {
    let mut scene = scene.clone();
    scene.users = Default::default();
    for key in ["peer.2.contact.stiffness_n_per_m", "peer.2.contact.damping_n_s_per_m"] {
        scene.set_number(key, 0.0)?;
    }
    let period_s = scene.peer.timing.control_period_s;
    let ticks = (1.0 / (frequency_hz * period_s)).round().max(2.0);
    let angle_per_tick = core::f64::consts::TAU / ticks;
    let omega = angle_per_tick / period_s;
    let led = |speed_m_per_s: f64| {
        let amplitude_m = speed_m_per_s / omega;
        Led { angle_per_tick, amplitude_m, speed_m_per_s, tick: 0, sum: Complex::default() }
    };
    let mut pair = Pair::<f64, Led>::with_devices(&scene, [led(SPEED_M_PER_S), led(0.0)])?;
    let whole = |least_s: f64| (ticks as u64) * (least_s / (ticks * period_s)).ceil() as u64;
    (0..whole(SETTLE_S)).for_each(|_| pair.step());
    pair.sides_mut().for_each(|side| side.plant.sum = Complex::default());
    let window = whole(WINDOW_S.max(f64::from(PERIODS) / frequency_hz));
    (0..window).for_each(|_| pair.step());
    if pair.fault().is_some() {
        return Ok(None);
    }
    let over = 2.0 / (window as f64 * SPEED_M_PER_S);
    let Complex { re, im } = pair.sides()[0].plant.sum;
    Ok(Some(of_device(&scene.devices()[0], omega, period_s, Complex { re: over * re, im: over * im })))
}
