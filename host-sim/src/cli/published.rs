//! `host-sim published`: numbers of the laws' own papers beside what the laws do here, and every law's region by two constructions.

use clap::Args;
use haptic_studies::reproduce::published::{columns, regions, rows};

use super::{Failure, Ui};

#[derive(Debug, Args)]
pub(super) struct Published {
    /// Instead: the first unstable stiffness of every law by two constructions, the lifted matrix and runs that grow or die away.
    #[arg(long)]
    regions: bool,
}

impl Published {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        if self.regions {
            let (found, _) = ui.work(ui.laws.all().len(), "laws", |step| regions::regions(ui.laws, step))?;
            return ui.result(&regions::columns(&found));
        }
        ui.only_built_in("published compares");
        let (found, _) = ui.work(1, "papers", |_| rows())?;
        ui.result(&columns(&found))
    }
}
