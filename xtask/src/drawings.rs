//! `cargo xtask drawings`: the board's wiring, drawn. Netlist, rules and drawing are a package of their own, firmware/wiring.

use crate::run::{self, Failure, cargo};

/// Writes drawings and tables, or fails where they are not what the netlist says.
pub(crate) fn drawings(check: bool) -> Result<(), Failure> {
    let draw = ["run", "--quiet", "--locked", "--package", "cohold-wiring", "--"];
    run::run(cargo(&draw).args(check.then_some("--check")))
}
