//! The fuzz target of the live page where there is no fuzzer.

use std::path::{Path, PathBuf};

use super::{Open, heads};

#[path = "../../../../../protocol/fuzz/src/check.rs"]
#[allow(unreachable_pub)] // There it is a library.
mod check;

type Target = (&'static str, fn(&[u8]));

const TARGETS: [Target; 1] = [("page", super::run)];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz")
}

#[test]
fn every_target_over_seeded_bytes() {
    check::over_seeded_bytes(&TARGETS);
}

#[test]
fn every_target_over_its_corpus() {
    check::over_corpus(&TARGETS, &folder());
}

#[test]
fn every_target_is_built_for_the_fuzzer() {
    check::built_for_the_fuzzer(&TARGETS, &folder());
}

/// What the fuzzer begins with opens windows and gives orders that are taken: what it finds from there is beyond the first refusal.
#[test]
fn what_the_fuzzer_begins_with_is_let_in() {
    let read = |name: &str| std::fs::read(folder().join("corpus/page").join(name)).expect("an input");
    for (name, is_let_in) in [
        ("window", true),
        ("window-localhost", true),
        ("both-hands", false),
        ("another-role", false),
        ("two-hosts", false),
        ("post", false),
    ] {
        assert_eq!(heads(&read(name)), is_let_in, "{name}");
    }
    for (name, is_taken) in [
        ("set", true),
        ("scene", true),
        ("law", true),
        ("toml", true),
        ("shows", true),
        ("acts", true),
        ("orders-between-ticks", true),
        ("toml-trace", false),
        ("long-word", false),
        ("deep", false),
    ] {
        let mut page = Open::new();
        let text = String::from_utf8(read(name)).expect("text");
        for line in text.split('\0').filter(|line| !line.is_empty()) {
            assert_eq!(page.order(line), is_taken, "{name}: {line}");
        }
    }
}
