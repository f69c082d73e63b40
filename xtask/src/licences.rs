//! The step `licences`: what the project is made of that is not its own. Fails on a package under a licence that `xtask/licences.txt` does
//! not name, and on one that comes from elsewhere than the registry. Packages of several versions are printed, and do not fail.
//!
//! What a package says of its licence is taken as it is; known vulnerabilities are not looked for, since that takes a database from elsewhere.

use std::collections::{BTreeMap, BTreeSet};

use crate::run::{self, Failure, cargo, read};

/// The licences that may be, a line each; `#` begins a comment.
const FILE: &str = "xtask/licences.txt";

/// Looks at every package that any part of the project is built or tested with, on whatever machine.
pub(crate) fn licences() -> Result<(), Failure> {
    let mut tree = cargo(&["tree", "--locked", "--workspace", "--all-features"]);
    tree.args(["--target", "all", "--no-dedupe", "--prefix", "none", "--format", "{p}\t{l}"]);
    let text = read(&run::root().join(FILE))?;
    let allowed: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    let tree = run::output(&mut tree)?;
    let found: BTreeSet<(&str, &str)> = tree.lines().filter_map(|line| line.split_once('\t')).collect();
    let (own, others): (Vec<_>, Vec<_>) = found.into_iter().partition(|(package, _)| is_own(package));
    let wrong: Vec<String> = others.iter().filter_map(|(package, licence)| wrong(package, licence, &allowed)).collect();
    let mut versions: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (name, version) in others.iter().filter_map(|(package, _)| package.split_once(' ')) {
        versions.entry(name).or_default().insert(version.split(' ').next().unwrap_or(version));
    }
    println!("{} packages of others, {} of the project's own", others.len(), own.len());
    for (name, versions) in versions.iter().filter(|(_, versions)| versions.len() > 1) {
        println!("{name} in {} versions: {}", versions.len(), versions.iter().copied().collect::<Vec<_>>().join(", "));
    }
    wrong.iter().for_each(|line| eprintln!("    {line}"));
    if wrong.is_empty() { Ok(()) } else { Err(Failure::new(format!("{} packages may not be used", wrong.len()))) }
}

/// Whether a package, as cargo shows it, stands in the project's folder.
fn is_own(package: &str) -> bool {
    package.contains(&format!("({}", run::root().display()))
}

/// What is wrong with a package of others, if anything.
fn wrong(package: &str, licence: &str, allowed: &[&str]) -> Option<String> {
    // Cargo shows where a package comes from that is not the registry's; `(proc-macro)` is no place.
    if package.contains("://") || package.contains("(/") {
        return Some(format!("{package} does not come from the registry"));
    }
    let any = |part: &str| part.split(" OR ").flat_map(|one| one.split('/')).any(|one| allowed.contains(&one.trim()));
    let all = licence.split(" AND ").all(|part| any(part.trim_matches(['(', ')'])));
    (!all).then(|| format!("{package}: {FILE} does not allow \"{licence}\""))
}

#[cfg(test)]
#[path = "../tests/inside/licences.rs"]
mod tests;
