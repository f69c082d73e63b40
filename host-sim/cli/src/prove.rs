//! `cohold stability prove`: forces stay within their limits, law by law.

use std::path::PathBuf;

use clap::Args;
use cohold_studies::campaign::laws::page;
use cohold_studies::proof;
use rayon::prelude::*;
use serde_json::json;

use super::{Failure, Ui};

#[derive(Debug, Args)]
pub(super) struct Prove {
    /// One law instead of all of them.
    #[arg(long, value_name = "NAME")]
    law: Option<String>,
    /// Also write it into the page of the laws, between the lines of the proofs.
    #[arg(long, value_name = "FILE", conflicts_with = "law")]
    page: Option<PathBuf>,
}

impl Prove {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        Ui::have(self.page.as_slice(), &[page::PROOFS])?;
        ui.only_built_in("prove looks at");
        let names = proof::names(ui.laws);
        let asked = match &self.law {
            Some(name) if names.contains(&name.as_str()) => vec![name.as_str()],
            Some(name) => return Err(format!("--law {name} is not allowed: one of {}", names.join(", ")).into()),
            None => names,
        };
        let (rows, _) = ui.work(asked.len(), "laws", |step| {
            let of = |name: &&str| {
                let row = proof::row(name, ui.prover);
                step();
                row
            };
            Ok::<Vec<_>, Failure>(asked.par_iter().filter_map(of).collect())
        })?;
        let table = proof::columns(&rows);
        ui.document(&json!({ "laws": table }))?;
        let report = proof::report(&table);
        writeln!(ui, "{report}");
        ui.wrote(&Ui::rewrite(self.page.as_slice(), &[(page::PROOFS, proof::section(&report))], None)?);
        Ok(())
    }
}
