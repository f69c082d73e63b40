//! The fuzz targets of `host-sim/guests/environments/fuzz` where there is no fuzzer.

use std::path::Path;

#[path = "../../fuzz/src/lib.rs"]
#[allow(unreachable_pub)] // There it is a library.
mod targets;

use targets::{TARGETS, check};

#[test]
fn every_target_over_seeded_bytes() {
    check::over_seeded_bytes(&TARGETS);
}

#[test]
fn every_target_over_its_corpus() {
    check::over_corpus(&TARGETS, &Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz"));
}

#[test]
fn every_target_is_built_for_the_fuzzer() {
    check::built_for_the_fuzzer(&TARGETS, &Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz"));
}
