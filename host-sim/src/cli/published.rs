//! `host-sim published`: numbers of the laws' own papers beside what the laws do here.

use crate::published::{columns, rows};
use clap::Args;

use super::{Failure, Ui};

#[derive(Debug, Args)]
pub(super) struct Published;

impl Published {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        ui.only_built_in("published compares");
        let (found, _) = ui.work(1, "papers", |_| rows())?;
        ui.result(&columns(&found))
    }
}
