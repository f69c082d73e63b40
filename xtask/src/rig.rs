//! `cargo xtask rig`: what two bare boards are to show on silicon. List and page are a package of their own, tests/rig.

use crate::run::{self, Failure, cargo};

/// Prints what each test would do, or writes docs/silicon.md.
pub(crate) fn rig(page: bool) -> Result<(), Failure> {
    let mut rig = cargo(&["run", "--quiet", "--locked", "--package", "haptic-rig"]);
    if page {
        return run::run(rig.args(["--", "--page"]));
    }
    print!("{}", run::output(&mut rig)?);
    Ok(())
}
