//! How far apart two copies are that are pulled apart and rest: what the coordination's springs and the line leave, F·(2/K_T + T/b)
//! (THEORY §4). Copies that are further apart than that have come apart.

use crate::scene::Scene;

/// Largest true discrepancy of a stable run whatever its springs leave, mm: hands move, and what moves is further apart than what rests.
pub const APART_MM: f64 = 10.0;

/// Copies have come apart where they are this many times as far from each other as statics say, on average, and [`END_FACTOR`] times in the end: the
/// mean way of a jittered packet is longer than its network's own, and hands do not rest but swing.
pub const APART_FACTOR: f64 = 1.5;
/// The same at one instant, which may be that of a swing's end.
pub const END_FACTOR: f64 = 3.0;

/// What a newton between two copies of this scene leaves at rest at the most, m/N ([`cohold_core::law::Law::compliance`]).
pub fn compliance_m_per_n(scene: &Scene) -> f64 {
    scene.laws.compliance(&scene.peer, delay_s(scene))[1]
}

/// Mean time that a wave takes, s: the network's delay and jitter, and a packet's own length. Lost packets are no length of a line, and
/// excuse nothing.
fn delay_s(scene: &Scene) -> f64 {
    let (network, timing) = (&scene.world.network, &scene.peer.timing);
    let packets = f64::from(network.one_way_delay_packets + network.playout_packets) + 1.0;
    let constant_s = network.extra_delay_s + 0.5 * network.asymmetry_s + network.delay_step_s.max(0.0);
    packets * timing.packet_period_s() + constant_s + network.jitter_s
}

/// Whether copies have come apart that are this far from each other on average and in the end (mm), with this mean force between them (N).
pub(super) fn are_apart([mean_mm, end_mm]: [f64; 2], compliance_m_per_n: f64, force_n: f64) -> bool {
    let statics_mm = 1e3 * compliance_m_per_n * force_n.abs();
    // What is no number (no force, and no spring) leaves the first.
    let beyond = |mm: f64, factor: f64| mm > APART_MM.max(factor * statics_mm);
    beyond(mean_mm, APART_FACTOR) || beyond(end_mm, END_FACTOR)
}
