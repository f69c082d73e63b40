//! `cargo xtask rig`: what two bare boards are to show on silicon. List and page are a package of their own, tests/rig; the bench (tests/board)
//! runs it on two virtual boards.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::board::{self, bench, target};
use crate::run::{self, Failure, cargo, run, step};
use crate::setup::{self, Ready, THUMB_TARGET};

/// Prints what each test would do, writes docs/silicon.md, or runs what two virtual boards can.
pub(crate) fn rig(page: bool, virtually: bool) -> Result<(), Failure> {
    if virtually {
        let ready = step("set-up", setup::setup)?;
        let firmware = step("image", || board::image(&ready))?;
        return step("rig", || on_virtual_boards(&ready, &firmware));
    }
    let mut rig = cargo(&["run", "--quiet", "--locked", "--package", "haptic-rig", "--bin", "haptic-rig"]);
    if page {
        return run(rig.args(["--", "--page"]));
    }
    print!("{}", run::output(&mut rig)?);
    Ok(())
}

/// Builds the rig's image and runs the list with the release image on one virtual board and that one on another.
pub(crate) fn on_virtual_boards(ready: &Ready, firmware: &Path) -> Result<(), Failure> {
    let image = image(ready)?;
    if Some(image.parent()) != Some(firmware.parent()) {
        return Err(Failure::new(format!("{} is not beside {}", image.display(), firmware.display())));
    }
    run(&mut bench(&["run", "--bin", "rigged"], firmware))
}

/// Builds the rig's image, which links only if it cannot panic, and says where it is.
pub(crate) fn image(ready: &Ready) -> Result<PathBuf, Failure> {
    run(&mut build(ready, "build"))?;
    Ok(target().join(THUMB_TARGET).join("firmware/rig"))
}

/// Cargo on the rig's image: `build`, or `clippy`.
pub(crate) fn build(ready: &Ready, what: &str) -> Command {
    let mut build = ready.cargo(&[what, "--locked", "--profile", "firmware", "--package", "haptic-rig"]);
    build.args(["--bin", "rig", "--target", THUMB_TARGET]);
    build
}
