//! `cargo xtask release`: a tag as files to give away.
//!
//! Built from a clone of the tag, so that nothing is in it that is not committed. The boards' images are without this machine's paths, so that
//! the same toolchain makes the same bytes anywhere: the sum beside each is there to be compared. Nothing is uploaded.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use crate::options::Options;
use crate::run::{self, Failure, cargo, command, output, run, step};
use crate::setup::{self, Ready, THUMB_TARGET};
use crate::{board, packages, python};

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
    let flags = without_paths(&ready, &source)?;

    let folder = run::root().join(given.value("--out").unwrap_or("out/release")).join(&tag);
    let written = |cause: std::io::Error| Failure::new(format!("cannot write {}: {cause}", folder.display()));
    let give = |from: PathBuf, name: &str| fs::copy(from, folder.join(name)).map(drop).map_err(written);
    fs::create_dir_all(&folder).map_err(written)?;
    let built = source.join("target");
    for (features, name) in board::IMAGES.iter().zip(images(&tag)) {
        let mut build = image(&ready, &source, features, &flags);
        step(&name, || run(&mut build))?;
        give(built.join(THUMB_TARGET).join("firmware/firmware"), &name)?;
    }

    let machine = format!("{}-{}", env::consts::ARCH, env::consts::OS);
    let wider = WIDER.into_iter().filter(|_| env::consts::ARCH == "x86_64" && cfg!(unix));
    for level in std::iter::once("").chain(wider) {
        let (mut build, made) = python::build_by_zig()?;
        build.args(["--locked", "--release", "--package", "cohold"]).current_dir(&source);
        let mut name = format!("cohold-{tag}-{machine}");
        if !level.is_empty() {
            // Added to the flags that the project has for every x86-64.
            let flags = format!("target.'cfg(target_arch = \"x86_64\")'.rustflags=['-Ctarget-cpu={level}']");
            build.args(["--config", &flags]);
            // The other one looks for it under this name.
            name = format!("{name}-{level}");
        }
        let folder = built.join("cohold").join(level);
        step(&name, || run(build.env("CARGO_TARGET_DIR", &folder)))?;
        give(folder.join(made).join("cohold"), &name)?;
    }
    step("wheel", || python::wheel(&source, &folder, "release").map(drop))?;
    step("sources", || {
        let sources = packages::sdist(&source, &built.join("sdist"))?;
        give(sources.clone(), &sources.file_name().unwrap_or_default().to_string_lossy())
    })?;
    let mut package = cargo(&["package", "--locked", "--no-verify"]);
    package.args(packages::named()).current_dir(&source).env("CARGO_TARGET_DIR", &built);
    step("crates", || run(&mut package))?;
    let version = &tag[1..];
    for name in packages::CRATES.map(|name| format!("{name}-{version}.crate")) {
        give(built.join("package").join(&name), &name)?;
    }
    step("what is in them", || {
        let tools = run::root().join("target/tools");
        let mut install =
            cargo(&["install", "--quiet", "--locked", "--version", CYCLONEDX, "cargo-cyclonedx", "--root"]);
        run(install.arg(&tools))?;
        let list = |of: &[&str]| {
            let program = tools.join("bin/cargo-cyclonedx");
            let mut list = command(&program.to_string_lossy(), &["cyclonedx", "--format", "json"]);
            run(list.args(of).current_dir(&source))
        };
        // Beside each manifest, of which that of the command line has all that runs on a PC.
        list(&[])?;
        // All images': the others have nothing that the one for USB has not.
        list(&["--manifest-path", "firmware/Cargo.toml", "--features", "usb", "--target", THUMB_TARGET])
    })?;
    for (package, name) in [("host-sim", "cohold"), ("firmware", "firmware"), ("host-sim/python", "cohold-python")] {
        let list = format!("{name}.cdx.json");
        give(source.join(package).join(&list), &list)?;
    }

    let commit = output(command("git", &["rev-parse", "HEAD"]).current_dir(&source))?;
    let compiler = output(&mut rustc(&ready, &["-vV"]))?;
    fs::write(folder.join("BUILD.txt"), format!("tag: {tag}\ncommit: {commit}{compiler}")).map_err(written)?;
    let mut names: Vec<_> = fs::read_dir(&folder).map_err(written)?.flatten().map(|entry| entry.file_name()).collect();
    names.retain(|name| name != SUMS);
    names.sort();
    let sums = output(command("sha256sum", &[]).args(names).current_dir(&folder))?;
    fs::write(folder.join(SUMS), &sums).map_err(written)?;
    print!("{sums}");
    eprintln!(
        "    in {}: to flash a board, `probe-rs download --chip STM32H743ZITx haptic-{tag}.elf`",
        folder.display()
    );
    Ok(())
}

/// Levels of x86-64 that the command line is built for once more each (host-sim/cli/src/vectors.rs).
const WIDER: [&str; 2] = ["x86-64-v3", "x86-64-v4"];
/// The sums' own file.
const SUMS: &str = "SHA256SUMS";
/// Version of cargo-cyclonedx.
const CYCLONEDX: &str = "0.5.9";

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

/// The images' files: the usual one's, and those of the images beside it.
fn images(tag: &str) -> impl Iterator<Item = String> {
    let besides = board::BESIDES.iter().map(|name| name.trim_start_matches("firmware"));
    std::iter::once("").chain(besides).map(move |which| format!("haptic-{tag}{which}.elf"))
}

/// An image's build.
fn image(ready: &Ready, source: &Path, features: &[&str], flags: &str) -> Command {
    let mut build = board::build(ready, "build", features);
    build.args(["--config", flags]).current_dir(source).env("CARGO_TARGET_DIR", source.join("target"));
    // Set by hand, they would take the place of the project's.
    ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "DEFMT_LOG"].into_iter().for_each(|name| _ = build.env_remove(name));
    build
}

/// Flags with which what an image says of where it was built is the same everywhere.
fn without_paths(ready: &Ready, source: &Path) -> Result<String, Failure> {
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
    Ok(format!("target.{THUMB_TARGET}.rustflags=[{}]", flags.join(",")))
}

fn rustc(ready: &Ready, arguments: &[&str]) -> Command {
    let mut rustc = command("rustc", arguments);
    rustc.env("RUSTUP_TOOLCHAIN", &ready.thumb_toolchain);
    rustc
}

#[cfg(test)]
#[path = "../tests/inside/release.rs"]
mod tests;
