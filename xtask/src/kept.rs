//! Which image and which bench the virtual boards last passed with on this machine: while both are the same, they pass again.
//!
//! Of the image its bytes count, and not its sources: it is the same wherever it is built. Of the bench, what cargo says that it is made of,
//! simulator included, its tests, and what decides how it is compiled. Nothing is kept in a fresh clone.

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use crate::board::{BESIDES, target};
use crate::run::{self, Failure, command};

/// What else decides: how all is compiled, and the page that tests compare their tables with.
const FILES: [&str; 5] = ["Cargo.toml", "Cargo.lock", ".cargo/config.toml", "rust-toolchain.toml", "docs/hardware.md"];

/// Where it is kept.
fn place() -> PathBuf {
    target().join("boards-passed.txt")
}

/// When this image and this bench passed, if they did.
pub(crate) fn passed(image: &Path) -> Option<String> {
    let kept = fs::read_to_string(place()).ok()?;
    let (sum, when) = kept.trim().split_once(' ')?;
    (sum == self::sum(image)?).then(|| when.to_owned())
}

/// They have passed now.
pub(crate) fn keep(image: &Path) -> Result<(), Failure> {
    let when = run::output(&mut command("date", &["+%Y-%m-%d %H:%M"]))?;
    let kept = sum(image).map_or_else(String::new, |sum| format!("{sum} {when}"));
    fs::write(place(), kept).map_err(|cause| Failure::new(format!("cannot write {}: {cause}", place().display())))
}

/// A number of the images and of all that the bench was last built from; none where it was not.
fn sum(image: &Path) -> Option<String> {
    let mut hasher = DefaultHasher::new();
    for image in image.parent()?.read_dir().ok()?.flatten().map(|entry| entry.path()) {
        let name = image.file_name()?.to_str()?;
        if ["firmware", "rig"].into_iter().chain(BESIDES).any(|known| known == name) {
            (name, fs::read(&image).ok()?).hash(&mut hasher);
        }
    }
    let made_of = fs::read_to_string(target().join("debug/libboard_bench.d")).ok()?;
    let mut files: Vec<PathBuf> = made_of.split_whitespace().skip(1).map(PathBuf::from).collect();
    files.extend(FILES.map(|file| run::root().join(file)));
    let mut folders = vec![run::root().join("tests/board/tests")];
    while let Some(folder) = folders.pop() {
        for path in folder.read_dir().ok()?.flatten().map(|entry| entry.path()) {
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    // Folders are named only so that cargo looks for new files; the commit is written into recordings, which nobody compares.
    files.retain(|file| !file.is_dir() && !file.components().any(|part| part.as_os_str() == ".git"));
    files.sort();
    files.dedup();
    for file in files {
        (&file, fs::read(&file).ok()?).hash(&mut hasher);
    }
    Some(format!("{:016x}", hasher.finish()))
}
