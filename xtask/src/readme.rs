//! `cargo xtask readme`: writes what commands print and draw into README.md and the pages under docs/, so that no figure
//! there is older than the code. It also runs the commands of tutorials, and looks whether links lead anywhere.
//!
//! | marker on a separate line | what follows it |
//! |---|---|
//! | `<!-- cohold ARGUMENTS -->` | before a fenced block: the command's standard output |
//! | `<!-- first N lines of cohold ARGUMENTS -->` | before a fenced block: where its output begins |
//! | `<!-- table of cohold ARGUMENTS -->` | before a Markdown table: the first table of its output |
//! | `<!-- file PATH -->` | before a fenced block: a reviewed file of the repository |
//! | `<!-- PATH from cohold ARGUMENTS -->` | before a picture: the file that the command writes, copied to where the picture is |
//! | `<!-- run -->` | before a fenced block: commands that `--check` runs, those of one page in order and in one folder |
//!
//! Commands run in an empty folder, so that what they name does not depend on what others have written. Only commands whose
//! output does not depend on the clock belong there. `--check` changes nothing, compares no pictures, and fails where a text
//! would change.

use std::path::{Path, PathBuf};

use crate::board::target;
use crate::run::{self, Failure, command, output_up_to};

/// Refreshes all pages or one, or checks that they are fresh.
pub(crate) fn readme(check: bool, page: Option<&str>) -> Result<(), Failure> {
    let cohold = Program { program: run::cohold(true)?.display().to_string(), empty: target().join("pages") };
    let pages = page.map_or_else(pages, |page| Ok(vec![run::root().join(page)]))?;
    if check {
        run::run(&mut command("python3", &["xtask/pages.py", "run", &cohold.program]))?;
    }
    let stale = pages.iter().map(|page| refresh(page, &cohold, check)).collect::<Result<Vec<_>, _>>()?;
    match stale.into_iter().flatten().collect::<Vec<_>>() {
        stale if check && !stale.is_empty() => Err(Failure::new(format!(
            "{} does not say what its commands print; `cargo xtask readme` mends it",
            stale.join(", ")
        ))),
        _ => Ok(()),
    }
}

/// Package that builds the site.
const MDBOOK: &str = "mdbook@0.5.4";

/// Builds the pages of docs/ as a site.
pub(crate) fn site() -> Result<(), Failure> {
    let tools = target().join("tools");
    run::run(run::cargo(&["install", "--locked", MDBOOK, "--root"]).arg(&tools))?;
    run::run(command(&tools.join("bin/mdbook").to_string_lossy(), &["build", "docs"]).env("RUST_LOG", "warn"))
}

/// Every page of the repository that git knows, or would add.
fn pages() -> Result<Vec<PathBuf>, Failure> {
    let listed = run::output(&mut command("git", &["ls-files", "--cached", "--others", "--exclude-standard", "*.md"]))?;
    let there = |path: PathBuf| path.exists().then_some(path);
    Ok(listed.lines().filter_map(|path| there(run::root().join(path))).collect())
}

fn failed(what: &str, path: &Path, cause: &std::io::Error) -> Failure {
    Failure::new(format!("cannot {what} {}: {cause}", path.display()))
}

/// What stands in an HTML comment that is a line of its own.
fn marker(line: &str) -> Option<&str> {
    line.trim().strip_prefix("<!-- ")?.strip_suffix(" -->")
}

/// The file of a picture, `![words](FILE)` or `<img src="FILE" …>`.
fn shown(line: &str) -> Option<&str> {
    let linked = || line.strip_prefix("![")?.strip_suffix(')')?.split_once("](").map(|(_, file)| file);
    let placed = || line.strip_prefix("<img src=\"")?.strip_suffix('>')?.split_once('"').map(|(file, _)| file);
    linked().or_else(placed)
}

/// Replaces every block of a page by what its command prints now; its name, if that changes it.
fn refresh(page: &Path, cohold: &Program, check: bool) -> Result<Option<String>, Failure> {
    let name = page.strip_prefix(run::root()).unwrap_or(page).display().to_string();
    let old = run::read(page)?;
    let mut fresh = String::new();
    let mut lines = old.lines().peekable();
    while let Some(line) = lines.next() {
        fresh += line;
        fresh += "\n";
        let Some(command) = marker(line) else { continue };
        let begins = command.strip_prefix("first ").and_then(|rest| rest.split_once(" lines of "));
        let (most, command) = match begins.and_then(|(number, command)| Some((number.parse().ok()?, command))) {
            Some(beginning) => beginning,
            None => (usize::MAX, command),
        };
        if let Some((picture, arguments)) = command.split_once(" from cohold ") {
            let shown = lines.peek().and_then(|line| shown(line));
            let shown = shown.ok_or_else(|| Failure::new(format!("{name}: `{line}` is not followed by a picture")))?;
            if !check {
                cohold.prints(arguments)?;
                let (from, to) = (cohold.empty.join(picture), page.with_file_name(shown));
                std::fs::copy(&from, to).map_err(|cause| failed("copy", &from, &cause))?;
            }
        } else if let Some(arguments) = command.strip_prefix("table of cohold ") {
            let table = markdown(&cohold.prints(arguments)?);
            fresh += &table.ok_or_else(|| Failure::new(format!("{name}: `{line}` prints no table")))?;
            while lines.next_if(|line| line.starts_with('|')).is_some() {}
        } else if command.starts_with("cohold ") || command.starts_with("file ") {
            let printed = match command.strip_prefix("file ") {
                Some(path) => run::read(&run::root().join(path))?,
                None => cohold.prints(command.trim_start_matches("cohold "))?,
            };
            let shown: Vec<&str> = printed.trim_end().lines().take(most).collect();
            fresh += &format!("```text\n{}\n```\n", shown.join("\n"));
            // The block that is replaced: from its opening fence to its closing one.
            if lines.next().is_none_or(|line| line != "```text") || !lines.by_ref().any(|line| line == "```") {
                return Err(Failure::new(format!("{name}: `{line}` is not followed by a ```text block")));
            }
        }
    }
    if fresh == old {
        return Ok(None);
    }
    if !check {
        std::fs::write(page, fresh).map_err(|cause| failed("write", page, &cause))?;
    }
    Ok(Some(name))
}

/// The first table of a text in Markdown, the cells of its first column as code. In the text a line of dashes below the headings
/// says how wide the columns are.
fn markdown(printed: &str) -> Option<String> {
    let lines: Vec<&str> = printed.lines().collect();
    let is_rule = |line: &&str| line.starts_with('-') && line.chars().all(|sign| matches!(sign, '-' | ' '));
    let rule = lines.iter().position(is_rule)?;
    let widths: Vec<usize> = lines[rule].split("  ").map(str::len).collect();
    let row = |line: &str, first: &str| {
        let mut signs = line.chars();
        let cell = |(at, width): (usize, &usize)| {
            let last = at + 1 == widths.len();
            let text: String = signs.by_ref().take(if last { usize::MAX } else { width + 2 }).collect();
            let text = text.trim().replace('|', "\\|");
            let text = if text == "-" { "–" } else { &text };
            if at == 0 { format!("{first}{text}{first}") } else { text.to_owned() }
        };
        format!("| {} |\n", widths.iter().enumerate().map(cell).collect::<Vec<_>>().join(" | "))
    };
    let rows = lines[rule + 1..].iter().take_while(|line| !line.is_empty()).map(|line| row(line, "`"));
    Some(
        row(lines[rule.checked_sub(1)?], "")
            + &format!("|{}\n", "---|".repeat(widths.len()))
            + &rows.collect::<String>(),
    )
}

/// cohold as a newcomer's first command builds it.
struct Program {
    program: String,
    /// The folder in which it runs.
    empty: PathBuf,
}

impl Program {
    /// Its standard output, run in the folder after that was emptied; spaces at line ends are removed.
    fn prints(&self, arguments: &str) -> Result<String, Failure> {
        let empty = &self.empty;
        if empty.exists() {
            std::fs::remove_dir_all(empty).map_err(|cause| failed("empty", empty, &cause))?;
        }
        std::fs::create_dir_all(empty).map_err(|cause| failed("make", empty, &cause))?;
        let mut command = command(&self.program, &arguments.split_whitespace().collect::<Vec<_>>());
        // 1: it is done, and says of an unstable scene that it is one.
        let printed = output_up_to(command.current_dir(empty), 1)?;
        Ok(printed.lines().map(str::trim_end).collect::<Vec<_>>().join("\n"))
    }
}

#[cfg(test)]
#[path = "../tests/inside/readme.rs"]
mod tests;
