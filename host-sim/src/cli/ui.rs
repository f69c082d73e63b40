//! Everything that a command says and leaves behind goes through one [`Ui`]: results to standard output, progress and
//! warnings to standard error, files into a folder.
//!
//! A result is given in both forms, and the one that was asked for is printed: [`Ui::document`] under `--json`, what is written
//! with `writeln!(ui, …)`, [`Ui::table`] and [`Ui::wrote`] without. So no command asks which.

use std::error::Error;
use std::fmt;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use haptic_sim::Laws;
use haptic_sim::report::{Files, Made, ReportError};

/// What a command may fail with.
pub(super) type Failure = Box<dyn Error>;

/// Where a command's output goes.
#[derive(Clone, Debug)]
pub(super) struct Ui {
    json: bool,
    made: Made,
    /// The laws that a scene may name.
    pub(super) laws: Laws,
}

/// A document, and what made it.
#[derive(Serialize)]
struct Told<'a, D> {
    #[serde(flatten)]
    document: &'a D,
    made: &'a Made,
}

impl Ui {
    /// Prints JSON, or text.
    pub(super) fn new(json: bool, laws: Laws) -> Self {
        Self { json, laws, made: made() }
    }

    /// The result as the one JSON document.
    pub(super) fn document(&self, document: &impl Serialize) -> Result<(), Failure> {
        if self.json {
            print(format_args!("{}\n", serde_json::to_string_pretty(document)?));
        }
        Ok(())
    }

    /// Rows, or anything else that is a text for people and a document for programs: as the one that was asked for.
    pub(super) fn result(&self, result: &(impl Serialize + fmt::Display)) -> Result<(), Failure> {
        self.table(result);
        self.document(result)
    }

    /// This program, since it began: what a run adds its settings to.
    pub(super) fn made(&self) -> Made {
        self.made.clone()
    }

    /// The result as the one JSON document, with what made it.
    pub(super) fn document_of(&self, made: &Made, document: &impl Serialize) -> Result<(), Failure> {
        self.document(&Told { document, made })
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

    /// Names the pictures.
    pub(super) fn pictures(&self, pictures: &[PathBuf]) {
        writeln!(self, "Pictures (SVG, and PNG beside each):");
        let svg = pictures.iter().filter(|path| path.extension().is_some_and(|ending| ending == "svg"));
        svg.for_each(|picture| writeln!(self, "  {}", picture.display()));
    }

    /// Where files go: into the folder asked for, or into the usual one where the result is for a person.
    pub(super) fn folder(&self, out: Option<&Path>, usual: &str) -> Option<PathBuf> {
        out.or((!self.json).then_some(Path::new(usual))).map(Path::to_path_buf)
    }

    /// Has files of this name written into that folder, if there is one; returns their paths.
    pub(super) fn files(
        &self,
        folder: Option<&Path>,
        name: &str,
        made: &Made,
        fill: impl FnOnce(&mut Files) -> Result<(), ReportError>,
    ) -> Result<Vec<PathBuf>, Failure> {
        let Some(folder) = folder else { return Ok(Vec::new()) };
        let mut files = Files::new(folder, name, made.clone());
        fill(&mut files)?;
        Ok(files.write()?)
    }

    /// What is going on, on standard error.
    pub(super) fn status(&self, text: impl fmt::Display) {
        eprintln!("{text}");
    }

    /// What the user should know although the work was done, on standard error.
    pub(super) fn warn(&self, text: impl fmt::Display) {
        eprintln!("warning: {text}");
    }

    /// Says so where this knows core's laws only and there are others.
    pub(super) fn only_built_in(&self, what: &str) {
        let outside: Vec<&str> = self.laws.outside().collect();
        if !outside.is_empty() {
            self.warn(format_args!("{what} the laws of haptic-core only, without {}", outside.join(", ")));
        }
    }

    /// A progress bar on standard error; invisible where that is no terminal.
    pub(super) fn progress(&self, length: u64, what: &str) -> ProgressBar {
        let style = ProgressStyle::with_template("{msg} {bar:40} {percent:>3} % {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::new(length).with_style(style).with_message(what.to_owned())
    }
}

/// This program, from now on: what its files say of what made them.
pub fn made() -> Made {
    Made::now(env!("CARGO_PKG_VERSION"), option_env!("HOST_SIM_COMMIT").unwrap_or("unknown"))
}

/// The pictures among these files.
pub(super) fn pictures(files: Vec<PathBuf>) -> Vec<PathBuf> {
    let is_picture = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "svg" || ending == "png");
    files.into_iter().filter(is_picture).collect()
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
