//! Targets where there is no fuzzer: over seeded bytes, and over every input that a fuzzer kept.

use std::fs;
use std::path::Path;

use super::Target;

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

/// Each target over inputs of seeded bytes.
pub fn over_seeded_bytes(targets: &[Target]) {
    for (name, run) in targets {
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

/// Each target over what fuzzers kept in `fuzz/corpus`.
pub fn over_corpus(targets: &[Target], fuzz: &Path) {
    for (name, run) in targets {
        let corpus = fuzz.join("corpus").join(name);
        let entries = fs::read_dir(&corpus).unwrap_or_else(|cause| panic!("{}: {cause}", corpus.display()));
        for entry in entries {
            let path = entry.expect("a readable folder").path();
            println!("{}", path.display());
            run(&fs::read(path).expect("a readable input"));
        }
    }
}

/// Each target has its program in the manifest of `fuzz`, which runs the target of its own number.
pub fn built_for_the_fuzzer(targets: &[Target], fuzz: &Path) {
    let manifest = fs::read_to_string(fuzz.join("Cargo.toml")).expect("the manifest");
    let named: Vec<&str> = manifest.lines().filter_map(|line| line.strip_prefix("name = ")).skip(1).collect();
    assert_eq!(named, targets.iter().map(|(name, _)| format!("\"{name}\"")).collect::<Vec<_>>());
    for (at, (name, _)) in targets.iter().enumerate() {
        let text = fs::read_to_string(fuzz.join(format!("fuzz_targets/{name}.rs"))).expect("a file for each target");
        assert!(text.contains(&format!("TARGETS[{at}]")), "{name} is number {at}:\n{text}");
    }
}
