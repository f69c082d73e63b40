//! Cargo as tests call it, and the programs of `examples/`, built from outside the packages that they use.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

const EXAMPLES: [&str; 5] = ["device", "observer", "outside-command", "outside-law", "plant"];

/// The repository.
pub(crate) fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the repository")
}

/// Runs cargo in a folder; what the tests have built is not built again there. Gives the folder of the programs.
pub(crate) fn cargo(folder: &Path, words: &[&str]) -> PathBuf {
    let target = Path::new(env!("CARGO_BIN_EXE_cohold")).ancestors().nth(2).expect("a target folder");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(words).arg("--offline").current_dir(folder).env("CARGO_TARGET_DIR", target);
    // Build scripts heed what cargo tells of this package: libraries would be built again, now and when cargo is
    // called next.
    let of_package = |name: &str| {
        ["OUT_DIR", "COHOLD_COMMIT"].contains(&name)
            || name.starts_with("CARGO_PKG_")
            || name.starts_with("CARGO_MANIFEST_")
    };
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_str().is_some_and(of_package)) {
        cargo.env_remove(name);
    }
    let output = cargo.output().expect("cargo runs");
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    target.join("debug")
}

/// Builds the examples, and gives the folder of the programs. Of the workspace they take nothing else, so that a stranger's copy is a
/// package by itself.
pub(crate) fn built() -> &'static Path {
    static PROGRAMS: LazyLock<PathBuf> = LazyLock::new(|| {
        let mut words = vec!["build", "--locked", "--bins"];
        for name in EXAMPLES {
            let manifest = repository().join("examples").join(name).join("Cargo.toml");
            let manifest =
                std::fs::read_to_string(&manifest).unwrap_or_else(|_| panic!("{} is read", manifest.display()));
            assert!(!manifest.contains("workspace"), "{name} leans on the workspace");
            words.extend(["--package", name]);
        }
        cargo(repository(), &words)
    });
    &PROGRAMS
}
