//! `cargo xtask board`: two virtual boards run a scene; a table beside host-sim's, curves, pictures.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use board_bench::image::Firmware;
use board_bench::trial::{self, Trial};
use clap::Parser;
use haptic_sim::report::files;
use haptic_sim::report::text::TextTable;
use haptic_sim::run::Outcome;
use host_sim::cli::SceneArgs;
use host_sim::studies::figures;
use serde_json::json;

/// The scene that is run without `--scene`: the cooperation paper's §5.2, passive wave.
const USUAL: &str = "paper-5.2-passive-wave-16ms";

/// Two virtual NUCLEO-H743ZI2 run the unmodified release image, on one wire, closed around host-sim's devices.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask board")]
struct Arguments {
    #[command(flatten)]
    scene: SceneArgs,
    /// Virtual time, s.
    #[arg(long, default_value_t = 20.0, value_name = "S", allow_negative_numbers = true)]
    seconds: f64,
    /// Print JSON; files are written only with --out.
    #[arg(long)]
    json: bool,
    /// Folder for CSV and pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("board: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn std::error::Error>> {
    if !(arguments.seconds >= 1.0 && arguments.seconds <= 3600.0) {
        return Err(
            format!("--seconds {} is not allowed: it must be a number from 1 to 3600", arguments.seconds).into()
        );
    }
    let (scene, name) = (arguments.scene.load_or(USUAL)?, arguments.scene.name_or(USUAL));
    let firmware = Arc::new(Firmware::release());
    let trial = trial::run(&firmware, &scene, arguments.seconds)?;
    let folder = match (&arguments.out, arguments.json) {
        (None, false) => Some(PathBuf::from("out/board")),
        (out, _) => out.clone(),
    };
    let mut written = Vec::new();
    if let Some(folder) = folder {
        let base = folder.join(&name);
        written.push(folder.join(format!("{name}.csv")));
        files::write_csv(&trial.boards.table, &written[0])?;
        written.extend(figures::run(&format!("{name}, two virtual boards"), &trial.boards, &base)?);
    }
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&document(&name, &trial, &written))?);
    } else {
        print(&name, &trial);
        for file in &written {
            println!("wrote {}", file.display());
        }
    }
    Ok(())
}

fn fault(outcome: &Outcome) -> Option<String> {
    outcome.fault.map(|(peer, fault)| format!("peer {peer} stopped with fault {}: {}", fault.number(), fault.explain()))
}

fn document(name: &str, trial: &Trial, written: &[PathBuf]) -> serde_json::Value {
    let Trial { boards, host_sim, .. } = trial;
    json!({
        "scene": name,
        "decoded_discrepancy_mm": boards.decoded_discrepancy_mm,
        "true_discrepancy_mm": boards.true_discrepancy_mm,
        "coordination_force_n": boards.coordination_force_n,
        "peak_coordination_force_n": boards.peak_coordination_force_n,
        "fault": fault(boards),
        "host_sim": {
            "decoded_discrepancy_mm": host_sim.decoded_discrepancy_mm,
            "true_discrepancy_mm": host_sim.true_discrepancy_mm,
            "coordination_force_n": host_sim.coordination_force_n,
            "fault": fault(host_sim),
        },
        "ticks": boards.ticks,
        "ticks_missed": trial.ticks_missed,
        "packets_sent": trial.packets_sent,
        "packets_received": trial.packets_received,
        "packets_dropped": trial.packets_dropped,
        "wire_lost": trial.wire_lost,
        "equal_ticks": trial.equal.ticks,
        "first_difference": trial.equal.first_difference,
        "replayed_ticks": trial.replayed.map(|equal| equal.ticks),
        "instructions_per_tick": { "median": trial.instructions.median, "max": trial.instructions.max },
        "wall_s": trial.wall_s,
        "files": written,
    })
}

fn print(name: &str, trial: &Trial) {
    let mut table = TextTable::new([name, "two boards", "host-sim, f32"]);
    let outcomes = [&trial.boards, &trial.host_sim];
    let mut row = |what: &str, of: &dyn Fn(&Outcome) -> String| {
        let [boards, host_sim] = outcomes.map(of);
        table.push([what.to_owned(), boards, host_sim]);
    };
    row("true discrepancy |x_o1 - x_o2|", &|o| format!("{:.4} mm", o.true_discrepancy_mm));
    row("decoded discrepancy |x_o - x_d|, peer 2", &|o| format!("{:.4} mm", o.decoded_discrepancy_mm));
    row("coordination force, peer 2", &|o| {
        format!("{:.4} N, standard deviation {:.4} N", o.coordination_force_n.mean, o.coordination_force_n.sd)
    });
    row("peak coordination force", &|o| format!("{:.4} N", o.peak_coordination_force_n));
    row("fault", &|o| fault(o).unwrap_or_else(|| "none".to_owned()));
    for peer in 0..2 {
        row(&format!("energy from / to the network, peer {}", peer + 1), &|o| {
            format!("{:.4} / {:.4} J", o.energy[peer].received_j, o.energy[peer].sent_j)
        });
    }
    let mut line = |what: &str, value: String| table.push([what.to_owned(), value, String::new()]);
    line("ticks of each board", trial.boards.ticks.to_string());
    line("ticks whose bits equal host-sim's", trial.equal.ticks.to_string());
    line("ticks missed", trial.ticks_missed.to_string());
    line("packets sent / received", format!("{} / {}", trial.packets_sent, trial.packets_received));
    line("packets dropped, lost by the wire", format!("{}, {}", trial.packets_dropped, trial.wire_lost));
    line("instructions per tick", format!("median {}, most {}", trial.instructions.median, trial.instructions.max));
    line("wall time", format!("{:.1} s", trial.wall_s));
    println!("{table}");
}
