//! The step `qemu`: a second opinion on the processor. cohold-core alone under QEMU's Cortex-M7 (tests/qemu) must compute what
//! cohold computes, bit for bit, and must turn its outputs off first when it panics or runs out of stack.

use std::path::Path;

use crate::run::{self, Failure, command};
use crate::setup::{self, Ready, THUMB_TARGET};

/// Built-in scenes that are replayed, either peer. One with encoders and duties among them.
const SCENES: [&str; 5] =
    ["paper-5.2-power-16ms", "paper-5.2-wave-16ms", "paper-5.2-passive-wave-16ms", "person-reach", "real-device"];
/// Of each, s.
const SECONDS: &str = "5";
/// The machine: a Cortex-M7 with its double-precision FPU.
const MACHINE: [&str; 10] =
    ["-M", "mps2-an500", "-display", "none", "-monitor", "none", "-serial", "none", "-nic", "none"];

/// Why it cannot be checked here, if so; installs QEMU where that is all that is missing.
pub(crate) fn obstacle() -> Option<String> {
    setup::program("qemu-system-arm", "qemu-system-arm")
}

/// Builds, records, replays, compares; then the two endings.
pub(crate) fn qemu(ready: &Ready) -> Result<(), Failure> {
    let folder = run::root().join("tests/qemu");
    let target = run::root().join("target/qemu");
    let mut build = ready.cargo(&["build", "--locked", "--release"]);
    run::compile(build.env("CARGO_TARGET_DIR", &target).current_dir(&folder))?;
    let image = target.join(THUMB_TARGET).join("release/second-opinion");
    let cohold = run::cohold(false)?.display().to_string();
    let recording = target.join("recording.bin");
    let name = recording.display().to_string();
    for scene in SCENES {
        for number in ["1", "2"] {
            let mut record = command(&cohold, &["board", "record"]);
            record.args(["--scene", scene, "--number", number, "--seconds", SECONDS, &name]);
            let (ours, theirs) = (run::output(&mut record)?, told(&image, "replay", &name)?);
            if ours.trim().is_empty() || ours.trim() != theirs.trim() {
                return Err(Failure::new(format!(
                    "{scene}, peer {number}: cohold computes {}, QEMU's Cortex-M7 {}",
                    ours.trim(),
                    theirs.trim()
                )));
            }
            eprintln!("    {scene}, peer {number}: {}", theirs.trim());
        }
    }
    for (mode, expected) in
        [("panic", "panic after 1001 ticks, outputs 0x0"), ("overflow", "stack overflow after 1001 ticks, outputs 0x0")]
    {
        let said = told(&image, mode, &name)?;
        if said.trim() != expected {
            return Err(Failure::new(format!("{mode}: it says {:?} and not {expected:?}", said.trim())));
        }
        eprintln!("    {}", said.trim());
    }
    Ok(())
}

/// What the program says.
fn told(image: &Path, mode: &str, recording: &str) -> Result<String, Failure> {
    // It ends by itself; what hangs is ended from outside.
    let mut qemu = command("timeout", &["60", "qemu-system-arm"]);
    qemu.args(MACHINE).arg("-semihosting-config");
    qemu.arg(format!("enable=on,target=native,arg={mode},arg={recording}")).arg("-kernel").arg(image);
    run::output(&mut qemu)
}
