//! The heart without its guests says the same.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

#[test]
fn without_any_guest_the_papers_numbers_are_the_same() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let heart =
        ["run", "--quiet", "--locked", "--package", "cohold-cli", "--example", "heart", "--", "paper", "--json"];
    let alone = Command::new(env!("CARGO")).args(heart).current_dir(root).output().expect("cargo runs");
    assert!(alone.status.success(), "{}", String::from_utf8_lossy(&alone.stderr));
    let with_all = Command::new(env!("CARGO_BIN_EXE_cohold")).args(["paper", "--json"]).output().expect("cohold runs");
    let read = |output: Output| serde_json::from_slice::<Value>(&output.stdout).expect("one JSON document");
    let [alone, with_all] = [alone, with_all].map(read);
    assert_eq!(alone["experiments"], with_all["experiments"]);
}
