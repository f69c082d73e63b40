//! Files of a run: CSV for people, Parquet for programs, figures; each beside the settings that made it.
//!
//! CSV and Parquet keep every number exactly. CSV writes the shortest decimal that reads back to the same `f64` (`NaN`,
//! `inf` and `-inf` by name; the payload of a NaN is not kept). Parquet stores a column as what it
//! [`Holds`](super::Holds), numbers bit for bit, compressed with Snappy, in row groups of [`ROW_GROUP_ROWS`](super::ROW_GROUP_ROWS) rows.
//!
//! **What made them** ([`Provenance`]) stands in a file of the same name with the ending `.toml`, and inside Parquet, SVG and PDF. It
//! is no comment in CSV: spreadsheets and PlotJuggler take a first line that is no heading for one, and the same data would
//! not give the same bytes. The file holds every setting as a scene file does, so that it is one: who loads it runs the same
//! again; its table `[made]`, which a scene ignores, holds version, commit, start and the rest.
//!
//! **Nothing is overwritten**: where a file of a name exists with other content, all files of the run get the next free
//! number (`NAME-2.csv`). Where they exist with the same content, they stay.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use chrono::{DateTime, SecondsFormat};
use cohold_columns::{Cell, Columns};
use cohold_io::Kind;
use cohold_plot::{Error, Figure, Print, paint, write_file};
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::parquet_file::parquet;

/// What an encoder said.
pub(super) type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Provenance of a file: the program, when it began, and all its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Provenance {
    facts: Vec<(String, Cell)>,
    settings: Vec<(String, String)>,
}

impl Provenance {
    /// By this version and commit, beginning now.
    pub fn now(version: &str, commit: &str) -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let started = DateTime::from_timestamp(since.as_secs() as i64, 0).unwrap_or_default();
        let started = started.to_rfc3339_opts(SecondsFormat::Secs, true);
        let facts = [("version", version.to_owned()), ("commit", commit.to_owned()), ("started", started)];
        Self { facts: facts.map(|(name, text)| (name.to_owned(), text.into())).to_vec(), settings: Vec::new() }
    }

    /// Adds a fact of this name.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<Cell>) -> Self {
        self.facts.push((name.to_owned(), value.into()));
        self
    }

    /// With these settings: keys of a scene, and values as TOML writes them.
    #[must_use]
    pub fn settings(mut self, settings: Vec<(String, String)>) -> Self {
        self.settings = settings;
        self
    }

    /// As TOML: a scene file with a table `[made]`.
    pub fn toml(&self) -> String {
        let mut text =
            "# What made the files of this name. It is a scene file as well: loading it runs the same again.\n"
                .to_owned();
        for (key, value) in &self.settings {
            let _ = writeln!(text, "{key} = {value}");
        }
        text += "\n[made]\n";
        for (name, cell) in &self.facts {
            let _ = match cell {
                Cell::Text(words) => writeln!(text, "{name} = {words:?}"),
                Cell::Number(number) => writeln!(text, "{name} = {number:?}"),
                Cell::Whole(count) => writeln!(text, "{name} = {count}"),
                Cell::Flag(flag) => writeln!(text, "{name} = {flag}"),
                Cell::List(numbers) => writeln!(text, "{name} = {numbers:?}"),
                Cell::Empty => Ok(()),
            };
        }
        text
    }
}

impl Serialize for Provenance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (name, cell) in &self.facts {
            map.serialize_entry(name, cell)?;
        }
        let settings: std::collections::BTreeMap<_, _> =
            self.settings.iter().map(|(key, value)| (key, value.trim_matches('"'))).collect();
        map.serialize_entry("settings", &settings)?;
        map.end()
    }
}

/// Files of one run, collected and then written together.
#[derive(Debug)]
pub struct Files {
    folder: PathBuf,
    name: String,
    provenance: Provenance,
    print: Print,
    parts: Vec<FileContent>,
}

#[derive(Debug)]
struct FileContent {
    name: String,
    ending: &'static str,
    bytes: Vec<u8>,
}

impl Files {
    /// Files in this folder; what made them will stand in `NAME.toml`.
    pub fn new(folder: &Path, name: &str, provenance: Provenance) -> Self {
        Self {
            folder: folder.to_owned(),
            name: name.to_owned(),
            provenance,
            print: Print::default(),
            parts: Vec::new(),
        }
    }

    /// Figures are to be printed so.
    pub fn print(&mut self, print: Print) {
        self.print = print;
    }

    /// Adds this table as `NAME.csv`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn csv(&mut self, columns: &Columns) -> Result<(), Error> {
        let bytes = csv(columns).map_err(self.failed("csv", "CSV"))?;
        self.add(self.name.clone(), "csv", bytes);
        Ok(())
    }

    /// Adds this table as `NAME.parquet`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn parquet(&mut self, columns: &Columns) -> Result<(), Error> {
        let bytes = parquet(columns, &self.provenance.toml()).map_err(self.failed("parquet", "Parquet"))?;
        self.add(self.name.clone(), "parquet", bytes);
        Ok(())
    }

    /// This figure as `FIGURE.svg`, `FIGURE.pdf` and `FIGURE.png`; under the name of the files where it has none of its own.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn figure(&mut self, name: Option<&str>, figure: &Figure) -> Result<(), Error> {
        let painted = paint(figure, self.print, &self.about()).map_err(self.failed("svg", "a figure"))?;
        let name = name.unwrap_or(&self.name).to_owned();
        painted.into_iter().for_each(|(ending, bytes)| self.add(name.clone(), ending, bytes));
        Ok(())
    }

    /// A text for people as `NAME.ENDING`.
    pub fn text(&mut self, ending: &'static str, text: String) {
        self.add(self.name.clone(), ending, text.into_bytes());
    }

    /// What a figure carries inside: the command, and what [`Provenance`] says but for the time.
    fn about(&self) -> String {
        let program =
            |word: String| Path::new(&word).file_name().map_or(word.clone(), |name| name.to_string_lossy().into());
        let mut words = std::env::args();
        let command: Vec<String> = words.next().map(program).into_iter().chain(words).collect();
        let provenance = self.provenance.toml();
        let provenance = provenance.lines().filter(|line| !line.starts_with("started = "));
        format!("# {}\n{}", command.join(" "), provenance.collect::<Vec<_>>().join("\n"))
    }

    fn add(&mut self, name: String, ending: &'static str, bytes: Vec<u8>) {
        self.parts.push(FileContent { name, ending, bytes });
    }

    fn failed<E: Into<Cause>>(&self, ending: &str, format: &'static str) -> impl Fn(E) -> Error + use<E> {
        Error::write(&self.path(&self.name, ending, 1), format)
    }

    /// Appended, not replaced: a name may contain a dot.
    fn path(&self, name: &str, ending: &str, number: u32) -> PathBuf {
        let number = if number > 1 { format!("-{number}") } else { String::new() };
        self.folder.join(format!("{name}{number}.{ending}"))
    }

    /// Writes all files; returns their paths, that of the provenance last.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(self) -> Result<Vec<PathBuf>, Error> {
        // Parquet says when it was made, SVG and PDF by which command: whether what they hold is the same, CSV and PNG tell.
        let compared = || self.parts.iter().filter(|part| !matches!(part.ending, "parquet" | "svg" | "pdf"));
        let taken = |part: &FileContent, number| {
            let path = self.path(&part.name, part.ending, number);
            path.symlink_metadata().is_ok() && !cohold_io::is(&path, &part.bytes)
        };
        let mut number = 1;
        while compared().any(|part| taken(part, number)) {
            number += 1;
        }
        let mut paths = Vec::new();
        for part in &self.parts {
            let path = self.path(&part.name, part.ending, number);
            if !path.exists() {
                write_file(&path, part.ending, &part.bytes, Kind::New)?;
            }
            paths.push(path);
        }
        let path = self.path(&self.name, "toml", number);
        if !path.exists() {
            write_file(&path, "TOML", self.provenance.toml().as_bytes(), Kind::New)?;
        }
        paths.push(path);
        Ok(paths)
    }
}

/// Writes one table as CSV: one line with the names of the columns, then one for each row.
///
/// # Errors
/// The file cannot be written, or what is there may not be written over.
pub fn write_csv(columns: &Columns, path: &Path, kind: Kind) -> Result<(), Error> {
    let bytes = csv(columns).map_err(Error::write(path, "CSV"))?;
    write_file(path, "CSV", &bytes, kind)
}

/// Writes one table as Parquet, with what made it.
///
/// # Errors
/// The file cannot be written, or what is there may not be written over.
pub fn write_parquet(columns: &Columns, path: &Path, provenance: &str, kind: Kind) -> Result<(), Error> {
    let bytes = parquet(columns, provenance).map_err(Error::write(path, "Parquet"))?;
    write_file(path, "Parquet", &bytes, kind)
}

fn csv(columns: &Columns) -> Result<Vec<u8>, Cause> {
    let data = columns.distinct()?;
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut line = |cells: Vec<String>| if cells.is_empty() { Ok(()) } else { writer.write_record(cells) };
    line(data.iter().map(|column| column.name().to_owned()).collect())?;
    let typed: Vec<_> = data.iter().map(|column| column.typed()).collect();
    for row in 0..columns.len() {
        line(typed.iter().map(|values| values.cell(row).csv()).collect())?;
    }
    Ok(writer.into_inner()?)
}
