//! Which steps passed on this machine, and with which content: a step whose inputs have not changed since need not run again.
//!
//! The inputs of a step are files under git: those of its packages, of the packages that these lean on, and of what their code names by a
//! path with `../`; then the files that decide how everything is compiled. Contents count, not times or places, so a fresh clone profits
//! from what another one passed. The list is in a folder outside of the checkout (`$XDG_CACHE_HOME` or `~/.cache`), with one of its own for runs with `CI` set.

use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::{env, fs};

use crate::board::target;
use crate::rooms::{Leans, leaning};
use crate::run::{self, Failure, cargo, command};

/// What decides how everything is compiled.
const COMMON: [&str; 4] = ["Cargo.toml", "Cargo.lock", ".cargo/config.toml", "rust-toolchain.toml"];
/// Contents that are remembered for each step.
const MOST: usize = 50;

/// Whether every step runs, whatever passed before.
static ANEW: AtomicBool = AtomicBool::new(false);

/// Has every step run from now on.
pub(crate) fn anew() {
    ANEW.store(true, Ordering::Relaxed);
}

/// Who leans on whom, for each folder with a package.
pub(crate) struct Packages {
    /// In programs and libraries.
    leans: Leans,
    /// In tests, too.
    tests: Leans,
}

impl Packages {
    pub(crate) fn read() -> Result<Self, Failure> {
        let of = |edges| {
            let words = ["--depth", "1", "--prefix", "depth", "--no-dedupe", "--target", "all", "--edges", edges];
            Ok(leaning(&run::output(cargo(&["tree", "--locked", "--workspace"]).args(words))?, run::root()))
        };
        Ok(Self { leans: of("normal,build")?, tests: of("normal,build,dev")? })
    }

    /// Every folder with a package.
    pub(crate) fn folders(&self) -> impl Iterator<Item = &str> {
        self.leans.keys().map(String::as_str)
    }

    /// A step that tests these packages and reads these other files or folders, unless it passed with what they hold.
    pub(crate) fn step(
        &self,
        name: &str,
        packages: &[&str],
        others: &[&str],
        work: impl FnOnce() -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        step(name, &self.inputs(packages, others)?, work)
    }

    /// The inputs of a step that tests these packages, or all if none is named, and reads these other files or folders, `.` for all.
    pub(crate) fn inputs(&self, packages: &[&str], others: &[&str]) -> Result<Inputs, Failure> {
        let all: Vec<&str> = self.folders().filter(|_| packages.is_empty()).collect();
        let packages = &[packages, &all].concat();
        let mut folders: BTreeSet<&str> = packages.iter().copied().collect();
        let mut next: Vec<&str> =
            packages.iter().filter_map(|one| self.tests.get(*one)).flatten().map(String::as_str).collect();
        while let Some(package) = next.pop() {
            if folders.insert(package) {
                next.extend(self.leans.get(package).into_iter().flatten().map(String::as_str));
            }
        }
        // The package that a file belongs to. Of one that is only leaned on, its own tests do not count.
        let package =
            |file: &Path| self.folders().filter(|folder| file.starts_with(folder)).max_by_key(|folder| folder.len());
        let counts = |file: &PathBuf| {
            package(file).is_none_or(|of| {
                let inside = file.strip_prefix(of).unwrap_or(file);
                folders.contains(of)
                    && (packages.contains(&of) || !["tests", "benches"].iter().any(|part| inside.starts_with(part)))
            })
        };
        let mut inputs: BTreeSet<PathBuf> = files(folders.iter().copied())?.into_iter().filter(counts).collect();
        let named: BTreeSet<PathBuf> =
            inputs.iter().flat_map(|file| named(file, package(file).unwrap_or_default())).collect();
        inputs
            .extend(files(named.iter().filter_map(|path| path.to_str()).chain(others.iter().copied()).chain(COMMON))?);
        Ok(Inputs(inputs))
    }
}

/// Files under git, and those that it would take.
fn files<'a>(paths: impl Iterator<Item = &'a str>) -> Result<Vec<PathBuf>, Failure> {
    let mut list = command("git", &["ls-files", "--cached", "--others", "--exclude-standard", "--"]);
    Ok(run::output(list.args(paths))?.lines().map(PathBuf::from).collect())
}

/// What the code of a file names by a path with `../`, as seen from the file's folder or its package's.
fn named(file: &Path, package: &str) -> Vec<PathBuf> {
    if file.extension().is_none_or(|ending| ending != "rs") {
        return Vec::new();
    }
    let text = fs::read_to_string(run::root().join(file)).unwrap_or_default();
    let code = text.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
    let words = code.flat_map(|line| line.split('"').skip(1).step_by(2)).filter(|word| word.contains("../"));
    let from = [file.parent().unwrap_or(Path::new("")), Path::new(package)];
    let paths = words.flat_map(|word| from.map(|from| within(&from.join(word.trim_start_matches('/')))));
    paths.flatten().filter(|path| run::root().join(path).exists()).collect()
}

/// A path of the repository without `..`, `.` for all of it; none if it leads out of it.
fn within(path: &Path) -> Option<PathBuf> {
    let mut clean = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => clean.pop().then_some(())?,
            part => clean.push(part),
        }
    }
    Some(if clean.as_os_str().is_empty() { PathBuf::from(".") } else { clean })
}

/// The files that decide what comes of a step.
pub(crate) struct Inputs(BTreeSet<PathBuf>);

impl Inputs {
    /// A number of their names and contents as they are now.
    fn sum(&self) -> String {
        let mut hasher = DefaultHasher::new();
        for file in &self.0 {
            (file, fs::read(run::root().join(file)).ok()).hash(&mut hasher);
        }
        format!("{:016x}", hasher.finish())
    }
}

/// When a step passed with these inputs, if it did and that is to count.
pub(crate) fn passed(name: &str, inputs: &Inputs) -> Option<String> {
    let sum = inputs.sum();
    let kept = fs::read_to_string(place(name)).unwrap_or_default();
    let when = kept.lines().find_map(|line| line.strip_prefix(&sum));
    when.filter(|_| !ANEW.load(Ordering::Relaxed)).map(|when| when.trim().to_owned())
}

/// Runs a step, unless it passed with these inputs before; remembers that it passes.
pub(crate) fn step(name: &str, inputs: &Inputs, work: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
    if let Some(when) = passed(name, inputs) {
        run::skipped(name, &when);
        return Ok(());
    }
    let (sum, place) = (inputs.sum(), place(name));
    run::step(name, work)?;
    // If somebody has changed a file meanwhile, nobody knows what passed.
    if inputs.sum() != sum {
        return Ok(());
    }
    let now = run::output(&mut command("date", &["+%Y-%m-%d %H:%M"]))?;
    let kept = fs::read_to_string(&place).unwrap_or_default();
    let older = kept.lines().filter(|line| !line.starts_with(&sum)).take(MOST - 1);
    let lines: Vec<String> = [format!("{sum} {}", now.trim())].into_iter().chain(older.map(str::to_owned)).collect();
    let failed = |cause| Failure::new(format!("cannot write {}: {cause}", place.display()));
    fs::create_dir_all(place.parent().unwrap_or(&place))
        .and_then(|()| fs::write(&place, lines.join("\n")))
        .map_err(failed)
}

/// Where it is remembered which contents a step passed with.
fn place(name: &str) -> PathBuf {
    let folder = |name: &str| env::var_os(name).filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let cache = folder("XDG_CACHE_HOME").or_else(|| Some(folder("HOME")?.join(".cache"))).unwrap_or_else(target);
    let file = name.replace(|sign: char| !sign.is_ascii_alphanumeric(), "-");
    // What passed in somebody's own checkout may lean on a file that no fresh clone has.
    let who = if env::var_os("CI").is_some() { "passed-in-ci" } else { "passed" };
    cache.join("cohold").join(who).join(file + ".txt")
}

#[cfg(test)]
#[path = "../tests/inside/kept.rs"]
mod tests;
