//! `cargo xtask rooms`: ceilings that only fall, from `xtask/ceilings.txt`, and the packages that each package leans on.
//!
//! A row's ceiling is the most that it may measure: formatted code lines of a package (`lines.rs`), or a count of what cargo
//! compiles (`builds.rs`). A group's ceiling is the sum of its rows, and it is never higher than in an earlier version of the file.
//! So a row rises only if others of its group fall by as much in the same commit. What the heart loses, guests may take: theirs is
//! summed with the heart's. Earlier versions are those on the first parents
//! of HEAD: a merge is compared with the branch that it was made on. If a row measures 3 % less than its ceiling, the ceiling must
//! fall. A package of the heart leans on a guest only if it did so in every earlier version.
//!
//! Cargo itself refuses packages that lean on each other in a circle, and says who leans on whom. Dependencies of tests do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use crate::run::{self, Failure, command, read};
use crate::{builds, lines};

/// Ceilings and dependencies, under review.
pub(crate) const FILE: &str = "xtask/ceilings.txt";

/// A package or a count: its group, its ceiling, and the packages that it leans on.
#[derive(Debug, PartialEq)]
struct Row {
    group: String,
    most: usize,
    leans: BTreeSet<String>,
}

/// Rows by name, which is a package's folder.
type Rows = BTreeMap<String, Row>;
/// What each row measures.
type Sizes = BTreeMap<String, usize>;
/// The packages that each package leans on.
pub(crate) type Leans = BTreeMap<String, BTreeSet<String>>;

/// Prints the table and checks it; with `bless` it first lowers the ceilings that must fall. `calls` are those that `cargo xtask test`
/// makes of cargo. If there are none, compilations are not counted.
pub(crate) fn rooms(calls: &[Command], bless: bool) -> Result<(), Failure> {
    // Whatever it is built for, with its usual features.
    let tree = "tree --locked --workspace --no-dedupe --depth 1 --edges normal,build --prefix depth --target all";
    let leans = leaning(&said("cargo", tree)?, run::root());
    let mut sizes = builds::counts(calls)?;
    let files = "ls-files --cached --others --exclude-standard */src/*.rs */benches/*.rs";
    let files = said("git", files)?;
    let files: Vec<&str> = files.lines().collect();
    let lines = lines::of_files(run::root(), &files)?;
    for file in files {
        let package = file.split("/src/").next().and_then(|path| path.split("/benches/").next());
        // Fuzz targets and the like are not packages of the workspace.
        if let Some(package) = package.filter(|package| leans.contains_key(*package)) {
            *sizes.entry(package.to_owned()).or_default() += lines[file];
        }
    }
    let place = run::root().join(FILE);
    let mut text = read(&place)?;
    if bless {
        text = lowered(&text, &sizes)?;
        std::fs::write(&place, &text).map_err(|cause| Failure::new(format!("{FILE}: {cause}")))?;
    }
    let mut rows = rows(&text)?;
    rows.retain(|_, row| row.group != "builds" || !calls.is_empty());
    let wrong = faults(&rows, &earlier()?, &sizes, &leans);
    wrong.iter().for_each(|line| eprintln!("    {line}"));
    if wrong.is_empty() { Ok(()) } else { Err(Failure::new(format!("{FILE} has {} faults", wrong.len()))) }
}

/// What a program prints when it is called with these words.
fn said(program: &str, words: &str) -> Result<String, Failure> {
    run::output(command(program, &[]).args(words.split(' ')))
}

/// `group name ceiling: folder folder …`, a line each; `#` begins a comment.
fn rows(text: &str) -> Result<Rows, Failure> {
    let wrong = |line| Failure::new(format!("{FILE}: `{line}` is not `group name ceiling: folder folder …`"));
    let rows = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    rows.map(|line| row(line).ok_or_else(|| wrong(line))).collect()
}

fn row(line: &str) -> Option<(String, Row)> {
    let (head, leans) = line.split_once(':')?;
    let (group, head) = head.split_once(' ')?;
    let (name, most) = head.rsplit_once(' ')?;
    let leans = leans.split_whitespace().map(str::to_owned).collect();
    Some((name.to_owned(), Row { group: group.to_owned(), most: most.parse().ok()?, leans }))
}

/// The file on the first parents of HEAD, the newest first, back to the first one in this form.
fn earlier() -> Result<Vec<Rows>, Failure> {
    if said("git", "rev-parse --is-shallow-repository")?.trim() == "true" {
        run::due_in_ci(format!("older versions of {FILE}, which `git fetch --unshallow` brings"))?;
    }
    // Before the first commit there is no HEAD, which is not an error.
    let commits = format!("rev-list --first-parent --ignore-missing HEAD -- {FILE}");
    let mut earlier = Vec::new();
    for commit in said("git", &commits)?.lines() {
        match rows(&said("git", &format!("show {commit}:{FILE}"))?) {
            Ok(rows) => earlier.push(rows),
            Err(_) => break,
        }
    }
    Ok(earlier)
}

/// Whether a ceiling must fall to what its row measures.
fn is_high(most: usize, size: usize) -> bool {
    size < most && 100 * (most - size) >= 3 * most
}

/// The file with each ceiling that must fall at what its row measures.
fn lowered(text: &str, sizes: &Sizes) -> Result<String, Failure> {
    let mut lowered = text.to_owned();
    for (name, Row { most, .. }) in rows(text)? {
        if let Some(size) = sizes.get(&name).filter(|size| is_high(most, **size)) {
            lowered = lowered.replace(&format!(" {name} {most}:"), &format!(" {name} {size}:"));
        }
    }
    Ok(lowered)
}

/// Prints the table; gives what is wrong with it.
fn faults(rows: &Rows, earlier: &[Rows], sizes: &Sizes, leans: &Leans) -> Vec<String> {
    let mut wrong = Vec::new();
    let named: BTreeSet<&String> = rows.keys().collect();
    for name in named.symmetric_difference(&sizes.keys().collect()) {
        wrong.push(format!("{name}: {FILE} and the workspace differ on whether it exists"));
    }
    println!("package or count                         now at most  leans on");
    for group in rows.values().map(|row| &row.group).collect::<BTreeSet<_>>() {
        let of_group = |rows| Rows::iter(rows).filter(|(_, row)| row.group == *group);
        let sum = |rows: &Rows, groups: &[&str]| {
            let of_these = rows.values().filter(|row| groups.contains(&&*row.group));
            of_these.map(|row| row.most).sum::<usize>()
        };
        // Lines may go from the heart to guests, and never back.
        let groups = &["heart", group][usize::from(group != "guests")..];
        let (most, now) = (sum(rows, &[group]), sum(rows, groups));
        let size: usize = of_group(rows).filter_map(|(name, _)| sizes.get(name)).sum();
        println!("{group:<36} {size:>7} {most:>7}");
        let least = earlier.iter().map(|rows| sum(rows, groups)).min();
        if let Some(least) = least.filter(|least| *least < now) {
            let rule = "if one rises, others of its group fall by as much in the same commit";
            let of = groups.join(" and ");
            wrong.push(format!("{of}: the sum of ceilings rises from {least} to {now}; {rule}"));
        }
        for (name, Row { most, leans: may, .. }) in of_group(rows) {
            let size = sizes.get(name).copied().unwrap_or_default();
            let found = leans.get(name).cloned().unwrap_or_default();
            let words = Vec::from_iter(found.iter().map(String::as_str)).join(" ");
            println!("  {name:<34} {size:>7} {most:>7}  {words}");
            if size > *most {
                wrong.push(format!("{name}: {size} is above its ceiling of {most}"));
            } else if is_high(*most, size) {
                wrong.push(format!("{name}: lower its ceiling from {most} to {size}, as --bless does"));
            }
            for leant in found.symmetric_difference(may) {
                wrong.push(format!("{name}: {FILE} and cargo differ on whether it leans on {leant}"));
            }
            for leant in may {
                let is_guest = rows.get(leant).is_some_and(|row| row.group == "guests");
                let has = |rows: &Rows| rows.get(name).is_some_and(|row| row.leans.contains(leant));
                if group == "heart" && is_guest && !earlier.iter().all(has) {
                    wrong.push(format!("{name}: the heart newly leans on the guest {leant}"));
                }
            }
        }
    }
    wrong
}

/// Folder of each package of the project, and the folders of those that it leans on, from what `cargo tree` says of them.
pub(crate) fn leaning(tree: &str, root: &Path) -> Leans {
    let (mut found, mut package) = (Leans::new(), String::new());
    // Other people's packages are not below this folder.
    let own = format!(" ({}/", root.display());
    for (line, path) in tree.lines().filter_map(|line| line.split_once(&own)) {
        let folder = path.split(')').next().unwrap_or_default().to_owned();
        if line.starts_with('0') {
            package = folder;
            found.entry(package.clone()).or_default();
        } else {
            found.entry(package.clone()).or_default().insert(folder);
        }
    }
    found
}

#[cfg(test)]
#[path = "../tests/inside/rooms.rs"]
mod tests;
