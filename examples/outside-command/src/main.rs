//! A command and the study behind it from outside: the paper's default scene over growing delays, a row for each, as a table or as JSON.
//!
//! ```text
//! cargo run -- delays --most 4
//! cargo run -- --json delays
//! cargo run -- --help
//! ```

use std::error::Error;

use cohold_analysis::conclude;
use cohold_report::Columns;
use cohold_sim::{Laws, Options, Scene, run};

/// True discrepancy under a push of 1 N from both sides, over one-way delays.
#[derive(clap::Args)]
struct Delays {
    /// Longest delay, packet periods.
    #[arg(long, default_value = "3")]
    most: u32,
}

fn delays(asked: &Delays, laws: Laws) -> Result<Columns, Box<dyn Error + Send + Sync>> {
    let mut rows = Vec::new();
    for packets in 0..=asked.most {
        let delay = format!("network.one_way_delay_packets={packets}");
        let scene = Scene::load(laws, None, &[delay, "user.1.push_n=1".into(), "user.2.push_n=1".into()])?;
        let outcome = run::<f64>(&scene, Options { duration_s: 5.0, record_every: 0 }, &|_| ())?;
        rows.push((packets, conclude(&scene, outcome)?.outcome));
    }
    Ok(Columns::of(&rows)
        .value("one_way_delay_packets", |(packets, _)| *packets)
        .value("verdict", |(_, outcome)| outcome.verdict().name())
        .number("true_discrepancy_mm", 3, |(_, outcome)| outcome.metric(|outcome| outcome.whole.true_discrepancy_mm))
        .done())
}

fn main() -> std::process::ExitCode {
    cohold::command_line().with_command("delays", delays).main()
}
