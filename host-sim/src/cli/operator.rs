//! `host-sim operator`: a scene for a board, lines of text and its answers, and what its ticks did.

use std::io::BufRead;
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::mpsc::TryRecvError;
use std::time::Duration;

use clap::Args;

use super::{Failure, Ui};
use crate::live::endpoint::Stop;
use crate::live::operator::Operator;
use haptic_sim::board::calibrate::board::say;
use haptic_sim::board::calibrate::settings_file;
use haptic_sim::board::operator::PORT;
use haptic_sim::board::recording;
use haptic_sim::report::files::write_csv;

/// Between two looks at what was typed.
const LOOK: Duration = Duration::from_millis(20);

/// Arguments of `operator`.
#[derive(Debug, Args)]
pub(super) struct Operate {
    /// The board's address; its port is 7702 unless another is given.
    #[arg(long, value_name = "ADDRESS[:PORT]", value_parser = board)]
    board: SocketAddr,
    /// The key file that the board was provisioned with.
    #[arg(long, value_name = "FILE")]
    key_file: PathBuf,
    /// A scene file: what it says of a board's settings is given to the board first, and applied; what it does not name stays.
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// After the lines, write what the ticks did to this CSV file.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// For so long, s.
    #[arg(long, default_value_t = 10.0, value_name = "S", allow_negative_numbers = true, value_parser = seconds)]
    seconds: f64,
    /// Record every how-many-th tick; 1 is all of them, and more than a busy network may carry.
    #[arg(long, default_value_t = 4, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=1000))]
    every: u32,
    /// What to say, one line each, in quotes; stops at the first that the board refuses. Without any: lines are read from
    /// standard input, and answered one by one.
    #[arg(value_name = "LINE")]
    lines: Vec<String>,
}

/// An address with or without a port.
pub(super) fn board(text: &str) -> Result<SocketAddr, String> {
    let address = text.parse::<IpAddr>().map(|address| SocketAddr::new(address, PORT));
    address.or_else(|_| text.parse()).map_err(|_| format!("{text} is no address: it must be like 192.168.77.1"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.1..=3600.0).contains(seconds));
    seconds.ok_or_else(|| "it must be a number from 0.1 to 3600 s".to_owned())
}

impl Operate {
    /// Gives the scene, says the lines and prints the answers, and records.
    ///
    /// # Errors
    /// Nobody there, a scene or a line that the board refuses, or a file that cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let stop = Stop::on_signals()?;
        let mut operator = Operator::connect(self.board, &self.key_file)?.until(stop.clone());
        if let Some(scene) = &self.scene {
            let given = settings_file::give(&mut operator, scene)?;
            ui.status(format_args!("{given} settings of {} applied", scene.display()));
        }
        for line in &self.lines {
            let answer = operator.ask(line)?;
            if let Some(why) = answer.strip_prefix("error ") {
                return Err(format!("board {}: {line}: {why}", operator.number()).into());
            }
            writeln!(ui, "{answer}");
        }
        if let Some(file) = &self.record {
            return self.record(ui, &mut operator, file);
        }
        if self.lines.is_empty() && self.scene.is_none() {
            let (say, said) = std::sync::mpsc::channel();
            // Whoever types takes their time: meanwhile the board is kept, and a signal heard.
            std::thread::spawn(move || std::io::stdin().lock().lines().try_for_each(|line| say.send(line)));
            while !stop.is_asked() {
                match said.try_recv() {
                    Ok(line) => writeln!(ui, "{}", operator.ask(line?.trim())?),
                    Err(TryRecvError::Empty) => drop(operator.samples(LOOK)?),
                    Err(TryRecvError::Disconnected) => break,
                }
            }
        }
        Ok(())
    }

    /// Has the ticks sent, and writes down those that came, whatever becomes of the board meanwhile.
    fn record(&self, ui: &Ui, operator: &mut Operator, file: &Path) -> Result<(), Failure> {
        let period = say(operator, "get timing.control_period_s")?;
        let period_s = period.rsplit(' ').next().and_then(|number| number.parse().ok()).unwrap_or(0.001);
        let (samples, refusal) = operator.record(self.every, Duration::from_secs_f64(self.seconds))?;
        let stopped = say(operator, "stream off");
        let table = recording::table(samples.iter().map(|sample| sample.payload()), period_s);
        if table.is_empty() {
            return Err(format!("board {}: no tick came in {} s", operator.number(), self.seconds).into());
        }
        write_csv(&table, file)?;
        if let Some(row) = recording::started_anew(&table) {
            ui.status(format_args!(
                "the board started anew before row {row}: its ticks and times count from zero there"
            ));
        }
        let gap = recording::longest_gap(&table).map_or_else(String::new, |(from_s, gap_s)| {
            format!("; none came from {from_s:.3} s on for {gap_s:.3} s, the longest gap")
        });
        ui.status(format_args!("{} ticks written to {}{gap}", table.len(), file.display()));
        if let Some(refusal) = refusal {
            return Err(refusal.into());
        }
        stopped?;
        Ok(())
    }
}
