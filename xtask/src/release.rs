//! `cargo xtask release`: the board's image of a tag, as files to give away.
//!
//! Built from a clone of the tag, so that nothing is in it that is not committed, and without this machine's paths, so that the same
//! toolchain makes the same bytes anywhere: the sum beside the image is there to be compared.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use crate::options::Options;
use crate::run::{self, Failure, command, output, run, step};
use crate::setup::{self, Ready, THUMB_TARGET};

/// Makes the files.
pub(crate) fn release(given: &Options<'_>) -> Result<(), Failure> {
    let tag = match given.value("--tag") {
        Some(tag) => tag.to_owned(),
        None => output(&mut command("git", &["describe", "--exact-match", "--tags", "HEAD"]))
            .map_err(|_| {
                Failure::new("what is checked out has no tag: `git tag v0.1.0` gives it one, --tag names another")
            })?
            .trim()
            .to_owned(),
    };
    let ready = step("set-up", setup::setup)?;
    let source = run::root().join("target/tagged").join(&tag);
    step("source", || checked_out(&tag, &source))?;
    let manifest = run::read(&source.join("Cargo.toml"))?;
    is_of(&tag, &manifest)?;
    let mut build = build(&ready, &source)?;
    step("image", || run(&mut build))?;

    let folder = run::root().join(given.value("--out").unwrap_or("out/release")).join(&tag);
    let name = format!("haptic-{tag}.elf");
    let written = |cause: std::io::Error| Failure::new(format!("cannot write {}: {cause}", folder.display()));
    fs::create_dir_all(&folder).map_err(written)?;
    fs::copy(source.join("target").join(THUMB_TARGET).join("firmware/firmware"), folder.join(&name))
        .map_err(written)?;
    let commit = output(command("git", &["rev-parse", "HEAD"]).current_dir(&source))?;
    let compiler = output(&mut rustc(&ready, &["-vV"]))?;
    fs::write(folder.join("BUILD.txt"), format!("tag: {tag}\ncommit: {commit}{compiler}")).map_err(written)?;
    let sums = output(command("sha256sum", &[&name, "BUILD.txt"]).current_dir(&folder))?;
    fs::write(folder.join("SHA256SUMS"), &sums).map_err(written)?;
    print!("{sums}");
    eprintln!("    in {}: to flash it, `probe-rs download --chip STM32H743ZITx {name}`", folder.display());
    Ok(())
}

/// The tag in a folder of its own, as it was committed.
fn checked_out(tag: &str, source: &Path) -> Result<(), Failure> {
    if source.exists() {
        fs::remove_dir_all(source)
            .map_err(|cause| Failure::new(format!("cannot remove {}: {cause}", source.display())))?;
    }
    let [from, to] = [run::root(), source].map(|path| path.to_string_lossy().into_owned());
    run(&mut command("git", &["-c", "advice.detachedHead=false", "clone", "--quiet", "--branch", tag, &from, &to]))
}

/// A tag is `v` and the version that the workspace says.
fn is_of(tag: &str, manifest: &str) -> Result<(), Failure> {
    let version = manifest.lines().find_map(|line| line.strip_prefix("version = \"")?.strip_suffix('"')).unwrap_or("?");
    let expected = format!("v{version}");
    if tag == expected {
        Ok(())
    } else {
        Err(Failure::new(format!(
            "the tag {tag} is not of version {version}, which its Cargo.toml says: {expected} is"
        )))
    }
}

/// The image's build; what it says of where it was built is the same everywhere.
fn build(ready: &Ready, source: &Path) -> Result<Command, Failure> {
    let compiler = output(&mut rustc(ready, &["-vV"]))?;
    let hash = compiler.lines().find_map(|line| line.strip_prefix("commit-hash: ")).unwrap_or("unknown");
    let sysroot = output(&mut rustc(ready, &["--print", "sysroot"]))?;
    let home = env::var_os("CARGO_HOME").map(PathBuf::from).or_else(|| Some(env::home_dir()?.join(".cargo")));
    let home =
        home.ok_or_else(|| Failure::new("neither CARGO_HOME nor a home directory says where cargo keeps crates"))?;
    let flags = [
        format!("{}=/haptic", source.display()),
        format!("{}=/cargo", home.display()),
        // Where the library's sources are installed they are named as there, and elsewhere like this.
        format!("{}/lib/rustlib/src/rust=/rustc/{hash}", sysroot.trim()),
    ];
    let flags = flags.map(|from_to| format!("'--remap-path-prefix={from_to}'"));
    let flags = format!("target.{THUMB_TARGET}.rustflags=[{}]", flags.join(","));
    let words = ["--config", &flags, "build", "--locked", "--profile", "firmware", "--package", "firmware"];
    let mut build = ready.cargo(&words);
    build.args(["--bin", "firmware", "--target", THUMB_TARGET]).current_dir(source);
    build.env("CARGO_TARGET_DIR", source.join("target"));
    // Set by hand, they would take the place of the project's.
    ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "DEFMT_LOG"].into_iter().for_each(|name| _ = build.env_remove(name));
    Ok(build)
}

fn rustc(ready: &Ready, arguments: &[&str]) -> Command {
    let mut rustc = command("rustc", arguments);
    rustc.env("RUSTUP_TOOLCHAIN", &ready.thumb_toolchain);
    rustc
}

#[cfg(test)]
#[path = "../tests/inside/release.rs"]
mod tests;
