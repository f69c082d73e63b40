//! Formatted code lines: what rustfmt makes of a file, 100 wide with its defaults, without blank lines and comment lines.
//!
//! However a file is packed or spread, it counts the same. Nothing is written: rustfmt prints each file that it is given, and the
//! modules that this file names. Macro calls in braces and items below `#[rustfmt::skip]` count as they are, because rustfmt leaves
//! them. A line of a string that begins with `//` counts as a comment.

use std::collections::BTreeMap;
use std::path::Path;

use crate::run::{Failure, command};

/// Words for rustfmt, which outdo the project's own settings.
const WORDS: &str = "--edition 2024 --emit stdout --config max_width=100,use_small_heuristics=Default";

/// Lines of these files below a folder, and of the modules that they name. If a file does not parse, the error names it.
pub(crate) fn of_files(folder: &Path, files: &[&str]) -> Result<BTreeMap<String, usize>, Failure> {
    let (mut counted, mut said) = (BTreeMap::new(), String::new());
    // A crate's root brings its modules, so most files are formatted once. Files that no root names follow.
    for roots in [true, false] {
        let is_due = |file: &&&str| match roots {
            true => file.ends_with("/lib.rs") || file.ends_with("/main.rs"),
            false => !counted.contains_key(**file),
        };
        let mut rustfmt = command("rustfmt", &[]);
        rustfmt.args(WORDS.split(' ')).args(files.iter().filter(is_due)).current_dir(folder);
        let output = rustfmt.output().map_err(|cause| Failure::new(format!("rustfmt: {cause}")))?;
        count(&String::from_utf8_lossy(&output.stdout), folder, &mut counted);
        said += &String::from_utf8_lossy(&output.stderr);
    }
    match files.iter().find(|file| !counted.contains_key(**file)) {
        None => Ok(counted),
        // rustfmt's first two lines name a mistake and its place, which may be in a module of this file.
        Some(file) => {
            let why: String = said.lines().take(2).collect();
            Err(Failure::new(format!("cannot count the lines of {file}: rustfmt says `{why}`")))
        }
    }
}

/// Counts the code lines of each file in what rustfmt prints: `/folder/file.rs:`, a blank line, and the file.
fn count(printed: &str, folder: &Path, counted: &mut BTreeMap<String, usize>) {
    let header = format!("{}/", folder.display());
    let (mut file, mut in_comment) = (String::new(), false);
    for line in printed.lines() {
        let mut code = line.trim();
        if in_comment || code.starts_with("/*") {
            let end = code.split_once("*/");
            in_comment = end.is_none();
            code = end.map_or("", |(_, behind)| behind.trim());
        }
        if let Some(name) = line.strip_prefix(&header) {
            file = name.trim_end_matches(':').to_owned();
            // A file that two others name is printed twice.
            counted.insert(file.clone(), 0);
        } else if !code.is_empty() && !code.starts_with("//") {
            *counted.entry(file.clone()).or_default() += 1;
        }
    }
}

#[cfg(test)]
#[path = "../tests/inside/lines.rs"]
mod tests;
