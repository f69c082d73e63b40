//! `host-sim campaign`: every kind of communications over every kind of bad network, and what each costs.

use clap::Args;

use super::{Failure, Ui};
use crate::studies::campaign::campaign;
use crate::studies::costs::costs;
use haptic_sim::report::text::TextTable;

/// Arguments of `campaign`.
#[derive(Debug, Args)]
pub(super) struct Campaign {
    /// Instead: what every way to hold the copies together costs in delay, true discrepancy and transparency.
    #[arg(long)]
    costs: bool,
}

impl Campaign {
    /// Runs the cells and prints the table.
    ///
    /// # Errors
    /// None but a mistake in the campaign itself.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        if self.costs {
            return self.costs(ui);
        }
        let cells = campaign().map_err(|error| error.to_string())?;
        ui.document(&cells)?;
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
        ui.table(&table);
        Ok(())
    }
    fn costs(&self, ui: &Ui) -> Result<(), Failure> {
        let costs = costs().map_err(|error| error.to_string())?;
        ui.document(&costs)?;
        let mut table = TextTable::new([
            "network",
            "comm",
            "stable",
            "energy out/in",
            "added delay ms",
            "true mm",
            "mass kg",
            "drag N·s/m",
        ]);
        let number =
            |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |value| format!("{value:.digits$}"));
        for cost in costs {
            table.push([
                cost.network,
                cost.choice,
                if cost.stable { "yes" } else { "NO" }.to_owned(),
                format!("{:.4}", cost.energy_out_over_in),
                number(cost.added_delay_ms, 1),
                format!("{:.2}", cost.true_discrepancy_mm),
                number(cost.apparent_mass_kg, 3),
                number(cost.drag_n_s_per_m, 2),
            ]);
        }
        ui.table(&table);
        Ok(())
    }
}
