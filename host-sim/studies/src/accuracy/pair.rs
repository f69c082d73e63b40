//! Runs of the coupled pair, sampled each millisecond, and how far two of them are apart.
//!
//! The motion of all of them is the one of the cooperation paper's §5.1: each user pushes 0.1 N toward the other, and user
//! 1 adds 1 N for 25 ms every 2.5 s. Passive wave, one packet of 8 ms one way. Forces act without delay, so that there is
//! a continuous limit to be near to; K_T is 1590 N/m, where both decodes are stable.

use cohold_core::{law::wave::Decode, object::IntegratorName, settings::Refused};
use cohold_sim::peers::Number;
use cohold_sim::{Laws, pair::Pair, scene::Scene, scenes};
use std::path::Path;

use super::continuous::{SAMPLE_S, Sample};
use super::{largest, rms};

/// Simulated time of a run, s.
pub const DURATION_S: f64 = 10.0;

/// The motion of the pair, for reports.
pub const MOTION: &str = "Coupled pair, passive wave, K_T 1590 N/m, 8 ms packets, one packet of delay, forces without \
                          delay. §5.1: both push 0.1 N, user 1 adds 1 N for 25 ms every 2.5 s; 10 s";

/// The scene with these choices, at `ticks_per_ms` (a power of two) ticks each millisecond.
pub fn scene(integrator: IntegratorName, decode: Decode, ticks_per_ms: u32) -> Scene {
    let mut scene = pushed(Scene::default(), integrator, ticks_per_ms);
    scene.peer.timing.ticks_per_packet = 8 * ticks_per_ms;
    scene.peer.object.force_delay_ticks = 0.0;
    scene.peer.coordination.decode = decode;
    scene.peer.coordination.stiffness_n_per_m = 1590.0;
    scene
}

/// This scene with this integrator and so many ticks each millisecond, forces of the device without delay, and the pushes of §5.1.
pub(super) fn pushed(mut scene: Scene, integrator: IntegratorName, ticks_per_ms: u32) -> Scene {
    scene.peer.timing.control_period_s = SAMPLE_S / f64::from(ticks_per_ms);
    scene.peer.object.integrator = integrator;
    scene.world.device.force_delay_ticks = 0.0;
    for user in &mut scene.users {
        user.settings.user.push_n = 0.1;
    }
    scene.users[0].settings.user.pulse_n = 1.0;
    scene
}

/// The scene `any-network` with a self-timed line of so many ticks of its own time.
pub(super) fn any_network(credit_ticks: u32) -> Scene {
    let set = [format!("coordination.credit_ticks={credit_ticks}")];
    scenes::find(Laws::built_in(), Some(Path::new("any-network")), &set).expect("a built-in scene")
}

/// Runs a scene in `S`; one sample each millisecond.
///
/// # Errors
/// The first key that is out of range or impossible beside the others.
pub fn run<S: Number>(scene: &Scene, duration_s: f64) -> Result<Vec<Sample>, Refused<'static>> {
    let ticks_per_sample = (SAMPLE_S / scene.peer.timing.control_period_s).round() as usize;
    let mut pair = Pair::<S>::new(scene)?;
    let samples = (duration_s / SAMPLE_S).round() as usize;
    let sample = |_| {
        pair.step();
        let seen = pair.sides().map(|side| *side.peer.observed()[0]);
        (1..ticks_per_sample).for_each(|_| pair.step());
        Sample {
            objects_m: seen.map(|seen| seen.object.position.to_f64()),
            forces_n: seen.map(|seen| seen.coordination_force.to_f64()),
        }
    };
    Ok((0..samples).map(sample).collect())
}

/// How far a run is from its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Difference of the copies' positions, root mean square, m.
    pub position_rms_m: f64,
    /// Difference of the coordination forces, root mean square, N.
    pub force_rms_n: f64,
    /// Difference of the copies' positions, largest, m.
    pub position_largest_m: f64,
    /// Difference of the coordination forces, largest, N.
    pub force_largest_n: f64,
}

/// Compares two runs, sample by sample and peer by peer.
pub fn deviation(run: &[Sample], reference: &[Sample]) -> Deviation {
    let over = |part: fn(&Sample) -> [f64; 2]| {
        run.iter().zip(reference).flat_map(move |(a, b)| {
            let (a, b) = (part(a), part(b));
            [a[0] - b[0], a[1] - b[1]]
        })
    };
    let (positions, forces) = (over(|sample| sample.objects_m), over(|sample| sample.forces_n));
    Deviation {
        position_rms_m: rms(positions.clone()),
        force_rms_n: rms(forces.clone()),
        position_largest_m: largest(positions),
        force_largest_n: largest(forces),
    }
}
