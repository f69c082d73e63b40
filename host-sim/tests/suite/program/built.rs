//! The programs of `examples/`, built from outside the packages that they use; and the heart without any guest.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

const EXAMPLES: [&str; 5] = ["device", "observer", "outside-command", "outside-law", "plant"];

/// Builds the examples, and the heart without guests, and gives the folder of the programs. What is built besides them is what the tests have built: members of one workspace
/// share it. Of the workspace they take nothing else, so that a stranger's copy is a package by itself.
pub(crate) fn built() -> &'static Path {
    static PROGRAMS: LazyLock<PathBuf> = LazyLock::new(|| {
        let repository = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the repository");
        let target = Path::new(env!("CARGO_BIN_EXE_cohold")).ancestors().nth(2).expect("a target folder");
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["build", "--locked", "--offline"]).current_dir(repository).env("CARGO_TARGET_DIR", target);
        for name in EXAMPLES {
            let manifest = repository.join("examples").join(name).join("Cargo.toml");
            let manifest =
                std::fs::read_to_string(&manifest).unwrap_or_else(|_| panic!("{} is read", manifest.display()));
            assert!(!manifest.contains("workspace"), "{name} leans on the workspace");
            cargo.args(["--package", name]);
        }
        cargo.args(["--bins", "--package", "cohold-cli", "--example", "heart"]);
        // Build scripts heed what cargo tells of this package: libraries would be built again, now and when cargo is
        // called next.
        let of_package =
            |name: &str| name == "OUT_DIR" || name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_");
        for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_str().is_some_and(of_package)) {
            cargo.env_remove(name);
        }
        let output = cargo.output().expect("cargo runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        target.join("debug")
    });
    &PROGRAMS
}
