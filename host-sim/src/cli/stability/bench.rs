//! `host-sim stability bench`: spectral radii per second.

use clap::Args;

use crate::cli::{Failure, Ui};
use haptic_analysis::speed;
use haptic_sim::report::Columns;

/// Arguments of `stability bench`.
#[derive(Debug, Args)]
pub(in crate::cli) struct Bench {
    /// Radii on each thread.
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    radii: u32,
}

impl Bench {
    /// Answers.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let mut counts = vec![1, cores];
        counts.dedup();
        let speeds = counts
            .into_iter()
            .map(|threads| speed::measure(self.radii as usize, threads))
            .collect::<Result<Vec<_>, _>>()?;
        let table = Columns::of(&speeds)
            .value("threads", |speed| speed.threads)
            .value("states", |speed| speed.states)
            .number("radii_per_s", 0, |speed| speed.radii_per_s)
            .number("radii_per_s_and_core", 0, |speed| speed.radii_per_s_and_core)
            .head("radii/s and core")
            .number("checksum", 9, |speed| speed.checksum)
            .done();
        ui.result(&table)?;
        writeln!(ui, "The same work in NumPy: python3 tests/oracle/numpy_speed.py");
        Ok(())
    }
}
