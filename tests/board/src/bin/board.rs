//! `cargo xtask board`: two virtual boards run a scene; a table beside cohold's, curves, pictures.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use board_bench::image::Firmware;
use board_bench::trial::{self, Trial};
use clap::Parser;
use cohold_cli::provenance;
use cohold_report::{Columns, Files};
use cohold_sim::Laws;
use cohold_sim::run::Outcome;
use cohold_sim::scenes;
use cohold_studies::figures;
use serde_json::json;

/// The scene that is run without `--scene`: the cooperation paper's §5.2, passive wave.
const USUAL: &str = "paper-5.2-passive-wave-16ms";

/// Two virtual NUCLEO-H743ZI2 run the unmodified release image, on one wire, closed around cohold's devices.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask board")]
struct Arguments {
    /// Scene file (TOML) or the name of a built-in scene.
    #[arg(long, default_value = USUAL, value_name = "NAME|FILE")]
    scene: PathBuf,
    /// Override one key of the scene; may be repeated.
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    set: Vec<String>,
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

fn run(arguments: &Arguments) -> Result<(), cohold_cli::Failure> {
    if !(arguments.seconds >= 1.0 && arguments.seconds <= 3600.0) {
        return Err(
            format!("--seconds {} is not allowed: it must be a number from 1 to 3600", arguments.seconds).into()
        );
    }
    let scene = scenes::find(Laws::built_in(), Some(&arguments.scene), &arguments.set)?;
    let name = arguments.scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let firmware = Arc::new(Firmware::release());
    let trial = trial::run(&firmware, &scene, arguments.seconds)?;
    let folder = match (&arguments.out, arguments.json) {
        (None, false) => Some(PathBuf::from("out/board")),
        (out, _) => out.clone(),
    };
    let provenance = provenance(option_env!("COHOLD_COMMIT"))
        .settings(scene.settings())
        .with("number_type", "f32")
        .with("seconds", arguments.seconds);
    let written = match folder {
        Some(folder) => {
            let mut files = Files::new(&folder, &name, provenance);
            files.csv(&trial.boards.axes[0].table)?;
            files.figure(None, &figures::run(&format!("{name}, two virtual boards"), &trial.boards, 0))?;
            files.write()?
        }
        None => Vec::new(),
    };
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
    let Trial { boards, cohold, .. } = trial;
    json!({
        "scene": name,
        "stable": boards.is_stable(),
        "verdict": boards.verdict().name(),
        "reason": boards.reason.map(|reason| reason.to_string()),
        "decoded_discrepancy_mm": boards.metric(|o| o.whole.decoded_discrepancy_mm),
        "true_discrepancy_mm": boards.metric(|o| o.whole.true_discrepancy_mm),
        "coordination_force_n": boards.metric(|o| o.whole.coordination_force_n),
        "peak_coordination_force_n": boards.metric(|o| o.whole.peak_coordination_force_n),
        "energy_made_mj": boards.metric(Outcome::energy_made_mj),
        "peer_energy_made_mj": boards.metric(Outcome::peer_energy_made_mj).flatten(),
        "fault": fault(boards),
        "cohold": {
            "reason": cohold.reason.map(|reason| reason.to_string()),
            "decoded_discrepancy_mm": cohold.metric(|o| o.whole.decoded_discrepancy_mm),
            "true_discrepancy_mm": cohold.metric(|o| o.whole.true_discrepancy_mm),
            "coordination_force_n": cohold.metric(|o| o.whole.coordination_force_n),
            "fault": fault(cohold),
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
        "instructions_per_loop": { "median": trial.loop_instructions.median, "max": trial.loop_instructions.max },
        "wall_s": trial.wall_s,
        "files": written,
    })
}

fn print(name: &str, trial: &Trial) {
    let outcomes = [&trial.boards, &trial.cohold];
    let of_both = Columns::of(&outcomes)
        .value("stable", |o| o.is_stable())
        .value("reason", |o| o.reason.map(|reason| reason.to_string()))
        .number("true_discrepancy_mm", 4, |o| o.metric(|o| o.whole.true_discrepancy_mm))
        .head("true discrepancy |x_o1 - x_o2|")
        .number("decoded_discrepancy_mm", 4, |o| o.metric(|o| o.whole.decoded_discrepancy_mm))
        .head("decoded discrepancy |x_o - x_d|, peer 2")
        .number("mean_n", 4, |o| o.metric(|o| o.whole.coordination_force_n.mean))
        .head("coordination force, peer 2: mean")
        .number("sd_n", 4, |o| o.metric(|o| o.whole.coordination_force_n.sd))
        .head("coordination force, peer 2: standard deviation")
        .number("peak_coordination_force_n", 4, |o| o.metric(|o| o.whole.peak_coordination_force_n))
        .value("fault", |o| fault(o).unwrap_or_else(|| "none".to_owned()));
    let of_both = [1, 2].into_iter().fold(of_both, |table, peer| {
        table
            .number("received_j", 4, move |o| o.whole.energy[peer - 1].received_j)
            .head(&format!("energy from the network, peer {peer}"))
            .number("sent_j", 4, move |o| o.whole.energy[peer - 1].sent_j)
            .head(&format!("energy to the network, peer {peer}"))
    });
    println!("{name}\n\n{}", of_both.done().down(&["two boards", "cohold, f32"]));
    let of_boards = Columns::of(std::slice::from_ref(trial))
        .value("ticks of each board", |trial| trial.boards.ticks)
        .value("ticks whose bits equal cohold's", |trial| trial.equal.ticks)
        .value("ticks missed", |trial| trial.ticks_missed)
        .value("packets sent", |trial| trial.packets_sent)
        .value("packets received", |trial| trial.packets_received)
        .value("packets dropped", |trial| trial.packets_dropped)
        .value("frames lost by the wire", |trial| trial.wire_lost)
        .value("instructions per tick, median", |trial| trial.instructions.median)
        .value("instructions per tick, most", |trial| trial.instructions.max)
        .value("instructions per run of the current loop, median", |trial| trial.loop_instructions.median)
        .value("instructions per run of the current loop, most", |trial| trial.loop_instructions.max)
        .number("wall_s", 1, |trial| trial.wall_s)
        .head("wall time");
    println!("{}", of_boards.done().down(&["two boards"]));
}
