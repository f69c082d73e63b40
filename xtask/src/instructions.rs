//! `cargo xtask bench-check`: the instructions of one tick against the reviewed `host-sim/cases/benches/instructions.txt`.
//!
//! The counts come from the bench `instructions` of haptic-cases, under callgrind: exact, the same on every run of the same
//! binary. The tolerance is for C libraries that copy memory differently; what the compiler or a change to the tick does
//! beyond it is for review (`--bless`, then the difference is in the commit).

use std::collections::BTreeMap;

use crate::run::{self, Failure, cargo};
use crate::setup;

/// Where the reviewed counts are.
const FILE: &str = "host-sim/cases/benches/instructions.txt";
/// Largest accepted change, either way, as a fraction.
const TOLERANCE: f64 = 0.02;
/// Number types, in the order of the table's columns.
pub(crate) const SCALARS: [&str; 3] = ["f32", "f64", "i32f32"];

/// Instructions per tick of every scene, in the order of [`SCALARS`].
pub(crate) struct Counts {
    /// The table as printed.
    pub(crate) text: String,
    /// Scenes in the order of the table.
    pub(crate) scenes: Vec<String>,
    /// Counts of every scene.
    pub(crate) of: BTreeMap<String, [u64; 3]>,
}

/// Counts and compares, or counts and writes.
pub(crate) fn check(bless: bool) -> Result<(), Failure> {
    if let Some(obstacle) = obstacle()? {
        return Err(Failure::new(obstacle));
    }
    let now = count()?;
    let path = run::root().join(FILE);
    if bless {
        std::fs::write(&path, &now.text).map_err(|cause| Failure::new(format!("cannot write {FILE}: {cause}")))?;
        eprintln!("    {FILE} rewritten: look at its difference");
        return Ok(());
    }
    let reviewed = std::fs::read_to_string(&path).map_err(|cause| {
        Failure::new(format!("cannot read {FILE}: {cause}; `cargo xtask bench-check --bless` writes it"))
    })?;
    compare(&parse(reviewed)?, &now)
}

/// Every scene in both, every count within the tolerance.
fn compare(reviewed: &Counts, now: &Counts) -> Result<(), Failure> {
    let mut differences = Vec::new();
    for scene in reviewed.scenes.iter().chain(now.scenes.iter().filter(|scene| !reviewed.of.contains_key(*scene))) {
        let (Some(before), Some(after)) = (reviewed.of.get(scene), now.of.get(scene)) else {
            differences.push(format!("{scene} is in one of them only"));
            continue;
        };
        for ((scalar, before), after) in SCALARS.iter().zip(before).zip(after) {
            let change = *after as f64 / *before as f64 - 1.0;
            if change.abs() > TOLERANCE {
                differences.push(format!("{scene} in {scalar}: {after}, was {before} ({:+.1} %)", 100.0 * change));
            }
        }
    }
    for difference in &differences {
        eprintln!("    {difference}");
    }
    if differences.is_empty() {
        eprintln!("    {} scenes within {} % of {FILE}", now.scenes.len(), 100.0 * TOLERANCE);
        Ok(())
    } else {
        Err(Failure::new(format!(
            "the instructions of one tick are not those of {FILE} (see above): undo what changed them, or accept them \
             with `cargo xtask bench-check --bless`"
        )))
    }
}

/// Why instructions cannot be counted here, if so; installs valgrind where that is all that is missing.
pub(crate) fn obstacle() -> Result<Option<String>, Failure> {
    if !cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        return Ok(Some(format!("{FILE} holds counts of x86-64 Linux; this is another machine")));
    }
    Ok(setup::program("valgrind", "valgrind"))
}

/// Counts now.
pub(crate) fn count() -> Result<Counts, Failure> {
    let mut bench = cargo(&["bench", "--locked", "--quiet", "--package", "haptic-cases", "--bench", "instructions"]);
    eprintln!("    {}", run::spelled(&bench));
    parse(run::output(&mut bench)?)
}

/// Reads the table.
fn parse(text: String) -> Result<Counts, Failure> {
    let (mut scenes, mut of) = (Vec::new(), BTreeMap::new());
    for line in text.lines().filter(|line| !line.starts_with('#') && !line.starts_with("scene ")) {
        let mut words = line.split_whitespace();
        let scene = words.next().unwrap_or_default().to_owned();
        let counts: Vec<u64> = words.map_while(|word| word.parse().ok()).collect();
        let counts = <[u64; 3]>::try_from(counts).map_err(|_| {
            Failure::new(format!(
                "a table of instruction counts has the line \"{line}\": expected a scene and three counts"
            ))
        })?;
        scenes.push(scene.clone());
        of.insert(scene, counts);
    }
    Ok(Counts { text, scenes, of })
}
