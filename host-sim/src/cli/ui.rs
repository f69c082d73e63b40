//! Everything that a command says and leaves behind goes through one [`Ui`]: results to standard output, progress and
//! warnings to standard error, files into a folder.
//!
//! A result is given in both forms, and the one that was asked for is printed: [`Ui::document`] under `--json`, what is written
//! with `writeln!(ui, …)`, [`Ui::table`] and [`Ui::wrote`] without. So no command asks which.

use std::fmt;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use haptic_sim::report::table::Table;
use haptic_sim::report::{ReportError, files};

use super::Failure;

/// Where a command's output goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ui {
    json: bool,
}

impl Ui {
    /// Prints JSON, or text.
    pub(super) fn new(json: bool) -> Self {
        Self { json }
    }

    /// The result as the one JSON document.
    ///
    /// # Errors
    /// It cannot be written as JSON.
    pub(super) fn document(&self, document: &impl Serialize) -> Result<(), Failure> {
        if self.json {
            print(format_args!("{}\n", serde_json::to_string_pretty(document)?));
        }
        Ok(())
    }

    /// Text of the result: what `write!` and `writeln!` call.
    pub(super) fn write_fmt(&self, text: fmt::Arguments<'_>) {
        if !self.json {
            print(text);
        }
    }

    /// A table of the result, and a blank line.
    pub(super) fn table(&self, table: &impl fmt::Display) {
        writeln!(self, "{table}");
    }

    /// Names the files that were written.
    pub(super) fn wrote(&self, files: &[PathBuf]) {
        for file in files {
            writeln!(self, "wrote {}", file.display());
        }
    }

    /// Where files go: into the folder asked for, or into the usual one where the result is for a person.
    pub(super) fn folder(&self, out: Option<&Path>, usual: &str) -> Option<PathBuf> {
        out.or((!self.json).then_some(Path::new(usual))).map(Path::to_path_buf)
    }

    /// What is going on, on standard error.
    pub(super) fn status(&self, text: impl fmt::Display) {
        eprintln!("{text}");
    }

    /// What the user should know although the work was done, on standard error.
    pub(super) fn warn(&self, text: impl fmt::Display) {
        eprintln!("warning: {text}");
    }

    /// A progress bar on standard error; invisible where that is no terminal.
    pub(super) fn progress(&self, length: u64, what: &str) -> ProgressBar {
        let style = ProgressStyle::with_template("{msg} {bar:40} {percent:>3} % {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::new(length).with_style(style).with_message(what.to_owned())
    }
}

/// Writes the table and draws the picture beside it; names all files.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn save(
    base: &Path,
    table: &Table,
    draw: impl FnOnce() -> Result<Vec<PathBuf>, ReportError>,
) -> Result<Vec<PathBuf>, Failure> {
    // Appended, not replaced: a scene's name may contain a dot.
    let mut csv = base.as_os_str().to_owned();
    csv.push(".csv");
    let csv = PathBuf::from(csv);
    files::write_csv(table, &csv)?;
    let mut written = vec![csv];
    written.extend(draw()?);
    Ok(written)
}

/// Prints on standard output; ends the program quietly where nobody reads on (`host-sim cooperate | head -3`).
fn print(text: fmt::Arguments<'_>) {
    match std::io::stdout().write_fmt(text) {
        Ok(()) => {}
        // What a shell sees of a program that the closed pipe ended.
        Err(cause) if cause.kind() == ErrorKind::BrokenPipe => std::process::exit(141),
        Err(cause) => {
            eprintln!("host-sim: cannot write to standard output: {cause}");
            std::process::exit(2);
        }
    }
}
