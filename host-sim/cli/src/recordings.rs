//! `cohold recording convert` and `cohold recording merge`: what to do with recordings.

use std::path::{Path, PathBuf};

use clap::Args;
use cohold_io::Kind;
use cohold_live::recording::file::{Recording, Rows, read};
use cohold_live::recording::merge::{both, merge};
use cohold_live::recording::together;
use cohold_live::watch::GOOD_CLOCK_S;
use cohold_plot::write_file;
use cohold_report::files::{write_csv, write_parquet};
use cohold_report::{Columns, Error};
use serde_json::{Value, json};

use super::columns::Args as Meanings;
use super::{Failure, Ui};

super::commands! {
    /// What to do with recordings.
    pub(crate) RecordingCommands {
        /// Make a table of a recording: Parquet or CSV; also of one that was cut.
        Convert(Convert),
        /// True discrepancy of a live run: the recordings of both ends on a common clock, with the error that the clock leaves.
        Merge(Merge),
        /// What is in the files: every column of every kind of table, with unit and meaning.
        Columns(Meanings),
    }
}

/// A table, in the format that the ending of the file's name says; the other endings are refused before anything is read.
#[derive(Clone, Copy)]
enum Format {
    Csv,
    Parquet,
}

impl Format {
    fn of(path: &Path) -> Result<Self, Failure> {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("csv") => Ok(Self::Csv),
            Some("parquet") => Ok(Self::Parquet),
            _ => Err(format!("{} is not allowed: its name must end in .csv or .parquet", path.display()).into()),
        }
    }

    fn write(self, table: &Columns, path: &Path, provenance: &str, kind: Kind) -> Result<(), Error> {
        match self {
            Self::Csv => write_csv(table, path, kind),
            Self::Parquet => write_parquet(table, path, provenance, kind),
        }
    }
}

/// Reads a recording, and says what is missing in it.
pub fn load(ui: &Ui, path: &Path) -> Result<Recording, Failure> {
    let recording = read(path)?;
    if let Some(cut) = recording.cut {
        ui.warn(format_args!("{}: {}", path.display(), cut.summary()));
    }
    if let Some(lost) = recording.lost.filter(|lost| *lost > 0) {
        ui.warn(format_args!(
            "{}: {lost} rows came quicker than they could be written, and are missing",
            path.display()
        ));
    }
    if recording.damaged > 0 {
        ui.warn(format_args!(
            "{}: {} of its chunks are damaged (their checksums are others): their rows are left out",
            path.display(),
            recording.damaged
        ));
    }
    Ok(recording)
}

#[derive(Debug, Args)]
pub(super) struct Convert {
    /// A recording (MCAP); one that was cut gives all that is whole.
    #[arg(value_name = "IN")]
    from: PathBuf,
    /// The table of its ticks, as .csv or .parquet; its other channels are put beside it, as NAME-exchanges and the like, where no
    /// other file is.
    #[arg(value_name = "OUT")]
    to: PathBuf,
}

impl Convert {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let format = Format::of(&self.to)?;
        let recording = load(ui, &self.from)?;
        let mut made = Vec::new();
        let files = self.write(format, &recording, &mut made).inspect_err(|_| {
            // What a failure leaves would be in the way of the next time.
            made.iter().for_each(|file| drop(std::fs::remove_file(file)));
        })?;
        let cut = recording
            .cut
            .map(|cut| json!({ "whole_bytes": cut.whole, "bytes_after": cut.rest, "rows_saved": cut.saved }));
        ui.report("", &json!({ "who": recording.origin.who, "cut": cut, "lost": recording.lost, "damaged_chunks": recording.damaged, "channels": files }))
    }

    /// Writes all tables; `made` are the files that were not there before.
    fn write(&self, format: Format, recording: &Recording, made: &mut Vec<PathBuf>) -> Result<Vec<Value>, Failure> {
        let mut makes = |path: &Path| made.extend((!path.exists()).then(|| path.to_owned()));
        let provenance = &recording.origin.provenance;
        if let Format::Csv = format {
            // Parquet has it inside.
            let path = self.to.with_extension("toml");
            if let Err(error) = provenance.parse::<toml::Table>() {
                let why = format!("{}: its settings are no TOML: {}", self.from.display(), error.message());
                return Err(why.into());
            }
            makes(&path);
            write_file(&path, "TOML", provenance.as_bytes(), Kind::Beside)?;
        }
        let mut files = Vec::new();
        // A page has a channel for each environment that it can show: what was never shown is no file.
        let come = |(at, rows): &(usize, &Rows)| *at == 0 || !rows.is_empty();
        // The file that was named comes last: when it is there, all of them are.
        for (at, rows) in recording.channels.iter().enumerate().filter(come).rev() {
            let (path, kind) = match at {
                0 => (self.to.clone(), Kind::Named),
                _ => (self.beside(&rows.topic)?, Kind::Beside),
            };
            makes(&path);
            format.write(&rows.table(), &path, provenance, kind)?;
            files.insert(0, json!({ "channel": rows.topic, "rows": rows.len(), "file": path }));
        }
        Ok(files)
    }

    /// The file of a channel beside that of the ticks.
    fn beside(&self, topic: &str) -> Result<PathBuf, Failure> {
        let leaf = topic.rsplit('/').next().unwrap_or_default();
        if leaf.is_empty() || leaf.contains(|letter: char| !letter.is_ascii_alphanumeric() && !"-_".contains(letter)) {
            let allowed = "after its last / there must be letters, digits, - and _";
            return Err(format!("{}: channel {topic:?} is not allowed: {allowed}", self.from.display()).into());
        }
        let stem = self.to.file_stem().unwrap_or_default().to_string_lossy();
        let ending = self.to.extension().unwrap_or_default().to_string_lossy();
        Ok(self.to.with_file_name(format!("{stem}-{leaf}.{ending}")))
    }
}

#[derive(Debug, Args)]
pub(super) struct Merge {
    /// The recording of one end, or of both.
    #[arg(value_name = "A")]
    one: PathBuf,
    /// The recording of the other end; and a table of every instant (.csv or .parquet), or both recordings on one clock (.mcap).
    #[arg(value_name = "B|OUT", num_args = 0..=2)]
    rest: Vec<PathBuf>,
    /// The recording of the hub that both were at.
    #[arg(long, value_name = "FILE")]
    hub: Option<PathBuf>,
}

impl Merge {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let is_table = |path: &PathBuf| Format::of(path).is_ok();
        let is_recording = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "mcap");
        let (two, out) = match &self.rest[..] {
            [] => (None, None),
            [one] if is_table(one) => (None, Some(one)),
            [two] => (Some(two), None),
            [two, out] if is_table(out) || is_recording(out) => (Some(two), Some(out)),
            [_, out, ..] => {
                let place = out.display();
                return Err(format!("{place} is not allowed: its name must end in .csv, .parquet or .mcap").into());
            }
        };
        let one = load(ui, &self.one)?;
        let hub = self.hub.as_ref().map(|hub| load(ui, hub)).transpose()?;
        let two = two.map(|two| load(ui, two)).transpose()?;
        let merged = match &two {
            None => both(&one)?,
            Some(two) => merge(&one, two, hub.as_ref())?,
        };
        match (out, &two) {
            (Some(out), Some(two)) if is_recording(out) => {
                let ended = together::write(out, [&one, two], hub.as_ref(), &merged)?;
                ui.status(ended.summary());
                if let Some(why) = ended.failed {
                    return Err(why.into());
                }
            }
            (Some(out), _) => {
                Format::of(out)?.write(&merged.table, out, &one.origin.provenance, Kind::Named)?;
                ui.status(format_args!("wrote {}", out.display()));
            }
            (None, _) => {}
        }
        for (end, left_out) in merged.ends.iter().zip(merged.left_out).filter(|(_, left_out)| *left_out > 0) {
            ui.warn(format_args!(
                "{end}: {left_out} rows are no motion of a copy (not finite, or a leap that its speed does not make): left out"
            ));
        }
        if merged.clock_error_us > 1e6 * GOOD_CLOCK_S {
            ui.warn(format_args!(
                "the common clock may be wrong by {:.2} ms, more than the 0.1 ms of a local network",
                1e-3 * merged.clock_error_us
            ));
        }
        ui.report("", &merged)
    }
}
