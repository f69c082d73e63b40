//! `cargo xtask rooms`: who leans on whom. Fails on a package that leans on another that `xtask/rooms.txt` does not name beside it,
//! and on one that has outgrown its lines there.
//!
//! Cargo itself refuses packages that lean on each other in a circle, and says who leans on whom: nothing here reads sources but to
//! count their lines. Tools of tests do not count.

use std::collections::BTreeMap;
use std::path::Path;

use crate::run::{self, Failure, cargo, command, read};

/// Size of each package and whom it may lean on, under review.
const FILE: &str = "xtask/rooms.txt";

/// Prints every package's lines and whom it leans on; what is not allowed is a failure.
pub(crate) fn rooms() -> Result<(), Failure> {
    let tree = [
        "tree",
        "--locked",
        "--workspace",
        "--no-dedupe",
        "--depth",
        "1",
        "--edges",
        "normal,build",
        "--prefix",
        "depth",
    ];
    let mut tree = cargo(&tree);
    // Whatever it is built for, and whatever is asked of it.
    let found = leaning(&run::output(tree.args(["--target", "all", "--all-features"]))?, run::root());
    let allowed = allowed(&read(&run::root().join(FILE))?)?;
    let mut wrong = Vec::new();
    let mut total = 0;
    println!("{:<26} {:>7} {:>7}  leans on", "package", "lines", "at most");
    for (package, leans) in &found {
        let lines = lines(package)?;
        total += lines;
        let Some((most, may)) = allowed.get(package) else {
            wrong.push(format!("{FILE} does not name {package}"));
            continue;
        };
        println!("{package:<26} {lines:>7} {most:>7}  {}", leans.join(" "));
        if lines > *most {
            wrong.push(format!("{package} has {lines} lines, {FILE} allows {most}"));
        }
        let climbs = leans.iter().filter(|leant| !may.contains(leant));
        wrong.extend(climbs.map(|leant| format!("{package} leans on {leant}, which {FILE} does not allow")));
    }
    wrong.extend(
        allowed
            .keys()
            .filter(|package| !found.contains_key(*package))
            .map(|package| format!("{FILE} names {package}, which is gone")),
    );
    println!("{:<26} {total:>7}", "all");
    wrong.iter().for_each(|line| eprintln!("    {line}"));
    if wrong.is_empty() {
        Ok(())
    } else {
        Err(Failure::new(format!("{} packages are not as {FILE} says", wrong.len())))
    }
}

/// `folder lines: folder folder …`, a line each; `#` begins a comment.
fn allowed(text: &str) -> Result<BTreeMap<String, (usize, Vec<String>)>, Failure> {
    let rows = text.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty());
    rows.map(|line| {
        let wrong = || Failure::new(format!("{FILE}: `{line}` is not `folder lines: folder folder …`"));
        let (package, may) = line.split_once(':').ok_or_else(wrong)?;
        let (folder, most) = package.trim().split_once(' ').ok_or_else(wrong)?;
        let most = most.trim().parse().map_err(|_| wrong())?;
        Ok((folder.to_owned(), (most, may.split_whitespace().map(str::to_owned).collect())))
    })
    .collect()
}

/// Folder of each package of the project, and the folders of those that it leans on, from what `cargo tree` says of them.
fn leaning(tree: &str, root: &Path) -> BTreeMap<String, Vec<String>> {
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut package = String::new();
    for line in tree.lines() {
        // Other people's packages are at no path.
        let path = line.split_once(" (").and_then(|(_, path)| path.split(')').next());
        let folder = path.and_then(|path| Path::new(path).strip_prefix(root).ok());
        let Some(folder) = folder.map(|folder| folder.to_string_lossy().into_owned()) else { continue };
        if line.starts_with('0') {
            package = folder;
            found.entry(package.clone()).or_default();
        } else if let Some(leans) = found.get_mut(&package).filter(|leans| !leans.contains(&folder)) {
            leans.push(folder);
        }
    }
    found
}

/// Lines of what git has of a package's sources and benches, comments and tests inside files included; of all packages for `*`.
pub(crate) fn lines(package: &str) -> Result<usize, Failure> {
    let files = [format!("{package}/src/*.rs"), format!("{package}/benches/*.rs")];
    let files = run::output(command("git", &["ls-files"]).args(files))?;
    files.lines().map(|file| Ok(read(&run::root().join(file))?.lines().count())).sum()
}

#[cfg(test)]
#[path = "../tests/inside/rooms.rs"]
mod tests;
