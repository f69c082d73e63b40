//! `host-sim campaign`: every kind of communications over every kind of bad network, and what each costs.

use clap::Args;

use super::{Failure, Ui};
use crate::studies::{campaign, costs};

/// Arguments of `campaign`.
#[derive(Debug, Args)]
pub(super) struct Campaign {
    /// Instead: what every way to hold the copies together costs in delay, true discrepancy and transparency.
    #[arg(long)]
    costs: bool,
}

impl Campaign {
    /// Runs the cells and prints the table.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let table = if self.costs {
            costs::columns(&costs::costs(ui.laws).map_err(|error| error.to_string())?)
        } else {
            campaign::columns(&campaign::campaign(ui.laws).map_err(|error| error.to_string())?)
        };
        ui.result(&table)
    }
}
