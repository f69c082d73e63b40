//! Golden traces: the hash of both peers' states over every tick of every built-in scene, in every number type.
//!
//! The same in debug and in release, on one thread and on two, on every machine. Written anew by `BLESS=1 cargo test`;
//! a change of any hash is a change of behaviour and belongs into the changelog.

use cohold_core::num::Fixed;
use cohold_sim::run::{Options, Run, run};
use cohold_sim::scenes;
use rayon::prelude::*;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/golden.txt");

fn hash<S: Run>(name: &str) -> String {
    let scene = scenes::load(cohold_sim::Laws::built_in(), name).expect("a built-in scene");
    let outcome = run::<S>(&scene, Options { duration_s: 5.0, record_every: 0 }, &|_| {}).expect("a good scene");
    format!("{name} {} {:016x}", S::NAME, outcome.hash)
}

fn all(threads: usize) -> String {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
    let lines: Vec<String> = pool.install(|| {
        scenes::ALL
            .par_iter()
            .flat_map_iter(|(name, _)| [hash::<f32>(name), hash::<f64>(name), hash::<Fixed>(name)])
            .collect()
    });
    lines.join("\n") + "\n"
}

#[test]
fn every_scene_gives_the_recorded_bits_on_one_and_two_threads() {
    let one = all(1);
    assert_eq!(one, all(2), "the number of threads changed the bits");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(FILE, &one).expect("write the golden hashes");
    }
    let recorded = std::fs::read_to_string(FILE).expect("the golden hashes");
    assert_eq!(one, recorded, "bits changed; if they were meant to, run with BLESS=1");
}
