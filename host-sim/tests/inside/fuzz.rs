//! The fuzz target of the live page where there is no fuzzer.

use std::path::Path;

#[path = "../../../protocol/fuzz/src/check.rs"]
#[allow(unreachable_pub)] // There it is a library.
mod check;

type Target = (&'static str, fn(&[u8]));

const TARGETS: [Target; 1] = [("page", super::run)];

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
