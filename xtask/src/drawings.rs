//! `cargo xtask drawings`: the board's wiring, drawn. Netlist, rules and drawing are a package of their own, firmware/wiring.

use crate::run::{self, Failure, cargo};

/// Writes drawings and tables, or fails where they are not what the netlist says.
pub(crate) fn drawings(check: bool) -> Result<(), Failure> {
    let mut draw = cargo(&["run", "--quiet", "--locked", "--package", "haptic-wiring"]);
    if check {
        draw.args(["--", "--check"]);
    }
    run::run(&mut draw)
}
