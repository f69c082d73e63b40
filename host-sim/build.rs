//! Tells a program which commit it is built from, for the files that it writes; `unknown` where there is no git.

use std::process::Command;

fn git(words: &str) -> Option<String> {
    let output = Command::new("git").args(words.split(' ')).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn main() {
    let (Some(commit), Some(root)) = (git("rev-parse --short=12 HEAD"), git("rev-parse --show-toplevel")) else {
        return;
    };
    for sources in ["core", "protocol/src", "host-sim", "Cargo.lock"] {
        println!("cargo::rerun-if-changed={root}/{sources}");
    }
    let branch = git("rev-parse --symbolic-full-name HEAD").unwrap_or_default();
    for name in ["HEAD", &branch] {
        if let Some(path) = git(&format!("rev-parse --path-format=absolute --git-path {name}")) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let changed = git("status --porcelain --untracked-files=no").is_none_or(|changes| !changes.is_empty());
    println!("cargo::rustc-env=COHOLD_COMMIT={commit}{}", if changed { ", changed" } else { "" });
}
