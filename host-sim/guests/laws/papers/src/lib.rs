//! The laws of other papers on the command line ([`join`]), and numbers that their papers print (`NUMBERS`). More than 5 % off needs a reason, in the row.
//! What follows from a paper's equation, and is printed nowhere, is compared in this package's tests.

#![forbid(unsafe_code)]

mod command;
mod measure;

use cohold_cli::{Cli, Ui, columns::TableKind};
use cohold_report::Columns;
use rayon::prelude::*;

use self::command::Papers;
use self::measure as of;
use cohold_studies::Error;
use cohold_studies::reproduce::paper::boundary_n_per_m;

/// Adds the laws of other papers, their proofs, and the numbers of their papers to a command line.
pub fn join(cli: Cli) -> Cli {
    cli.with_laws(cohold_guest_laws::add)
        .with_proofs(cohold_guest_laws::prove)
        .with_commands::<Papers>("paper")
        .with_tables(tables)
}

/// A number of a paper, and how it is measured here.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Number {
    /// The law whose paper it is.
    pub(crate) law: &'static str,
    /// The paper that says it.
    pub(crate) paper: &'static str,
    /// Section, figure or equation.
    pub(crate) place: &'static str,
    /// The quantity that the number measures.
    pub(crate) what: &'static str,
    /// Its unit; nothing for a share.
    pub(crate) unit: &'static str,
    /// What the paper prints.
    pub(crate) theirs: f64,
    ours: fn() -> Result<f64, Error>,
    /// Why it is further off than 5 %; nothing where it is not.
    pub(crate) why: &'static str,
}

/// A number and what came of it.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// The number that was compared.
    pub(crate) number: Number,
    /// The value measured here, in the number's unit.
    pub(crate) ours: f64,
}

impl Row {
    /// How far off, relative to the paper.
    pub(crate) fn off(&self) -> f64 {
        self.ours / self.number.theirs - 1.0
    }
}

const COOPERATION: &str = "Rakhsha & Constantinescu 2012";

/// Every number of the papers that is compared.
#[rustfmt::skip]
pub(crate) const NUMBERS: &[Number] = &[
    Number { law: "power", paper: COOPERATION, place: "§5.2, Fig. 9", what: "mean position discrepancy at 310 N/m", unit: "mm",
        theirs: 3.5, ours: || of::discrepancy_mm("power"),
        why: "it is F_T/K_T in any model, and 1 N over 310 N/m is 3.23 mm; 3.5 mm are a mean push of 1.09 N" },
    Number { law: "power", paper: COOPERATION, place: "§5.1, Fig. 6", what: "largest gain, 16 ms round trip", unit: "N/m",
        theirs: 310.0, ours: || boundary_n_per_m("power", 310.0),
        why: "an experiment's largest stable gain lies inside the region; what the paper leaves open moves its boundary (`cohold paper reproduce`)" },
    Number { law: "wave", paper: COOPERATION, place: "§5.2, Fig. 9", what: "mean position discrepancy at 1590 N/m", unit: "mm",
        theirs: 0.644, ours: || of::discrepancy_mm("wave"), why: "" },
    Number { law: "wave", paper: COOPERATION, place: "§5.1, Fig. 6", what: "largest gain, 16 ms round trip", unit: "N/m",
        theirs: 1590.0, ours: || boundary_n_per_m("wave", 1590.0), why: "" },
    Number { law: "passive-wave", paper: COOPERATION, place: "§5.2, Fig. 9", what: "mean position discrepancy at 10620 N/m", unit: "mm",
        theirs: 0.099, ours: || of::discrepancy_mm("passive-wave"), why: "" },
    Number { law: "passive-wave", paper: COOPERATION, place: "§5.1, Fig. 6", what: "largest gain, 16 ms round trip", unit: "N/m",
        theirs: 10620.0, ours: || boundary_n_per_m("passive-wave", 10620.0), why: "" },
    Number { law: "deadband", paper: "Hinterseer, Hirche, Chaudhuri, Steinbach & Buss 2008", place: "abstract, up to 90 %", what: "packets saved of 1000 /s, a hand that pushes 4 N to and fro once a second", unit: "%",
        theirs: 90.0, ours: of::packets_saved_percent, why: "" },
    Number { law: "none", paper: "Minsky, Ouh-young, Steele, Brooks & Behensky 1990", place: "B/(K·T) > 1/2", what: "b/(K·T) at the first unstable wall, a device of 1 kg", unit: "",
        theirs: 0.5, ours: || of::wall(0.0), why: "" },
];

/// All of it, in the order of the table.
///
/// # Errors
/// Settings that no peer accepts.
fn rows() -> Result<Vec<Row>, Error> {
    let row = |number: &Number| Ok(Row { number: *number, ours: (number.ours)()? });
    NUMBERS.par_iter().map(row).collect()
}

/// Declares the columns of the rows.
pub(crate) fn columns(rows: &[Row]) -> Columns {
    Columns::of(rows)
        .value("law", |row| row.number.law)
        .means("what coordination.comm calls it")
        .value("paper", |row| row.number.paper)
        .means("which paper")
        .value("place", |row| row.number.place)
        .means("section, figure or equation")
        .value("what", |row| row.number.what)
        .means("what the number is of")
        .number("theirs", 4, |row| row.number.theirs)
        .means("what the paper prints")
        .number("ours", 4, |row| row.ours)
        .means("what was measured here")
        .value("unit", |row| Some(row.number.unit).filter(|unit| !unit.is_empty()))
        .means("unit of both")
        .number("off", 1, |row| 100.0 * row.off())
        .means("difference over the paper's, %")
        .value("why", |row| Some(row.number.why).filter(|why| !why.is_empty()))
        .means("why it is more than 5 % off")
        .done()
}

/// Its kind of table.
fn tables(_: &Ui) -> Vec<TableKind> {
    vec![TableKind::new("published", "`paper published --json`", "a number of a law's paper", columns(&[]))]
}

#[cfg(test)]
#[path = "../tests/inside/papers.rs"]
mod tests;
