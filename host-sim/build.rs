//! Gives a program the commit that it is built from, for the files that it writes. Without git it is `unknown`.

use std::process::Command;

/// Results follow from these.
const SOURCES: [&str; 4] = ["core", "protocol/src", "host-sim", "Cargo.lock"];

fn git(words: &str) -> Option<String> {
    let output = Command::new("git").args(words.split(' ')).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn main() {
    let (Some(commit), Some(root)) = (git("rev-parse --short=12 HEAD"), git("rev-parse --show-toplevel")) else {
        return;
    };
    for sources in SOURCES {
        println!("cargo::rerun-if-changed={root}/{sources}");
    }
    let branch = git("rev-parse --symbolic-full-name HEAD").unwrap_or_default();
    for name in ["HEAD", &branch] {
        if let Some(path) = git(&format!("rev-parse --path-format=absolute --git-path {name}")) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let sources = SOURCES.map(|sources| format!(":/{sources}")).join(" ");
    let changes = git(&format!("status --porcelain --untracked-files=no -- {sources}"));
    let changed = changes.is_none_or(|changes| !changes.is_empty());
    println!("cargo::rustc-env=COHOLD_COMMIT={commit}{}", if changed { ", changed" } else { "" });
}
