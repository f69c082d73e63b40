//! What cargo compiles, counted against ceilings of `xtask/ceilings.txt`, and the times that are noted there.
//!
//! Nothing is built: cargo says what each call would compile (its unit graph, which it calls unstable). Two compilations are one if their
//! packages, targets, profiles, features and dependencies are the same.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::process::Command;

use crate::rooms::FILE;
use crate::run::{self, Failure};
use crate::test;

/// Packages and compilations of the first build, and compilations of all calls together; nothing if there are none.
pub(crate) fn counts(calls: &[Command]) -> Result<BTreeMap<String, usize>, Failure> {
    if calls.is_empty() {
        return Ok(BTreeMap::new());
    }
    let (packages, first) = units(&test::first_build())?;
    let mut check = BTreeSet::new();
    for call in calls {
        check.extend(units(call)?.1);
    }
    let counts = [
        ("packages of the first build", packages.len()),
        ("compilations of the first build", first.len()),
        ("compilations of cargo xtask test", check.len()),
    ];
    Ok(counts.map(|(name, count)| (name.to_owned(), count)).into())
}

/// Prints the processor time of a cold run of `what` next to the noted one. Machines and their loads differ, so nothing fails.
pub(crate) fn took(what: &str, seconds: Option<f64>) -> Result<(), Failure> {
    let text = run::read(&run::root().join(FILE))?;
    let noted = text.split_once(&format!("# {what}: ")).and_then(|(_, noted)| noted.lines().next());
    if let (Some(seconds), Some(noted)) = (seconds, noted) {
        eprintln!("    processor time of {what}: {seconds:.0} s; {FILE} notes {noted}");
    }
    Ok(())
}

/// Packages that a call of cargo needs, and a number for each compilation, the same in every call.
fn units(call: &Command) -> Result<(BTreeSet<String>, BTreeSet<u64>), Failure> {
    let mut cargo = run::cargo(&[]);
    cargo.args(call.get_args().take_while(|word| *word != "--")).arg("--unit-graph");
    let unstable = cargo.args(["-Z", "unstable-options"]).env("RUSTC_BOOTSTRAP", "1");
    let mut graph = run::output(unstable)?;
    // The profiles of tests and benches have names of their own, and the same settings.
    for (from, to) in [("test", "dev"), ("bench", "release")] {
        let profile = |name| format!("\"profile\":{{\"name\":\"{name}\"");
        graph = graph.replace(&profile(from), &profile(to));
    }
    let index = |text: &str| text.split([',', '}']).next()?.parse().ok();
    let units: Vec<(&str, Vec<usize>)> = graph
        .split("{\"pkg_id\":\"")
        .filter_map(|unit| unit.split_once("\"dependencies\":["))
        .map(|(unit, needs)| (unit, needs.split("\"index\":").filter_map(index).collect()))
        .collect();
    let ids = units.iter().filter_map(|(unit, _)| unit.split('"').next());
    let mut known = vec![None; units.len()];
    let compiles = |at: &usize| !units[*at].0.contains("\"mode\":\"run-custom-build\"");
    let compiled = (0..units.len()).filter(compiles);
    Ok((ids.map(str::to_owned).collect(), compiled.map(|at| key(&units, at, &mut known)).collect()))
}

/// A number of a unit and all that it needs.
fn key(units: &[(&str, Vec<usize>)], at: usize, known: &mut [Option<u64>]) -> u64 {
    if let Some(key) = known[at] {
        return key;
    }
    let (unit, needs) = &units[at];
    let mut needs: Vec<u64> = needs.iter().map(|need| key(units, *need, known)).collect();
    needs.sort_unstable();
    let mut hasher = DefaultHasher::new();
    (unit, needs).hash(&mut hasher);
    *known[at].insert(hasher.finish())
}
