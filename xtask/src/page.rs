//! `cargo xtask page`: types, lints and format of the live page's sources (host-sim/guests/page/src/site), with tools whose versions and hashes
//! stand in tests/page/package-lock.json; and the browser that the page is tested and measured in.

use std::path::Path;

use crate::run::{self, Failure, command};
use crate::setup;

/// Checks the sources, or writes their format.
pub(crate) fn page(write: bool) -> Result<(), Failure> {
    let folder = run::root().join("tests/page");
    if let Some(obstacle) = setup::program("npm", "npm") {
        return Err(Failure::new(obstacle));
    }
    let npm = |arguments: &[&str]| {
        let mut npm = command("npm", arguments);
        npm.current_dir(&folder);
        npm
    };
    // npm writes the second file when it has installed what the first one says. Not `npm ci`: it fails where the registry lacks a
    // package that only another system needs.
    let written = |path: &Path| path.metadata().and_then(|of| of.modified()).ok();
    let (wanted, there) = (folder.join("package-lock.json"), folder.join("node_modules/.package-lock.json"));
    if written(&there).is_none() || written(&there) < written(&wanted) {
        run::run(&mut npm(&["install", "--no-save", "--no-audit", "--no-fund"]))?;
    }
    if write {
        return run::run(&mut npm(&["run", "--silent", "format"]));
    }
    run::run(&mut npm(&["run", "--silent", "check"]))
        .map_err(|failure| Failure::new(format!("{failure}; `cargo xtask page --write` mends what is format")))
}

/// Prints how punctual the release build is without and with two windows in Chromium, and how soon a moved pointer is a picture.
pub(crate) fn measure(seconds: &str) -> Result<(), Failure> {
    if !seconds.parse().is_ok_and(|seconds: u32| (10..=3600).contains(&seconds)) {
        return Err(Failure::usage(format!(
            "--seconds {seconds} is not allowed: it must be a whole number from 10 to 3600"
        )));
    }
    browser()?;
    let mut test = run::cargo(&["test", "--locked", "--release", "--package", "cohold", "--test", "suite", "--"]);
    test.args(["--ignored", "--exact", "--nocapture", "play::how_punctual_and_how_soon"]);
    let said = run::output(test.env("COHOLD_MEASURE_S", seconds))?;
    said.lines().filter(|line| line.starts_with('|')).for_each(|line| println!("{line}"));
    Ok(())
}

/// Makes sure of Chromium, which the page's test drives; without it that test fails.
pub(crate) fn browser() -> Result<(), Failure> {
    if std::env::var_os("CHROMIUM").is_some() {
        return Ok(());
    }
    setup::program("chromium", "chromium")
        .map_or(Ok(()), |obstacle| Err(Failure::new(format!("{obstacle}, or name another Chromium in CHROMIUM"))))
}
