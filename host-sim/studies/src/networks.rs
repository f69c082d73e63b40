//! Networks by name: those of the campaign and of the bench, recordings, and how a scene is put over one.
//!
//! A network sets keys of a scene's table `network`. What that table counts in packets may be given in milliseconds here
//! (`loss_burst_packets=40ms`). It is as many packets as the scene sends in that time, so that a network is the same for every packet
//! period.
//!
//! Both lists of the bench have bursts, jitter and a delay, none of them the same, and none of the constant delays of the test is longer
//! than one that was tuned on. Three of the test are fitted to figures that were published ([`cohold_sim::network::fitted`]).

use std::path::Path;
use std::sync::Arc;

use cohold_sim::network::rule::NetworkTrace;
use cohold_sim::scene::{Scene, nearest};

use crate::Error;

/// What each entrant's own network is called.
pub const OWN: &str = "own";
/// All networks that have a name.
pub const ALL: &str = "all";

/// A network: name, and keys of the table `network` with their values.
pub type Named = (&'static str, &'static str);

/// Networks: name and settings.
pub(crate) const IMPAIRMENTS: &[Named] = &[
    ("none", ""),
    ("loss 5 %", "loss=0.05"),
    ("loss 10 %", "loss=0.1"),
    ("loss 20 %", "loss=0.2"),
    ("loss 50 %", "loss=0.5"),
    ("bursts of 40 ms, 5 %", "loss=0.05 loss_burst_packets=40ms"),
    ("bursts of 40 ms, 20 %", "loss=0.2 loss_burst_packets=40ms"),
    ("bursts of 40 ms, 50 %", "loss=0.5 loss_burst_packets=40ms"),
    ("bursts of 100 ms, 5 %", "loss=0.05 loss_burst_packets=100ms"),
    ("bursts of 100 ms, 20 %", "loss=0.2 loss_burst_packets=100ms"),
    ("bursts of 100 ms, 50 %", "loss=0.5 loss_burst_packets=100ms"),
    ("bursts of 200 ms, 20 %", "loss=0.2 loss_burst_packets=200ms"),
    ("bursts of 1 s, 20 %", "loss=0.2 loss_burst_packets=1000ms"),
    ("delay 0 ms", "one_way_delay_packets=0"),
    ("delay 24 ms", "one_way_delay_packets=24ms"),
    ("delay 48 ms", "one_way_delay_packets=48ms"),
    ("delay 104 ms", "one_way_delay_packets=104ms"),
    ("delay 200 ms", "one_way_delay_packets=200ms"),
    ("jitter 4 ms", "jitter=uniform jitter_s=0.004"),
    ("jitter 8 ms", "jitter=uniform jitter_s=0.008"),
    ("jitter 12 ms", "jitter=uniform jitter_s=0.012"),
    ("jitter 12 ms, play-out", "jitter=uniform jitter_s=0.012 playout_packets=16ms"),
    ("jitter gamma 6 ms", "jitter=gamma jitter_s=0.006"),
    ("jitter Pareto 4 ms", "jitter=pareto jitter_s=0.004"),
    ("jitter Pareto 10 ms", "jitter=pareto jitter_s=0.01"),
    ("reorder 30 %, depth 128 ms", "reorder=0.3 reorder_depth_packets=128ms"),
    ("blocks of 32 ms reversed", "reverse_block_packets=32ms"),
    ("blocks of 64 ms reversed", "reverse_block_packets=64ms"),
    ("duplication 20 %", "duplicate=0.2 jitter=uniform jitter_s=0.012"),
    ("corruption 20 %", "corrupt=0.2"),
    ("delay step +100 ms", "delay_step_s=0.1 delay_step_at_s=5"),
    ("delay step -100 ms", "extra_delay_s=0.1 delay_step_s=-0.1 delay_step_at_s=5"),
    ("asymmetry 40 ms", "asymmetry_s=0.04"),
    ("asymmetry 100 ms", "asymmetry_s=0.1"),
    ("drift +500 ppm", "clock_drift_ppm=500"),
    ("drift -500 ppm", "clock_drift_ppm=-500"),
    ("bandwidth 110 kbit/s", "bandwidth_bit_per_s=111000"),
    (
        "all at once",
        "one_way_delay_packets=24ms asymmetry_s=0.02 jitter=gamma jitter_s=0.006 loss=0.1 loss_burst_packets=32ms reorder=0.1 \
         reorder_depth_packets=32ms duplicate=0.1 corrupt=0.02 clock_drift_ppm=200",
    ),
];

/// Networks of the costs.
pub(crate) const FEW: &[Named] = &[("no loss", ""), ("20 % lost", "loss=0.2")];

/// Networks on which the bench tunes. On the first and the last, which are constant, what a hand feels is bounded.
pub const TUNING: &[Named] = &[
    ("8 ms", ""),
    ("loss 10 %", "loss=0.1"),
    ("bursts of 60 ms, 10 %", "loss=0.1 loss_burst_packets=60ms"),
    ("jitter gamma 6 ms", "jitter=gamma jitter_s=0.006"),
    ("delay 24 ms", "one_way_delay_packets=24ms"),
];

/// Networks on which the bench tests.
pub const TEST: &[Named] = &[
    ("8 ms", ""),
    ("bursts of 40 ms, 5 %", "loss=0.05 loss_burst_packets=40ms"),
    ("bursts of 40 ms, 20 %", "loss=0.2 loss_burst_packets=40ms"),
    ("bursts of 100 ms, 20 %", "loss=0.2 loss_burst_packets=100ms"),
    ("jitter Pareto 4 ms", "jitter=pareto jitter_s=0.004"),
    ("delay 20 ms", "one_way_delay_packets=20ms"),
    ("delay step +12 ms", "delay_step_s=0.012 delay_step_at_s=3"),
    ("5G campus", "like=5g-campus one_way_delay_packets=4ms"),
    ("Starlink", "like=starlink one_way_delay_packets=15ms"),
    ("home Wi-Fi", "like=home-wifi one_way_delay_packets=0 extra_delay_s=0.0008"),
];

/// Those that have a name, each once. One that sets nothing is the entrant's own.
fn named() -> Vec<Named> {
    let mut all: Vec<Named> = Vec::new();
    for network in IMPAIRMENTS.iter().chain(TUNING).chain(TEST) {
        if !network.1.is_empty() && !all.iter().any(|(name, _)| *name == network.0) {
            all.push(*network);
        }
    }
    all
}

/// A network that scenes are run over. What it does not say is as the scene has it.
#[derive(Clone, Debug)]
pub struct Network {
    /// Its name in tables.
    pub name: String,
    settings: String,
    trace: Option<Arc<NetworkTrace>>,
}

impl Network {
    /// The names of networks.
    pub fn names() -> impl Iterator<Item = &'static str> {
        std::iter::once(OWN).chain(named().into_iter().map(|(name, _)| name))
    }

    /// Each scene's own network.
    pub fn own() -> Self {
        Self { name: OWN.to_owned(), settings: String::new(), trace: None }
    }

    /// Those of a list. One that sets nothing is each scene's own.
    pub fn named(list: &[Named]) -> Vec<Self> {
        let of =
            |(name, settings): &Named| Self { name: (*name).to_owned(), settings: (*settings).to_owned(), trace: None };
        list.iter().map(of).collect()
    }

    /// The network of this name, strokes for blanks or not, or all of them.
    ///
    /// # Errors
    /// A name that no network has.
    pub fn of(text: &str) -> Result<Vec<Self>, Error> {
        let all = named();
        // In a shell a name is easier to type with strokes for blanks.
        let typed = |name: &str| name.replace(' ', "-");
        match (text, all.iter().find(|(name, _)| typed(name) == typed(text))) {
            (OWN, _) => Ok(vec![Self::own()]),
            (ALL, _) => Ok(std::iter::once(Self::own()).chain(Self::named(&all)).collect()),
            (_, Some(network)) => Ok(Self::named(&[*network])),
            (_, None) => {
                let hint = nearest(text, Self::names()).map(|near| format!("did you mean {near:?}? "));
                let names: Vec<String> = Self::names().chain([ALL]).map(|name| format!("{name:?}")).collect();
                let (hint, names) = (hint.unwrap_or_default(), names.join(", "));
                Err(format!("there is no network called {text:?}; {hint}They are {names}").into())
            }
        }
    }

    /// A recording: what it found constant is the delay; a CSV file says nothing of that, and has the scene's.
    ///
    /// # Errors
    /// A file that is none.
    pub fn of_trace(file: &Path) -> Result<Self, Error> {
        let trace = NetworkTrace::read(file)?;
        let constant_ms = 1e3 * trace.constant_s();
        let delay = (constant_ms > 0.0).then(|| format!("one_way_delay_packets={constant_ms}ms"));
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, settings: delay.unwrap_or_default(), trace: Some(Arc::new(trace)) })
    }

    /// The file that was recorded, of one that was.
    pub fn trace_file(&self) -> Option<&Path> {
        self.trace.as_ref().map(|trace| trace.file.as_path())
    }

    /// What it does to this key of a scene is all there is: it sets it, or a recording takes its place.
    pub fn rules(&self, key: &str) -> bool {
        let Some(key) = key.strip_prefix("network.") else { return false };
        let sets = |setting: &str| setting.split_once('=').is_some_and(|(name, _)| name == key);
        self.settings.split_whitespace().any(sets)
            || (self.trace.is_some() && !["playout_packets", "clock_drift_ppm"].contains(&key))
    }

    /// The scene over it.
    ///
    /// # Errors
    /// A scene that it cannot carry.
    pub fn over(&self, scene: &Scene) -> Result<Scene, Error> {
        if self.settings.is_empty() && self.trace.is_none() {
            return Ok(scene.clone());
        }
        let mut scene = over(scene, &self.settings).map_err(|error| format!("over {:?}: {error}", self.name))?;
        scene.network_trace.clone_from(&self.trace);
        Ok(scene)
    }
}

/// The scene with these keys of its table `network`.
///
/// # Errors
/// A scene that cannot have them.
pub(crate) fn over(scene: &Scene, settings: &str) -> Result<Scene, Error> {
    let mut scene = scene.clone();
    let packet_ms = 1e3 * scene.peer.timing.packet_period_s();
    for setting in settings.split_whitespace() {
        let (key, value) = setting.split_once('=').unwrap_or((setting, ""));
        let packets = |ms: &str| ms.parse::<f64>().map_or(f64::NAN, |ms| (ms / packet_ms).round().max(1.0));
        let value = value.strip_suffix("ms").map_or(value.to_owned(), |ms| packets(ms).to_string());
        scene.apply_override(&format!("network.{key}={value}"))?;
    }
    scene.check("campaign")?;
    Ok(scene)
}

/// The scene over a network that neither delays nor loses: what a hand is compared with.
///
/// # Errors
/// A scene that has no such network.
pub(crate) fn perfect(scene: &Scene) -> Result<Scene, Error> {
    over(scene, "one_way_delay_packets=0")
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

#[cfg(test)]
#[path = "../tests/inside/networks.rs"]
mod tests;
