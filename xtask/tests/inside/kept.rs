//! Tests of `src/kept.rs` from inside.

use super::*;

#[test]
fn a_step_depends_on_its_packages_and_what_they_lean_on_and_name() {
    let read = Packages::read().expect("cargo says who leans on whom");
    let inputs = |packages: &[&str], others: &[&str]| -> Vec<String> {
        let files = read.inputs(packages, others).expect("git lists files").0;
        files.into_iter().map(|file| file.to_string_lossy().into_owned()).collect()
    };
    let core = inputs(&["core"], &[]);
    let has = |files: &[String], name: &str| files.iter().any(|file| file == name);
    for name in ["core/src/law/mod.rs", "Cargo.lock", "rust-toolchain.toml", ".cargo/config.toml"] {
        assert!(has(&core, name), "{name}");
    }
    assert!(core.iter().all(|file| !file.starts_with("host-sim") && !file.starts_with("docs")), "{core:?}");
    let sim = inputs(&["host-sim/sim"], &[]);
    for name in
        ["core/src/law/mod.rs", "host-sim/sim/tests/golden.rs", "tests/oracle/simulations.csv", "scenes/impulsive.toml"]
    {
        assert!(has(&sim, name), "{name}");
    }
    // Not the tests of what it leans on, nor what leans on it.
    assert!(sim.iter().all(|file| !file.starts_with("core/tests") && !file.starts_with("host-sim/live")), "{sim:?}");
    assert!(has(&inputs(&["firmware"], &[]), "memory.x"));
    assert!(has(&inputs(&["core"], &["docs/results/hardware.md"]), "docs/results/hardware.md"));
    assert!(has(&inputs(&["xtask"], &["."]), "docs/results/hardware.md"));
}

#[test]
fn what_a_file_names_is_found_from_its_folder_and_from_its_package() {
    assert_eq!(within(Path::new("core/src/../../docs/a.md")), Some(PathBuf::from("docs/a.md")));
    assert_eq!(within(Path::new("tests/rig/../..")), Some(PathBuf::from(".")));
    assert_eq!(within(Path::new("core/../../elsewhere")), None);
}

#[test]
fn a_content_counts_and_not_its_time() {
    let one = Inputs(["Cargo.toml".into(), "Cargo.lock".into()].into());
    assert_eq!(one.sum(), Inputs(["Cargo.lock".into(), "Cargo.toml".into()].into()).sum());
    assert_ne!(one.sum(), Inputs(["Cargo.toml".into()].into()).sum());
    assert_ne!(one.sum(), Inputs(["Cargo.toml".into(), "Cargo.lock".into(), "no such file".into()].into()).sum());
}
