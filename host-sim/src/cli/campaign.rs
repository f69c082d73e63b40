//! `host-sim campaign`: every kind of communications over every kind of bad network, and what each costs.

use clap::Args;

use super::{Failure, Ui};
use crate::studies::campaign::{campaign, columns, cost_columns, costs};

#[derive(Debug, Args)]
pub(super) struct Campaign {
    /// Instead: what every way to hold the copies together costs in delay, true discrepancy and transparency.
    #[arg(long)]
    costs: bool,
}

impl Campaign {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let table = if self.costs { cost_columns(&costs(ui.laws)?) } else { columns(&campaign(ui.laws)?) };
        ui.result(&table)
    }
}
