//! Gives the linker the root's memory.x and the scripts of cortex-m-rt and defmt, from whatever directory cargo runs in.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../memory.x");
    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os != "none") {
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy("../memory.x", out.join("memory.x")).expect("memory.x stands in the root");
    println!("cargo::rustc-link-search={}", out.display());
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo::rustc-link-arg-bin=firmware={argument}");
    }

    // The proof that tick and current loop cannot panic starts at both interrupts, or at the mistake planted after them.
    println!("cargo::rerun-if-changed=no_panic.x");
    fs::copy("no_panic.x", out.join("no_panic.x")).expect("no_panic.x stands here");
    let start = if env::var_os("CARGO_FEATURE_PLANTED_PANIC").is_some() { "planted" } else { "both" };
    for argument in ["--nmagic", "-Tno_panic.x", "--gc-sections", "--orphan-handling=error", "-e", start] {
        println!("cargo::rustc-link-arg-bin=no-panic={argument}");
    }
}
