//! Tells the program which commit it is built from, for the files that it writes; `unknown` where there is no git. Tells the compiler
//! that the fuzz targets' build has a word of its own.

use std::process::Command;

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn main() {
    println!("cargo::rustc-check-cfg=cfg(fuzzing)");
    // Whatever changes these makes this package be built again anyway.
    for sources in
        ["../core/src", "../protocol/src", "analysis/src", "cases/src", "plot/src", "sim/src", "src", "../Cargo.lock"]
    {
        println!("cargo::rerun-if-changed={sources}");
    }
    let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) else { return };
    let branch = git(&["rev-parse", "--symbolic-full-name", "HEAD"]).unwrap_or_default();
    for name in ["HEAD", &branch] {
        if let Some(path) = git(&["rev-parse", "--git-path", name]) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let changed = git(&["status", "--porcelain", "--untracked-files=no"]).is_none_or(|changes| !changes.is_empty());
    println!("cargo::rustc-env=COHOLD_COMMIT={commit}{}", if changed { ", changed" } else { "" });
}
