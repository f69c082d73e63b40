//! `host-sim campaign`: every kind of communications, or one scene, over every kind of bad network, and what each costs.

use clap::Args;

use super::{Failure, SceneArgs, Ui};
use crate::studies::campaign::{campaign, columns, cost_columns, costs, of_scene};

#[derive(Debug, Args)]
pub(super) struct Campaign {
    #[command(flatten)]
    scene: SceneArgs,
    /// Instead: what every way to hold the copies together costs in delay, true discrepancy and transparency.
    #[arg(long, conflicts_with_all = ["scene", "set", "seed"])]
    costs: bool,
}

impl Campaign {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let table = if self.costs {
            cost_columns(&costs(ui.laws)?)
        } else if self.scene.is_given() {
            columns(&of_scene(ui.laws, &self.scene.name(), &self.scene.load(ui)?)?)
        } else {
            columns(&campaign(ui.laws)?)
        };
        ui.result(&table)
    }
}
