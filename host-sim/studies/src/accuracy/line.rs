//! A self-timed line of a whole peer, against the solution that it converges to as the control period becomes short.
//!
//! The scene `any-network` with a credit of 9 ms in its own time and a network that leaves one sample of it outstanding: the line is a pure
//! delay of 9 ms each way at every control rate. Its pair obeys a delay-differential equation that has no closed form; the reference is the pair itself
//! at [`FINE`] ticks each millisecond in f64 with the midpoint rule, which both integrators must come to.

use cohold_core::object::IntegratorName;
use cohold_core::settings::Refused;
use cohold_sim::Scene;

use super::continuous::Sample;
use super::pair;

/// Delay of the line each way, ms.
const DELAY_MS: u32 = 9;
/// Control rate of the reference, ticks each millisecond.
pub const FINE: u32 = 32;
/// Simulated time, s.
pub const DURATION_S: f64 = 5.0;

/// What moves it, for reports.
pub const MOTION: &str = "Self-timed line: any-network, 9 ms each way, forces without delay, the same pushes; 5 s";

/// The scene at `ticks_per_ms` ticks each millisecond.
pub fn scene(integrator: IntegratorName, ticks_per_ms: u32) -> Scene {
    let ticks = DELAY_MS * ticks_per_ms;
    let mut scene = pair::pushed(pair::any_network(ticks), integrator, ticks_per_ms);
    scene.world.network.one_way_delay_packets = ticks - 1;
    scene
}

/// What it converges to, a sample each millisecond.
///
/// # Errors
/// The first key that is out of range or impossible beside the others.
pub fn converged() -> Result<Vec<Sample>, Refused<'static>> {
    pair::run::<f64>(&scene(IntegratorName::Midpoint, FINE), DURATION_S)
}
