//! `host-sim campaign`: every kind of communications over every kind of bad network.

use clap::Args;

use super::{Failure, print_json};
use crate::experiment::campaign::campaign;
use crate::report::text::TextTable;

/// Arguments of `campaign`.
#[derive(Debug, Args)]
pub(super) struct Campaign {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Campaign {
    /// Runs the cells and prints the table.
    ///
    /// # Errors
    /// None but a mistake in the campaign itself.
    pub(super) fn run(&self) -> Result<(), Failure> {
        let cells = campaign().map_err(|error| error.to_string())?;
        if self.json {
            return print_json(&cells);
        }
        let mut table =
            TextTable::new(["comm", "network", "stable", "energy out/in", "peak N", "jump N", "true mm", "fault"]);
        for cell in cells {
            table.push([
                cell.comm,
                cell.impairment,
                if cell.stable { "yes" } else { "NO" }.to_owned(),
                format!("{:.4}", cell.energy_out_over_in),
                format!("{:.2}", cell.peak_force_n),
                format!("{:.3}", cell.largest_jump_n),
                format!("{:.2}", cell.true_discrepancy_mm),
                cell.fault.unwrap_or_default(),
            ]);
        }
        println!("{table}");
        Ok(())
    }
}
