//! `cohold board bringup`: the first hour with a board and its device, step by step.

use clap::Args;
use cohold_board_tools::bringup::{Plan, bring_up};
use cohold_board_tools::calibrate::settings_file;

use super::calibrate::{At, By, DataSheet, Reference};
use crate::{Failure, Ui};

#[derive(Debug, Args)]
pub(crate) struct BringUp {
    #[command(flatten)]
    at: At,
    #[command(flatten)]
    by: By,
    #[command(flatten)]
    reference: Reference,
    #[command(flatten)]
    sheet: DataSheet,
}

impl BringUp {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let (distance, against) = (self.by.distance()?, self.reference.against()?);
        let (mut board, mut person) = self.at.parties(ui)?;
        let file = self.at.settings.as_path();
        if file.exists() {
            settings_file::give(&mut *board, file)?;
        }
        let plan = Plan { joint: self.at.joint, distance, sheet: self.sheet.sheet(), against, file };
        let passed = bring_up(&mut *board, &mut *person, plan, |passed| {
            ui.status(format_args!("{}: passed: {}", passed.step, passed.seen));
        })?;
        ui.report("", &passed)?;
        ui.status(format_args!("what was found is in {}; `save` keeps it on the board", file.display()));
        Ok(())
    }
}
