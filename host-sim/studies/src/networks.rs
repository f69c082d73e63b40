//! Networks by name: those of the campaign, which studies take as well, and how a scene is put over one.
//!
//! What a table of a scene counts in packets may be given in milliseconds here (`network.loss_burst_packets=40 ms`): it is as many
//! packets as the scene sends in that time, so that a network is the same for every packet period.

use haptic_sim::scene::Scene;

use crate::Error;

/// A law or a network: name and settings.
pub(crate) type Named = (&'static str, &'static [&'static str]);

/// Networks: name and settings.
pub(crate) const IMPAIRMENTS: &[Named] = &[
    ("none", &[]),
    ("loss 5 %", &["network.loss=0.05"]),
    ("loss 10 %", &["network.loss=0.1"]),
    ("loss 20 %", &["network.loss=0.2"]),
    ("loss 50 %", &["network.loss=0.5"]),
    ("bursts of 40 ms, 5 %", &["network.loss=0.05", "network.loss_burst_packets=40 ms"]),
    ("bursts of 40 ms, 20 %", &["network.loss=0.2", "network.loss_burst_packets=40 ms"]),
    ("bursts of 40 ms, 50 %", &["network.loss=0.5", "network.loss_burst_packets=40 ms"]),
    ("bursts of 100 ms, 5 %", &["network.loss=0.05", "network.loss_burst_packets=100 ms"]),
    ("bursts of 100 ms, 20 %", &["network.loss=0.2", "network.loss_burst_packets=100 ms"]),
    ("bursts of 100 ms, 50 %", &["network.loss=0.5", "network.loss_burst_packets=100 ms"]),
    ("bursts of 200 ms, 20 %", &["network.loss=0.2", "network.loss_burst_packets=200 ms"]),
    ("bursts of 1 s, 20 %", &["network.loss=0.2", "network.loss_burst_packets=1000 ms"]),
    ("delay 0 ms", &["network.one_way_delay_packets=0"]),
    ("delay 24 ms", &["network.one_way_delay_packets=24 ms"]),
    ("delay 48 ms", &["network.one_way_delay_packets=48 ms"]),
    ("delay 104 ms", &["network.one_way_delay_packets=104 ms"]),
    ("delay 200 ms", &["network.one_way_delay_packets=200 ms"]),
    ("jitter 4 ms", &["network.jitter=uniform", "network.jitter_s=0.004"]),
    ("jitter 8 ms", &["network.jitter=uniform", "network.jitter_s=0.008"]),
    ("jitter 12 ms", &["network.jitter=uniform", "network.jitter_s=0.012"]),
    ("jitter 12 ms, play-out", &["network.jitter=uniform", "network.jitter_s=0.012", "network.playout_packets=16 ms"]),
    ("jitter gamma 6 ms", &["network.jitter=gamma", "network.jitter_s=0.006"]),
    ("jitter Pareto 4 ms", &["network.jitter=pareto", "network.jitter_s=0.004"]),
    ("jitter Pareto 10 ms", &["network.jitter=pareto", "network.jitter_s=0.01"]),
    ("reorder 30 %, depth 128 ms", &["network.reorder=0.3", "network.reorder_depth_packets=128 ms"]),
    ("blocks of 32 ms reversed", &["network.reverse_block_packets=32 ms"]),
    ("blocks of 64 ms reversed", &["network.reverse_block_packets=64 ms"]),
    ("duplication 20 %", &["network.duplicate=0.2", "network.jitter=uniform", "network.jitter_s=0.012"]),
    ("corruption 20 %", &["network.corrupt=0.2"]),
    ("delay step +100 ms", &["network.delay_step_s=0.1", "network.delay_step_at_s=5"]),
    ("delay step -100 ms", &["network.extra_delay_s=0.1", "network.delay_step_s=-0.1", "network.delay_step_at_s=5"]),
    ("asymmetry 40 ms", &["network.asymmetry_s=0.04"]),
    ("asymmetry 100 ms", &["network.asymmetry_s=0.1"]),
    ("drift +500 ppm", &["network.clock_drift_ppm=500"]),
    ("drift -500 ppm", &["network.clock_drift_ppm=-500"]),
    ("bandwidth 110 kbit/s", &["network.bandwidth_bit_per_s=111000"]),
    (
        "all at once",
        &[
            "network.one_way_delay_packets=24 ms",
            "network.asymmetry_s=0.02",
            "network.jitter=gamma",
            "network.jitter_s=0.006",
            "network.loss=0.1",
            "network.loss_burst_packets=32 ms",
            "network.reorder=0.1",
            "network.reorder_depth_packets=32 ms",
            "network.duplicate=0.1",
            "network.corrupt=0.02",
            "network.clock_drift_ppm=200",
        ],
    ),
];

/// Networks of the costs.
pub(crate) const FEW: &[Named] = &[("no loss", &[]), ("20 % lost", &["network.loss=0.2"])];

/// The scene over this network.
pub(crate) fn over(scene: &Scene, settings: &[&str]) -> Result<Scene, Error> {
    let mut scene = scene.clone();
    let packet_ms = 1e3 * scene.peer.timing.packet_period_s();
    for setting in settings {
        match setting.strip_suffix(" ms").and_then(|setting| setting.split_once('=')) {
            Some((key, ms)) => {
                let packets = ms.parse::<f64>().map_or(f64::NAN, |ms| (ms / packet_ms).round().max(1.0));
                scene.apply_override(&format!("{key}={packets}"))?;
            }
            None => scene.apply_override(setting)?,
        }
    }
    scene.check("campaign")?;
    Ok(scene)
}

/// Whether every packet arrives, in order and all equally late, each direction by itself.
pub(crate) fn is_constant(scene: &Scene) -> bool {
    let network = &scene.world.network;
    let changes = [network.delay_step_s, network.bandwidth_bit_per_s, network.clock_drift_ppm];
    !scene.draws_packets()
        && scene.network_trace.is_none()
        && network.reverse_block_packets <= 1
        && changes.iter().all(|change| *change == 0.0)
}
