//! `cohold paper published`: numbers of the laws' own papers beside what the laws do here.

use clap::Args;
use cohold_cli::{Failure, Ui};

use super::{columns, rows};

cohold_cli::commands! {
    /// Of the laws of other papers.
    pub(crate) Papers {
        /// Numbers of the laws' own papers beside what the laws do here.
        Published(Published),
    }
}

#[derive(Debug, Args)]
pub(super) struct Published;

impl Published {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        ui.only_built_in("published compares");
        let (found, _) = ui.work(1, "papers", |_| rows())?;
        ui.result(&columns(&found))
    }
}
