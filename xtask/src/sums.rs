//! `cargo xtask sums`: what the project weighs, against the reviewed `xtask/sums.txt`: lines, how much is compiled, and what that takes.
//!
//! Nothing is built: cargo says what each call would compile (its unit graph, which it calls unstable). Two compilations are one where package,
//! target, profile, features and all that they depend on are.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::process::Command;

use crate::run::{self, Failure, cargo};

/// The reviewed sums.
const FILE: &str = "xtask/sums.txt";
/// What the rows of times begin with.
const TIMES: &str = "processor time of";

/// Prints the sums and compares them with the reviewed ones, or writes these. `calls` are what `cargo xtask test` has cargo compile.
pub(crate) fn sums(calls: &[Command], bless: bool) -> Result<(), Failure> {
    let first = Units::of(&cargo(&["build", "--locked", "--release"]))?;
    let mut check = BTreeSet::new();
    for call in calls {
        check.extend(Units::of(call)?.compilations);
    }
    let now = [
        ("lines of Rust in src and benches", crate::rooms::lines("*")?),
        ("packages of the first build", first.packages.len()),
        ("compilations of the first build", first.compilations.len()),
        ("compilations of cargo xtask test", check.len()),
    ];
    let text = run::read(&run::root().join(FILE))?;
    let (remarks, rows): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('#'));
    let fresh: Vec<String> = now.iter().map(|(name, sum)| format!("{name:<36}{sum:>8}")).collect();
    fresh.iter().for_each(|row| println!("{row}"));
    if bless {
        let times = rows.into_iter().filter(|row| row.starts_with(TIMES));
        let kept: Vec<&str> = remarks.into_iter().chain(fresh.iter().map(String::as_str)).chain(times).collect();
        let text = kept.join("\n") + "\n";
        return std::fs::write(run::root().join(FILE), text)
            .map_err(|cause| Failure::new(format!("cannot write {FILE}: {cause}")));
    }
    match fresh.iter().find(|row| !rows.contains(&row.as_str())) {
        None => Ok(()),
        Some(row) => Err(Failure::new(format!(
            "{FILE} does not say `{row}`: undo what changed it, or accept it with `cargo xtask sums --bless` and say why in the commit"
        ))),
    }
}

/// Prints what a cold run of `what` took beside what the reviewed one did. Nothing fails: machines differ, and so do their loads.
pub(crate) fn took(what: &str, seconds: Option<f64>) -> Result<(), Failure> {
    let text = run::read(&run::root().join(FILE))?;
    let name = format!("{TIMES} {what}");
    let reviewed = text.lines().find_map(|row| row.strip_prefix(&name)).map_or("nothing", str::trim);
    let now = seconds.map_or("is not known here".to_owned(), |seconds| format!("took {seconds:.0} s"));
    eprintln!("    {name}: {now}; {FILE} says {reviewed}");
    Ok(())
}

/// What a call of cargo would do.
struct Units {
    packages: BTreeSet<String>,
    /// A number for each, the same in every call.
    compilations: BTreeSet<u64>,
}

impl Units {
    fn of(call: &Command) -> Result<Self, Failure> {
        // Cargo's own lints are another program, which would not say.
        let words = call.get_args().map(|word| word.to_string_lossy().replace("clippy", "check"));
        let words: Vec<String> = words.take_while(|word| word != "--").collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let mut cargo = cargo(&words);
        cargo.args(["--unit-graph", "-Z", "unstable-options"]).env("RUSTC_BOOTSTRAP", "1");
        Ok(Self::read(&run::output(&mut cargo)?))
    }

    fn read(graph: &str) -> Self {
        let units: Vec<(&str, Vec<usize>)> = graph
            .split("{\"pkg_id\":\"")
            .skip(1)
            .filter_map(|unit| unit.split_once("\"dependencies\":["))
            .map(|(unit, needs)| (unit, needs.split("\"index\":").skip(1).filter_map(number).collect()))
            .collect();
        let mut known = BTreeMap::new();
        let compiles = |at: &usize| !units[*at].0.contains("\"mode\":\"run-custom-build\"");
        Self {
            packages: units.iter().filter_map(|(unit, _)| Some(unit.split_once('"')?.0.to_owned())).collect(),
            compilations: (0..units.len()).filter(compiles).map(|at| key(&units, at, &mut known)).collect(),
        }
    }
}

/// The number that a text begins with.
fn number(text: &str) -> Option<usize> {
    text.split([',', '}']).next()?.parse().ok()
}

/// What a unit is, and what it needs.
fn key(units: &[(&str, Vec<usize>)], at: usize, known: &mut BTreeMap<usize, u64>) -> u64 {
    if let Some(key) = known.get(&at) {
        return *key;
    }
    let (unit, needs) = &units[at];
    let mut needs: Vec<u64> = needs.iter().map(|need| key(units, *need, known)).collect();
    needs.sort_unstable();
    let mut hasher = DefaultHasher::new();
    // What tests are compiled with has another name, and is the same.
    let profile = |unit: &str, from, to| {
        unit.replace(&format!("\"profile\":{{\"name\":\"{from}\""), &format!("\"profile\":{{\"name\":\"{to}\""))
    };
    (profile(&profile(unit, "test", "dev"), "bench", "release"), needs).hash(&mut hasher);
    *known.entry(at).or_insert(hasher.finish())
}
