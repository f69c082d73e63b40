//! `host-sim stability`: regions, limits and margins.

use clap::Args;

use super::Failure;

/// Arguments of `stability`.
#[derive(Debug, Args)]
pub struct Stability {}

impl Stability {
    /// Runs the command.
    ///
    /// # Errors
    /// A bad scene, key or range, or a file that cannot be written.
    pub fn run(&self) -> Result<(), Failure> {
        Ok(())
    }
}
