//! `cohold board operator`: a scene for a board, lines of text and its answers, and what its ticks did.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::{io::BufRead, sync::mpsc::TryRecvError, time::Duration};

use clap::Args;
use cohold_board_tools::{
    calibrate::board::{say, take},
    calibrate::settings_file,
    operator::{PORT, UNCONFIRMED},
    recording,
};
use cohold_core::settings::Settings;
use cohold_io::Kind;
use cohold_live::recording::mcap::INFO;
use cohold_live::recording::origin::Origin;
use cohold_live::recording::recorder::Recorder;
use cohold_live::recording::ticks::{BoardTicks, board_channels, name_of};
use cohold_live::{endpoint::Stop, operator::Operator};
use cohold_report::files::write_csv;
use serde_json::json;

use crate::address::endpoint_at;
use crate::flags::{KeyFile, Time, number};
use crate::{Failure, SceneArgs, Ui};

/// Between two looks at what was typed.
const LOOK: Duration = Duration::from_millis(20);

#[derive(Debug, Args)]
#[command(mut_arg("scene", |arg| {
    arg.help("Scene file (TOML) or the name of a built-in scene: what it says of a board is given to the board first; the rest stays")
}))]
#[command(mut_arg("key_file", |arg| arg.help("The operator's key file that the board was provisioned with (`cohold key generate --operator`)")))]
#[command(mut_arg("seconds", |arg| arg.default_value("10").value_parser(number(0.1..=3600.0, "s"))))]
pub(crate) struct Operate {
    /// The board's address; its port is 7702 unless another is given.
    #[arg(long, value_name = "ADDRESS[:PORT]", value_parser = address)]
    board: SocketAddr,
    #[command(flatten)]
    key: KeyFile,
    #[command(flatten)]
    scene: SceneArgs,
    /// After the lines, record what the ticks do in this file: CSV in the end where its name ends in .csv; else MCAP, while it
    /// goes on, in a file that must not be there yet. Where the last line is `blackbox` or `capture …`, what that one gives.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    #[command(flatten)]
    time: Time,
    /// Record every how-many-th tick; 1 is all of them, and more than a busy network may carry.
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    every: u32,
    /// What to say, one line each, in quotes; stops at the first that the board refuses. Without any: lines are read from
    /// standard input, and answered one by one.
    #[arg(value_name = "LINE")]
    lines: Vec<String>,
}

/// The address of a board's operator's port, with or without it.
pub fn address(text: &str) -> Result<SocketAddr, Failure> {
    endpoint_at(text, Some(PORT))
}

/// Whether the motors are on, as far as these answers tell, and stay on only while an operator does.
fn left_armed(answers: &[String]) -> bool {
    let said = |answer: &&String| answer.starts_with("ok armed") || answer.starts_with("ok disarmed");
    answers.iter().rev().find(said).is_some_and(|last| last == "ok armed")
}

/// The file of a shared axis: of the first the one that was named, of the others one beside it, as `recording convert` names them.
fn of_axis(file: &Path, axis: usize) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    if axis == 0 { file.to_owned() } else { file.with_file_name(format!("{stem}-{}.csv", name_of(axis))) }
}

impl Operate {
    /// Gives the scene, says the lines and prints the answers, and records. A `disarm` that a failure keeps from being said is not confirmed.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let mut said = 0;
        self.operate(ui, &mut said).map_err(|why| {
            let mut unsaid = self.lines.iter().skip(said);
            let stops = unsaid.any(|line| line.split_whitespace().next() == Some("disarm"));
            if stops { format!("{why}; {UNCONFIRMED}").into() } else { why }
        })
    }

    fn operate(&self, ui: &Ui, lines_said: &mut usize) -> Result<(), Failure> {
        let stop = Stop::on_signals()?;
        let mut operator = Operator::connect(self.board, &self.key.key_file)?.until(stop.clone());
        if self.scene.is_given() {
            let given = settings_file::give_scene(&mut operator, &self.scene.load(ui)?, &self.scene.named()?)?;
            ui.status(format_args!("{given} settings of {} applied", self.scene.name()));
        }
        let mut answers = Vec::new();
        let mut ask = |operator: &mut Operator, line: &str| -> Result<(), Failure> {
            let answer = operator.ask(line)?;
            if let Some(why) = answer.strip_prefix("error ").filter(|_| !self.lines.is_empty()) {
                return Err(format!("board {}: {line}: {why}", operator.number).into());
            }
            writeln!(ui, "{answer}");
            answers.push(answer);
            Ok(())
        };
        for line in &self.lines[..self.lines.len() - usize::from(self.given().is_some())] {
            *lines_said += 1;
            ask(&mut operator, line)?;
        }
        if self.lines.is_empty() && !self.scene.is_given() && self.record.is_none() {
            let (say, said) = std::sync::mpsc::channel();
            // Whoever types takes their time: meanwhile the board is kept, and a signal heard.
            std::thread::spawn(move || std::io::stdin().lock().lines().try_for_each(|line| say.send(line)));
            while !stop.is_asked() {
                match said.try_recv() {
                    Ok(line) => ask(&mut operator, line?.trim())?,
                    Err(TryRecvError::Empty) => drop(operator.samples(LOOK)?),
                    Err(TryRecvError::Disconnected) => break,
                }
            }
        }
        let files = match &self.record {
            Some(file) => self.record(ui, &mut operator, file)?,
            None => Vec::new(),
        };
        if left_armed(&answers) {
            ui.status("no operator stays: the motors go off after safety.operator_lost_s (`arm alone` keeps them on)");
        }
        ui.document(&json!({ "answers": answers, "files": files }))
    }

    /// The last line, if it gives ticks, which is said by who records them.
    fn given(&self) -> Option<&String> {
        let gives = |line: &&String| line.starts_with("blackbox") || line.starts_with("capture");
        self.lines.last().filter(gives).filter(|_| self.record.is_some())
    }

    /// Has the ticks sent, and writes down those that came, whatever becomes of the board meanwhile.
    fn record(&self, ui: &Ui, operator: &mut Operator, file: &Path) -> Result<Vec<PathBuf>, Failure> {
        let mut settings = Settings::default();
        for key in ["timing.control_period_s", "axis.shared"] {
            take(operator, &mut settings, key)?;
        }
        let line = self.given().cloned().unwrap_or_else(|| format!("stream {}", self.every));
        let (period_s, axes) = (settings.timing.control_period_s, settings.axis.shared as usize);
        if file.extension().is_none_or(|ending| ending != "csv") {
            self.record_as_it_goes(ui, operator, &line, file, (period_s, axes))?;
            return Ok(vec![file.to_owned()]);
        }
        let files: Vec<PathBuf> = (0..axes).map(|axis| of_axis(file, axis)).collect();
        // Not after an hour of recording.
        if let Some(there) = files[1..].iter().find(|file| file.symlink_metadata().is_ok()) {
            let why = "it exists, and is not written over: give the recording another name";
            return Err(format!("{}: {why}", there.display()).into());
        }
        let (samples, refusal) = operator.record(&line, Duration::from_secs_f64(self.time.seconds))?;
        let stopped = say(operator, "stream off");
        let tables = recording::tables(samples.iter().map(|sample| sample.payload()), period_s, axes);
        let none = || format!("board {}: no tick came in {} s", operator.number, self.time.seconds);
        let table = tables.first().filter(|table| !table.is_empty()).ok_or_else(none)?;
        for (at, (table, file)) in tables.iter().zip(&files).enumerate() {
            write_csv(table, file, if at == 0 { Kind::Named } else { Kind::Beside })?;
        }
        if let Some(row) = recording::started_anew(table) {
            ui.status(format_args!(
                "the board started anew before row {row}: its ticks and times count from zero there"
            ));
        }
        let gap = recording::longest_gap(table).map_or_else(String::new, |(from_s, gap_s)| {
            format!("; none came from {from_s:.3} s on for {gap_s:.3} s, the longest gap")
        });
        let named: Vec<_> = files.iter().map(|file| file.display().to_string()).collect();
        ui.status(format_args!("{} ticks written to {}{gap}", table.len(), named.join(", ")));
        refusal.map_or(Ok(()), |why| Err(Failure::from(why)))?;
        stopped?;
        Ok(files)
    }

    /// Has the ticks sent, and records each as it comes, with what tells the board's clock.
    fn record_as_it_goes(
        &self,
        ui: &Ui,
        operator: &mut Operator,
        line: &str,
        file: &Path,
        (period_s, axes): (f64, usize),
    ) -> Result<(), Failure> {
        let (number, time) = (operator.number, Duration::from_secs_f64(self.time.seconds));
        let provenance = ui.provenance().with("board", number).with("line", line);
        let origin = Origin::here(&provenance, format!("operator of board {number}"), operator.start());
        let recorder = Recorder::create(file, &origin, board_channels(number, axes))?;
        let log = |answer: String| recorder.log(recorder.now_ns(), INFO, answer);
        let status = |operator: &mut Operator| operator.ask("status").map(log);
        status(operator)?;
        let mut ticks = BoardTicks::new(period_s, axes);
        let refusal = operator.record_each(line, time, |now_ns, session| ticks.record(&recorder, now_ns, session));
        let stopped = say(operator, "stream off").map(|_| status(operator));
        ui.status(recorder.finish().summary());
        refusal?.map_or(Ok(()), |why| Err(Failure::from(why)))?;
        if ticks.ticks == 0 {
            return Err(format!("board {number}: no tick came in {} s", self.time.seconds).into());
        }
        Ok(stopped??)
    }
}
