//! The fuzz targets of `protocol/fuzz` where there is no fuzzer: over seeded bytes, and over every input that a fuzzer kept.

use std::fs;
use std::path::Path;

#[path = "../../fuzz/src/lib.rs"]
#[allow(unreachable_pub)] // There it is a library.
mod targets;

use targets::TARGETS;

/// Inputs of seeded bytes for each target, and the longest, bytes.
const INPUTS: u64 = 300;
const LONGEST: u64 = 1_500;

/// splitmix64.
fn next(random: &mut u64) -> u64 {
    *random = random.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*random ^ (*random >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[test]
fn every_target_over_seeded_bytes() {
    for (name, run) in TARGETS {
        for seed in 0..INPUTS {
            let mut random = seed;
            let len = next(&mut random) % LONGEST;
            let input: Vec<u8> = (0..len).map(|_| next(&mut random) as u8).collect();
            // Which one it was, for whoever sees it fail.
            println!("{name}, seed {seed}");
            run(&input);
        }
    }
}

#[test]
fn every_target_over_its_corpus() {
    for (name, run) in TARGETS {
        let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(name);
        let entries = fs::read_dir(&corpus).unwrap_or_else(|cause| panic!("{}: {cause}", corpus.display()));
        for entry in entries {
            let path = entry.expect("a readable folder").path();
            println!("{}", path.display());
            run(&fs::read(path).expect("a readable input"));
        }
    }
}

#[test]
fn every_target_is_built_for_the_fuzzer() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz");
    let manifest = fs::read_to_string(fuzz.join("Cargo.toml")).expect("the manifest");
    let named: Vec<&str> = manifest.lines().filter_map(|line| line.strip_prefix("name = ")).skip(1).collect();
    assert_eq!(named, TARGETS.map(|(name, _)| format!("\"{name}\"")));
    for (at, (name, _)) in TARGETS.into_iter().enumerate() {
        let text = fs::read_to_string(fuzz.join(format!("fuzz_targets/{name}.rs"))).expect("a file for each target");
        assert!(text.contains(&format!("TARGETS[{at}]")), "{name} is number {at}:\n{text}");
    }
}
