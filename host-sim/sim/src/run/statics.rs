//! How far apart two copies are that are pulled apart and rest: what the coordination's springs and the line leave, F·(2/K_T + T/b)
//! (THEORY §4). Copies that are further apart than that have come apart.

use haptic_core::settings::{Sends, Value};

use crate::scene::Scene;

/// Largest true discrepancy of a stable run whatever its springs leave, mm: hands move, and what moves is further apart than what rests.
pub const APART_MM: f64 = 10.0;

/// Copies have come apart where they are this many times as far from each other as statics say, on average, and [`END_FACTOR`] times in the end: the
/// mean way of a jittered packet is longer than its network's own, and hands do not rest but swing.
pub const APART_FACTOR: f64 = 1.5;
/// The same at one instant, which may be that of a swing's end.
pub const END_FACTOR: f64 = 3.0;

/// 2/K_T + T/b (m/N): what a newton between two copies of this scene leaves at rest. A law that sends no waves has no line of
/// impedance b, and no T/b; b of a self-timed line falls where it is long (THEORY §11).
pub fn compliance_m_per_n(scene: &Scene) -> f64 {
    let coordination = &scene.peer.coordination;
    let springs = 2.0 / coordination.stiffness_n_per_m;
    match scene.law().sends {
        Sends::Nothing | Sends::Motion => springs,
        Sends::Waves | Sends::Counters | Sends::Integrals | Sends::WavesAndMotion => {
            springs + line_s(scene) / impedance(scene, coordination.wave_impedance_n_s_per_m)
        }
    }
}

/// What is left of an impedance b, N·s/m, where the line between may weigh only so much: m/T, and no less than a quarter of b.
fn impedance(scene: &Scene, whole: f64) -> f64 {
    match scene.get("coordination.most_line_mass_kg") {
        Some(Value::Number(most_kg)) if most_kg > 0.0 && scene.law().sends == Sends::Counters => {
            (most_kg / line_s(scene)).min(whole).max(whole / 4.0)
        }
        _ => whole,
    }
}

/// Mean length T of a line of waves, s: the network's delay and jitter, a packet's own length, and the samples that a line
/// keeps in store. Lost packets are no length of a line, and excuse nothing.
fn line_s(scene: &Scene) -> f64 {
    let (network, timing) = (&scene.world.network, &scene.peer.timing);
    let packets = f64::from(network.one_way_delay_packets + network.playout_packets) + 1.0;
    let constant_s = network.extra_delay_s + 0.5 * network.asymmetry_s + network.delay_step_s.max(0.0);
    let stored_ticks = match scene.get("coordination.credit_ticks") {
        Some(Value::Number(ticks)) => ticks,
        _ => 0.0,
    };
    packets * timing.packet_period_s() + constant_s + network.jitter_s + stored_ticks * timing.control_period_s
}

/// Whether copies have come apart that are this far from each other on average and in the end (mm), with this mean force between them (N).
pub(super) fn are_apart([mean_mm, end_mm]: [f64; 2], compliance_m_per_n: f64, force_n: f64) -> bool {
    let statics_mm = 1e3 * compliance_m_per_n * force_n.abs();
    // What is no number (no force, and no spring) leaves the first.
    let beyond = |mm: f64, factor: f64| mm > APART_MM.max(factor * statics_mm);
    beyond(mean_mm, APART_FACTOR) || beyond(end_mm, END_FACTOR)
}
