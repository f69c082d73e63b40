//! What a hand alone feels of the shared object as the scene has it: the impedance of its device with the other hand off.
//!
//! The device of peer 1 is led along x = A·(1 − cos ωt) with up to [`SPEED_M_PER_S`], and what its motor is commanded is projected on that speed, as
//! in [`super::impedance`]. There a scene is made linear first, its budgets of energy without end; here it is run as it is, network, limits, tanks
//! and all, for what a law that spends energy lets a hand feel depends on what it has. So no answer need repeat: it is the mean of a window of whole
//! periods, at least two of them and four seconds. The other device stands, and there is no contact between it and its copy.

use super::impedance::{Complex, Hand, of_device};
use crate::Error;
use crate::pair::Pair;
use crate::scene::Scene;

/// Largest speed of the hand, m/s: that of a hand that moves things about.
pub const SPEED_M_PER_S: f64 = 0.1;
/// Fewest periods of a projection, and its shortest time, s.
const PERIODS: u32 = 2;
const WINDOW_S: f64 = 4.0;
/// Shortest time for what the start leaves to die away, s.
const SETTLE_S: f64 = 4.0;

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
    let devices = [SPEED_M_PER_S, 0.0].map(|speed_m_per_s| Hand::new(angle_per_tick, omega, speed_m_per_s, None));
    let mut pair = Pair::<f64, Hand>::with_devices(&scene, devices)?;
    let whole = |least_s: f64| (ticks as u64) * (least_s / (ticks * period_s)).ceil() as u64;
    (0..whole(SETTLE_S)).for_each(|_| pair.step());
    pair.sides_mut().for_each(|side| side.plant.sums = Default::default());
    let window = whole(WINDOW_S.max(f64::from(PERIODS) / frequency_hz));
    (0..window).for_each(|_| pair.step());
    if pair.fault().is_some() {
        return Ok(None);
    }
    let resists = pair.sides()[0].plant.sums[0] * (2.0 / (window as f64 * SPEED_M_PER_S));
    Ok(Some(of_device(&scene.devices()[0], omega, period_s, resists)))
}
