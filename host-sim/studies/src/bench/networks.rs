//! Networks of the bench: some to tune on, others to test on, and what anybody has measured.
//!
//! Both lists have bursts, jitter and a delay, none of them the same, and none of the constant delays of the test is longer than one that was tuned on; three of the test are fitted to figures that were published
//! ([`haptic_sim::network::fitted`]), and `--trace` adds a recording.

use std::path::Path;
use std::sync::Arc;

use haptic_sim::network::rule::NetworkTrace;
use haptic_sim::scene::Scene;

use crate::Error;
use crate::networks::{self, Named};

/// Networks to tune on. On the first and the last, which are constant, what a hand feels is bounded.
pub const TUNING: &[Named] = &[
    ("8 ms", &[]),
    ("loss 10 %", &["network.loss=0.1"]),
    ("bursts of 60 ms, 10 %", &["network.loss=0.1", "network.loss_burst_packets=60 ms"]),
    ("jitter gamma 6 ms", &["network.jitter=gamma", "network.jitter_s=0.006"]),
    ("delay 24 ms", &["network.one_way_delay_packets=24 ms"]),
];

/// Networks to test on.
pub const TEST: &[Named] = &[
    ("8 ms", &[]),
    ("bursts of 40 ms, 5 %", &["network.loss=0.05", "network.loss_burst_packets=40 ms"]),
    ("bursts of 40 ms, 20 %", &["network.loss=0.2", "network.loss_burst_packets=40 ms"]),
    ("bursts of 100 ms, 20 %", &["network.loss=0.2", "network.loss_burst_packets=100 ms"]),
    ("jitter Pareto 4 ms", &["network.jitter=pareto", "network.jitter_s=0.004"]),
    ("delay 20 ms", &["network.one_way_delay_packets=20 ms"]),
    ("delay step +12 ms", &["network.delay_step_s=0.012", "network.delay_step_at_s=3"]),
    ("5G campus", &["network.like=5g-campus", "network.one_way_delay_packets=4 ms"]),
    ("Starlink", &["network.like=starlink", "network.one_way_delay_packets=15 ms"]),
    ("home Wi-Fi", &["network.like=home-wifi", "network.one_way_delay_packets=0", "network.extra_delay_s=0.0008"]),
];

/// A network of the test.
#[derive(Clone, Debug)]
pub struct Network {
    /// Its name in tables.
    pub name: String,
    settings: Vec<String>,
    trace: Option<Arc<NetworkTrace>>,
}

impl Network {
    /// Those of a list.
    pub fn named(list: &[Named]) -> Vec<Self> {
        let owned = |(name, settings): &Named| Self {
            name: (*name).to_owned(),
            settings: settings.iter().map(|setting| (*setting).to_owned()).collect(),
            trace: None,
        };
        list.iter().map(owned).collect()
    }

    /// A recording: what it found constant is the delay; a CSV file says nothing of that, and has the scene's.
    ///
    /// # Errors
    /// A file that is none.
    pub fn of_trace(file: &Path) -> Result<Self, Error> {
        let trace = NetworkTrace::read(file)?;
        let constant_ms = 1e3 * trace.constant_s();
        let delay = (constant_ms > 0.0).then(|| format!("network.one_way_delay_packets={constant_ms} ms"));
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, settings: delay.into_iter().collect(), trace: Some(Arc::new(trace)) })
    }

    /// The file that was recorded, of one that was.
    pub fn trace_file(&self) -> Option<&Path> {
        self.trace.as_ref().map(|trace| trace.file.as_path())
    }

    /// Whether it says anything.
    pub(crate) fn sets(&self) -> bool {
        self.trace.is_some() || !self.settings.is_empty()
    }

    /// What it does to this key of a scene is all there is: it sets it, or a recording takes its place.
    pub fn rules(&self, key: &str) -> bool {
        let set = self.settings.iter().any(|setting| setting.split_once('=').is_some_and(|(name, _)| name == key));
        let beside_a_recording = ["network.playout_packets", "network.clock_drift_ppm"];
        set || (self.trace.is_some() && key.starts_with("network.") && !beside_a_recording.contains(&key))
    }

    /// The scene over it.
    ///
    /// # Errors
    /// A scene that it cannot carry.
    pub fn over(&self, scene: &Scene) -> Result<Scene, Error> {
        let settings: Vec<&str> = self.settings.iter().map(String::as_str).collect();
        let mut scene = networks::over(scene, &settings)?;
        scene.network_trace.clone_from(&self.trace);
        Ok(scene)
    }
}

/// The scene over a network that neither delays nor loses: what a hand is compared with.
///
/// # Errors
/// A scene that has no such network.
pub fn perfect(scene: &Scene) -> Result<Scene, Error> {
    networks::over(scene, &["network.one_way_delay_packets=0"])
}
