//! Gives the linker the rig's own script.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=rig.x");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os != "none") {
        return;
    }
    // Asked when it runs: a folder for builds that checkouts share keeps this program of another one.
    let here = std::env::var("CARGO_MANIFEST_DIR").expect("cargo says where the package is");
    for argument in ["--nmagic", "--gc-sections", &format!("-T{here}/rig.x")] {
        println!("cargo::rustc-link-arg-bin=rig={argument}");
    }
}
