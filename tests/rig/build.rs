//! Gives the linker the rig's own script.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=rig.x");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os != "none") {
        return;
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/rig.x");
    for argument in ["--nmagic", "--gc-sections", &format!("-T{script}")] {
        println!("cargo::rustc-link-arg-bin=rig={argument}");
    }
}
