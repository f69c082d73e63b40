//! A guest is deleted: without its line and its folder the rest is built, and has the papers' numbers.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::program::built::{cargo, repository};

/// The list of the guests.
const LIST: &str = "host-sim/src/lib.rs";
/// The folders of a program. All others are left out: the board's, the tests', Python.
const FOLDERS: [&str; 4] = ["core", "protocol", "host-sim", "scenes"];

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|cause| panic!("{}: {cause}", file.display()))
}

/// The packages in the list.
fn guests() -> Vec<String> {
    let list = read(&repository().join(LIST));
    let names = list.lines().filter_map(|line| line.trim().strip_prefix("let cli = ")?.strip_suffix("::join(cli);"));
    names.map(|name| name.replace('_', "-")).collect()
}

/// The folders that a guest consists of.
fn folders(guest: &str) -> Vec<String> {
    let packages = read(&repository().join("Cargo.toml"));
    let line = packages.lines().find_map(|line| line.strip_prefix(&format!("{guest} = {{ path = \"")));
    let (package, _) = line.and_then(|line| line.split_once('"')).expect("a folder");
    let own: Vec<&str> = package.split('/').take(3).collect();
    let own = own.join("/");
    // A board has the laws too.
    let laws = (own == "host-sim/guests/laws").then(|| "core/laws".to_owned());
    [own].into_iter().chain(laws).collect()
}

/// A copy of the tree, with the times of its files, without these guests. Its program has this name.
fn without(deleted: &[String], name: &str) -> PathBuf {
    let copy = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&copy);
    std::fs::create_dir_all(&copy).expect("a folder");
    let mut git = Command::new("git");
    git.args(["ls-files", "--cached", "--others", "--exclude-standard", "Cargo.toml", "Cargo.lock"]).args(FOLDERS);
    let files = String::from_utf8(git.current_dir(repository()).output().expect("git runs").stdout).expect("names");
    let gone: Vec<String> = deleted.iter().flat_map(|guest| folders(guest)).collect();
    let stays = |file: &&str| {
        let is_in = |folder: &String| Path::new(file).starts_with(folder);
        repository().join(file).symlink_metadata().is_ok() && !gone.iter().any(is_in)
    };
    let mut copies = Command::new("cp");
    copies.args(["-a", "--parents", "-t"]).arg(&copy).args(files.lines().filter(stays)).current_dir(repository());
    assert!(copies.status().expect("cp runs").success());

    // Packages below a folder of a guest go with it.
    let names = |manifest: &str| {
        let (folder, _) = manifest.rsplit_once('/')?;
        let is_gone = gone.iter().any(|gone| Path::new(folder).starts_with(gone));
        let text = is_gone.then(|| read(&repository().join(manifest)))?;
        Some(text.lines().find_map(|line| line.strip_prefix("name = \""))?.trim_end_matches('"').to_owned())
    };
    let packages: Vec<String> = files.lines().filter(|file| file.ends_with("/Cargo.toml")).filter_map(names).collect();
    let rewrite = |file: &str, line: &dyn Fn(&str) -> Option<String>| {
        let text: String = read(&copy.join(file)).lines().filter_map(|at| Some(line(at)? + "\n")).collect();
        std::fs::write(copy.join(file), text).expect("it is written");
    };
    rewrite(LIST, &|line| {
        let is_deleted = deleted.iter().any(|guest| line.contains(&format!("{}::join", guest.replace('-', "_"))));
        (!is_deleted).then(|| line.to_owned())
    });
    rewrite("Cargo.toml", &|line| match line.split_once(" = ") {
        Some(("members", _)) => Some("members = [\"host-sim\"]".to_owned()),
        Some(("default-members", _)) => None,
        _ => Some(line.to_owned()),
    });
    for manifest in files.lines().filter(|file| file.ends_with("/Cargo.toml") && copy.join(file).exists()) {
        // Of tests nothing is built, and they may lean on what was left out.
        let of_tests = std::cell::Cell::new(false);
        rewrite(manifest, &|line| {
            if line.starts_with('[') {
                of_tests.set(line.contains("dev-dependencies"));
            }
            let is = |package: &String| {
                line.strip_prefix(package.as_str()).is_some_and(|rest| rest.starts_with('.') || rest.starts_with(" = "))
            };
            (!of_tests.get() && !packages.iter().any(is)).then(|| line.to_owned())
        });
    }
    let own = copy.join("host-sim/Cargo.toml");
    let text = read(&own).replace("default-run = \"cohold\"\n", "");
    let named = text.replace("[[bin]]\nname = \"cohold\"", &format!("[[bin]]\nname = \"{name}\""));
    assert_ne!(named, text);
    std::fs::write(&own, named).expect("it is written");
    copy
}

/// What `paper` computes.
fn experiments(program: &Path) -> Value {
    let output = Command::new(program).args(["--json", "paper"]).output().expect("it runs");
    assert!(output.status.success(), "{}: {}", program.display(), String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).expect("one JSON document");
    document["experiments"].clone()
}

#[test]
fn each_guest_can_be_deleted() {
    let all = guests();
    assert!(all.len() >= 5, "{all:?}");
    let with_all = experiments(Path::new(env!("CARGO_BIN_EXE_cohold")));
    let each = all.iter().map(|guest| (std::slice::from_ref(guest), format!("without-{guest}")));
    for (deleted, name) in each.chain([(&all[..], "heart-alone".to_owned())]) {
        let copy = without(deleted, &name);
        let programs = cargo(&copy, &["build", "--package", "cohold", "--bin", &name]);
        assert_eq!(experiments(&programs.join(&name)), with_all, "{name}");
        std::fs::remove_dir_all(copy).expect("it is removed");
    }
}
