//! Time of one tick of a peer, by scene and number type, and of a simulated second of two peers.
//!
//! `tick/SCENE/SCALAR` replays a recording of a peer alone; `two-peer-second/SCENE` steps the whole harness in f32 (two
//! peers, their devices, the network), without recording anything. Throughput is in ticks; a two-peer tick is one tick of
//! both. `cargo xtask bench` prints them as the tables of the README.

use cohold_cases::ticks::{self, Measure, Recording, TICKS};
use cohold_core::law::Law;
use cohold_core::num::Scalar;
use cohold_core::settings::Settings;
use cohold_sim::pair::Pair;
use cohold_sim::scenes;
use criterion::measurement::WallTime;
use criterion::{BatchSize, BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::time::Duration;

/// Two-peer ticks in one measurement: a second at the papers' rate.
const SECOND: u64 = 1000;

/// Scenes of the two-peer bench: each law of the paper, the scene of least discrepancy, and everything a real device adds.
const SCENES: &[&str] =
    &["paper-5.1-power-16ms", "paper-5.1-wave-16ms", "paper-5.1-passive-wave-16ms", "matched-line", "real-device"];

/// Times a recording of every case.
struct Time<'a>(BenchmarkGroup<'a, WallTime>);

impl Measure for Time<'_> {
    fn case<S: Scalar, L: Law<S>>(&mut self, scene: &'static str, settings: &Settings) {
        let recording = Recording::<S, L>::new(settings);
        self.0.bench_function(BenchmarkId::new(scene, S::NAME), |bench| {
            bench.iter(|| recording.replay(ticks::measured_tick))
        });
    }
}

fn one_tick(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("tick");
    group.throughput(Throughput::Elements(TICKS as u64));
    let mut time = Time(group);
    ticks::measure_all(&mut time);
    time.0.finish();
}

fn two_peer_second(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("two-peer-second");
    group.throughput(Throughput::Elements(SECOND));
    for name in SCENES {
        let file = scenes::load(cohold_sim::Laws::built_in(), name).expect("built-in scenes are valid");
        // From the middle of a run, where nothing is at rest.
        let second = |pair: &mut Pair<f32>| (0..SECOND).for_each(|_| pair.step());
        let start = || {
            let mut pair = Pair::<f32>::new(&file).expect("built-in scenes build");
            second(&mut pair);
            pair
        };
        let mut end = start();
        second(&mut end);
        assert_eq!(end.fault(), None, "{name} must run without a fault: a faulted peer does nothing");
        group.bench_function(*name, |bench| bench.iter_batched_ref(start, second, BatchSize::SmallInput));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .without_plots()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2));
    targets = one_tick, two_peer_second
}
criterion_main!(benches);
