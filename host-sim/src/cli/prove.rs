//! `host-sim prove`: forces stay within their limits, law by law.

use clap::Args;
use haptic_core::settings::Settings;
use rayon::prelude::*;
use serde_json::json;

use super::{Failure, Ui};
use crate::studies::proof;

#[derive(Debug, Args)]
pub(super) struct Prove {
    /// One law instead of all of them.
    #[arg(long, value_name = "NAME")]
    law: Option<String>,
}

impl Prove {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        ui.only_built_in("prove looks at");
        let names = proof::names();
        let asked = match &self.law {
            Some(name) if names.contains(&name.as_str()) => vec![name.as_str()],
            Some(name) => return Err(format!("--law {name} is not allowed: one of {}", names.join(", ")).into()),
            None => names,
        };
        let rows: Vec<_> = asked.par_iter().filter_map(|name| proof::row(name)).collect();
        let table = proof::columns(&rows);
        let safety = Settings::default().safety;
        ui.document(&json!({ "laws": table }))?;
        writeln!(
            ui,
            "Every way through a tick, from any state, with any reading and any finite packet: forces stay within {} N and change by no\n\
             more than {} N in a tick of 1 ms (and its rounding), or are off; duties stay within motor.max_duty; what is sent is finite\n",
            safety.max_force_n,
            1e-3 * safety.max_slew_n_per_s
        );
        ui.table(&table);
        writeln!(
            ui,
            "(any law): what the law does not matter, for it gives any number, infinite or none, in each tick."
        );
        Ok(())
    }
}
