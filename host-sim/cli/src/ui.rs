//! Everything that a command says and leaves behind goes through one [`Ui`]: results to standard output, progress and
//! warnings to standard error, files into a folder.
//!
//! A result is given in both forms, and the one that was asked for is printed: [`Ui::document`] under `--json`, what is written
//! with `writeln!(ui, …)`, [`Ui::table`] and [`Ui::wrote`] without. So no command asks which. [`Ui::report`] needs the document only.

use std::io::{ErrorKind, IsTerminal, Write, stderr};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};
use std::{fmt, path::PathBuf, thread};

use clap::Args;
use serde::Serialize;
use serde_json::Value;

use cohold_io::{Kind, escaped};
use cohold_live::devices::Adapter;
use cohold_live::playable::Playable;
use cohold_plot::{Print, write_file};
use cohold_report::{Columns, Files, Provenance, word};
use cohold_sim::Laws;
use cohold_studies::{campaign::laws::page, proof::Prover, reproduce::Paper, sweep::tag};

use super::columns::TableKind;
use super::number::number;
use super::road::{Meets, Nobody};

/// Why a command, a page or a trial did not do what was asked: whatever a package below says, or a sentence. One line.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// The work was done and its results are out, but it did not go well: why, for exit status 1.
#[derive(Debug)]
pub(crate) struct Unsuccessful(pub(crate) String);

impl fmt::Display for Unsuccessful {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Unsuccessful {}

/// Where a command's output goes.
#[derive(Clone, Debug)]
pub struct Ui {
    pub(crate) json: bool,
    pub(crate) provenance: Provenance,
    /// The laws that a scene may name.
    pub laws: Laws,
    /// What is said of where the other end is met.
    pub meeting: Arc<dyn Meets>,
    /// Kinds of tables from outside.
    pub(crate) tables: Vec<fn(&Self) -> Vec<TableKind>>,
    /// Papers from outside.
    pub(crate) papers: Vec<Paper>,
    /// Proofs of laws that core does not have.
    pub(crate) prover: Prover,
    /// Adapters of devices.
    pub(crate) devices: Vec<Adapter>,
    /// Environments that a page can show.
    pub environments: &'static [Playable],
}

/// Where files go.
#[derive(Clone, Debug, Default, Args)]
pub struct Out {
    /// Folder for tables and pictures; without it, one in out/, and none with --json.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Width of figures in print, mm: 180 for a page; without it a column (88), and for `accuracy` a page.
    #[arg(long, value_name = "MM", value_parser = number(60.0..=400.0, "mm"))]
    width_mm: Option<f64>,
    /// Size of the letters at the ticks of figures, points; 7 without it.
    #[arg(long, value_name = "PT", value_parser = number(5.0..=14.0, "pt"))]
    font_pt: Option<f64>,
}

impl Out {
    /// The same into this folder.
    pub(crate) fn in_folder(&self, folder: PathBuf) -> Self {
        Self { out: Some(folder), ..self.clone() }
    }

    /// The same with figures of this width, mm, unless another was asked for.
    pub(crate) fn unless_told(&self, width_mm: f64) -> Self {
        Self { width_mm: self.width_mm.or(Some(width_mm)), ..self.clone() }
    }

    fn print(&self) -> Print {
        let usual = Print::default();
        Print { width_mm: self.width_mm.unwrap_or(usual.width_mm), font_pt: self.font_pt.unwrap_or(usual.font_pt) }
    }
}

/// A document, and what made it.
#[derive(Serialize)]
struct WithProvenance<'a, D> {
    #[serde(flatten)]
    document: &'a D,
    #[serde(rename = "made")]
    provenance: &'a Provenance,
}

impl Ui {
    /// Of the heart alone.
    pub(crate) fn new() -> Self {
        Self {
            json: false,
            laws: Laws::built_in(),
            meeting: Arc::new(Nobody),
            tables: Vec::new(),
            papers: Vec::new(),
            prover: |_| None,
            devices: Vec::new(),
            environments: &[],
            provenance: provenance(None),
        }
    }

    /// The result as the one JSON document.
    pub fn document(&self, document: &impl Serialize) -> Result<(), Failure> {
        if self.json {
            print(format_args!("{}\n", serde_json::to_string_pretty(document)?));
        }
        Ok(())
    }

    /// Rows, or anything else that is a text for people and a document for programs: as the one that was asked for.
    pub fn result(&self, result: &(impl Serialize + fmt::Display)) -> Result<(), Failure> {
        self.table(result);
        self.document(result)
    }

    /// A document that is its own text: below the title a line for every field, then its lists, as tables where they hold objects.
    pub fn report(&self, title: &str, document: &impl Serialize) -> Result<(), Failure> {
        self.document(document)?;
        self.text(title, document)
    }

    /// The report of what said a JSON object a line while it ran: as the last of them, where that was asked for.
    pub fn live_report(&self, lines: bool, title: &str, document: &impl Serialize) -> Result<(), Failure> {
        if lines {
            let kind = serde_json::json!({ "kind": "report" });
            print(format_args!("{}\n", and(kind, document)?));
            return Ok(());
        }
        self.report(title, document)
    }

    /// [`Ui::report`] with the provenance of the results.
    pub fn report_of(&self, provenance: &Provenance, title: &str, document: &impl Serialize) -> Result<(), Failure> {
        self.document_of(provenance, document)?;
        self.text(title, document)
    }

    /// As [`Ui::report`], for people only.
    ///
    /// # Errors
    /// It is not to be had as JSON.
    pub fn text(&self, title: &str, document: &impl Serialize) -> Result<(), Failure> {
        let is_list = |value: &Value| value.as_array().is_some_and(|items| !items.iter().all(Value::is_number));
        let (lists, facts) = match serde_json::to_value(document)? {
            Value::Object(fields) => fields.into_iter().partition(|(_, value)| is_list(value)),
            list => (Vec::from([(String::new(), list)]), Vec::new()),
        };
        if !facts.is_empty() {
            writeln!(self, "{}", Columns::of_documents(&[facts.into_iter().collect()]).down(&[title]));
        }
        for (name, list) in &lists {
            let items = list.as_array().map_or(&[][..], Vec::as_slice);
            if !items.iter().all(Value::is_object) {
                let name = if name == "files" { "wrote" } else { name };
                items.iter().for_each(|item| writeln!(self, "{name} {}", word(item)));
                continue;
            }
            if !name.is_empty() {
                writeln!(self, "{}\n", name.replace('_', " "));
            }
            let table = Columns::of_documents(items);
            // Very wide rows stand side by side.
            if table.data().count() > 14 {
                let titles: Vec<String> = (1..=items.len()).map(|number| number.to_string()).collect();
                writeln!(self, "{}", table.down(&titles.iter().map(String::as_str).collect::<Vec<_>>()));
            } else {
                self.table(&table);
            }
        }
        Ok(())
    }

    /// This program, since it began: what a run adds its settings to.
    pub fn provenance(&self) -> Provenance {
        self.provenance.clone()
    }

    /// The result as the one JSON document, with what made it.
    pub fn document_of(&self, provenance: &Provenance, document: &impl Serialize) -> Result<(), Failure> {
        self.document(&WithProvenance { document, provenance })
    }

    /// Text of the result: what `write!` and `writeln!` call.
    pub fn write_fmt(&self, text: fmt::Arguments<'_>) {
        if !self.json {
            print(text);
        }
    }

    /// A table of the result, and a blank line.
    pub fn table(&self, table: &impl fmt::Display) {
        writeln!(self, "{table}");
    }

    /// Draws a figure beside a page, as a PNG of this name, and says where.
    fn beside(page: &std::path::Path, name: &str, figure: &cohold_plot::Figure) -> Result<PathBuf, Failure> {
        let path = page.with_file_name(name);
        let painted = cohold_plot::paint(figure, Print::default(), "");
        let painted = painted.map_err(cohold_plot::Error::write(&path, "a figure"))?;
        for (_, bytes) in painted.into_iter().filter(|(ending, _)| *ending == "png") {
            write_file(&path, "PNG", &bytes, Kind::Named)?;
        }
        Ok(path)
    }

    /// A page that is to be written into.
    fn page(file: &std::path::Path) -> Result<String, Failure> {
        cohold_io::text(file, page::MOST).map_err(|cause| format!("--page {}: {cause}", file.display()).into())
    }

    /// Refuses a page that has none of these pairs of lines. Call it before long work.
    pub(crate) fn have(files: &[PathBuf], pairs: &[[&str; 2]]) -> Result<(), Failure> {
        for file in files {
            let page = Self::page(file)?;
            if !pairs.iter().any(|lines| page::between(&page, *lines).is_some()) {
                let lines: Vec<&str> = pairs.iter().map(|[begin, _]| *begin).collect();
                return Err(
                    format!("--page {}: there is no line {}", file.display(), lines.join(" and no line ")).into()
                );
            }
        }
        Ok(())
    }

    /// Writes each of these texts between its two lines of the pages that have them, and the picture beside the pages that name it. Returns
    /// the files.
    pub(crate) fn rewrite(
        pages: &[PathBuf],
        parts: &[([&str; 2], String)],
        picture: Option<(&str, &cohold_plot::Figure)>,
    ) -> Result<Vec<PathBuf>, Failure> {
        let mut written = pages.to_vec();
        for file in pages {
            let old = Self::page(file)?;
            let page = parts.iter().fold(old, |page, (lines, text)| page::with(&page, *lines, text).unwrap_or(page));
            write_file(file, "Markdown", page.as_bytes(), Kind::Named)?;
            if let Some((name, figure)) = picture.filter(|(name, _)| page.contains(name)) {
                written.push(Self::beside(file, name, figure)?);
            }
        }
        Ok(written)
    }

    /// Says that these files were written.
    pub fn wrote(&self, files: &[PathBuf]) {
        for file in files {
            writeln!(self, "wrote {}", file.display());
        }
    }

    pub(crate) fn pictures(&self, pictures: &[PathBuf]) {
        writeln!(self, "Pictures (SVG, and PNG beside each):");
        let svg = pictures.iter().filter(|path| path.extension().is_some_and(|ending| ending == "svg"));
        svg.for_each(|picture| writeln!(self, "  {}", picture.display()));
    }

    /// Has files of this name written into the folder that was asked for, or into `out/USUAL` where the result is for a person;
    /// returns their paths.
    pub fn files(
        &self,
        out: &Out,
        usual: &str,
        name: &str,
        provenance: &Provenance,
        fill: impl FnOnce(&mut Files) -> Result<(), cohold_report::Error>,
    ) -> Result<Vec<PathBuf>, Failure> {
        if !self.writes(out) {
            return Ok(Vec::new());
        }
        let usual = PathBuf::from("out").join(usual);
        let mut files = Files::new(out.out.as_ref().unwrap_or(&usual), name, provenance.clone());
        files.print(out.print());
        fill(&mut files)?;
        Ok(files.write()?)
    }

    /// Whether files are written: always for people, and with `--json` into a folder that was asked for.
    pub fn writes(&self, out: &Out) -> bool {
        !self.json || out.out.is_some()
    }

    /// The folder in which the same question is continued: `--out`, or one in `out/`. None if no files are written.
    pub(crate) fn kept(&self, out: &Out, usual: &str, question: &Provenance) -> Option<PathBuf> {
        let usual = || format!("out/{usual}{}", tag(question)).into();
        self.writes(out).then(|| out.out.clone().unwrap_or_else(usual))
    }

    /// What is going on, on standard error.
    pub fn status(&self, text: impl fmt::Display) {
        cohold_io::say(text);
    }

    /// What the user should know although the work was done, on standard error.
    pub fn warn(&self, text: impl fmt::Display) {
        cohold_io::say(format_args!("warning: {}", escaped(&text.to_string())));
    }

    /// Says so where this knows core's laws only and there are others.
    pub fn only_built_in(&self, what: &str) {
        let outside: Vec<&str> = self.laws.outside().collect();
        if !outside.is_empty() {
            self.warn(format_args!("{what} the built-in laws only, without {}", outside.join(", ")));
        }
    }

    /// Works, and says on standard error, where that is a terminal, for how long and how much of it is done. Gives how long it took, s.
    pub fn work<T, E>(
        &self,
        steps: usize,
        what: &str,
        work: impl FnOnce(&(dyn Fn() + Sync)) -> Result<T, E>,
    ) -> Result<(T, f64), E> {
        let (start, done) = (Instant::now(), &AtomicUsize::new(0));
        let show = |ended: mpsc::Receiver<()>| {
            while ended.recv_timeout(Duration::from_millis(200)) == Err(RecvTimeoutError::Timeout) {
                let (took_s, share) =
                    (start.elapsed().as_secs_f64(), done.load(Ordering::Relaxed) as f64 / steps as f64);
                let left = if steps > 1 && share > 0.0 {
                    format!("{:.0} %, {took_s:.0} s, {:.0} s left", 100.0 * share, took_s / share - took_s)
                } else {
                    format!("{took_s:.0} s")
                };
                let _ = write!(stderr(), "\r\u{1b}[K{what}: {left}");
            }
            let _ = write!(stderr(), "\r\u{1b}[K");
        };
        // Whatever ends the work drops this, and so ends the line.
        let (works, ended) = mpsc::channel();
        thread::scope(|scope| {
            let _works = works;
            stderr().is_terminal().then(|| scope.spawn(|| show(ended)));
            let result = work(&|| {
                done.fetch_add(1, Ordering::Relaxed);
            })?;
            Ok((result, start.elapsed().as_secs_f64()))
        })
    }
}

/// The program of this commit, run from now on: files contain what made them.
pub fn provenance(commit: Option<&str>) -> Provenance {
    Provenance::now(env!("CARGO_PKG_VERSION"), commit.unwrap_or("unknown"))
}

/// These fields, and after them those of a document.
pub fn and(mut fields: Value, document: &impl Serialize) -> Result<Value, Failure> {
    if let (Value::Object(fields), Value::Object(more)) = (&mut fields, serde_json::to_value(document)?) {
        fields.extend(more);
    }
    Ok(fields)
}

pub(crate) fn pictures(files: Vec<PathBuf>) -> Vec<PathBuf> {
    let is_picture =
        |path: &PathBuf| path.extension().is_some_and(|ending| ending == "svg" || ending == "pdf" || ending == "png");
    files.into_iter().filter(is_picture).collect()
}

/// Prints on standard output; ends the program quietly where nobody reads on (`cohold cooperate | head -3`).
fn print(text: fmt::Arguments<'_>) {
    match cohold_io::out(text) {
        Ok(()) => {}
        // What a shell sees of a program that the closed pipe ended.
        Err(cause) if cause.kind() == ErrorKind::BrokenPipe => std::process::exit(141),
        Err(cause) => {
            cohold_io::say(format_args!("cohold: cannot write to standard output: {cause}"));
            std::process::exit(2);
        }
    }
}
