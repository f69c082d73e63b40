//! `cargo xtask readme`: writes what the commands named in README.md print into it, so that no figure there is older than
//! the code.
//!
//! A block begins with `<!-- host-sim ARGUMENTS -->`, the command whose standard output the next fenced block holds, or with
//! `<!-- file PATH -->`, a reviewed file of the repository; a picture with `<!-- PATH from host-sim ARGUMENTS -->`: the
//! command is run and the file it wrote copied to docs/. Only commands whose output does not depend on the clock belong
//! there. `--check` changes nothing, draws no pictures, and fails where the text would change.

use std::path::Path;

use crate::run::{self, Failure, cargo, output};

/// Refreshes README.md, or checks that it is fresh.
pub(crate) fn readme(check: bool) -> Result<(), Failure> {
    let file = run::root().join("README.md");
    let old =
        std::fs::read_to_string(&file).map_err(|cause| Failure::new(format!("cannot read README.md: {cause}")))?;
    let new = refresh(&old, check)?;
    if check {
        return if old == new {
            Ok(())
        } else {
            Err(Failure::new("README.md does not say what its commands print; `cargo xtask readme` mends it"))
        };
    }
    std::fs::write(&file, new).map_err(|cause| Failure::new(format!("cannot write README.md: {cause}")))?;
    for line in old.lines() {
        if let Some((picture, _)) = marker(line).and_then(|text| text.split_once(" from host-sim ")) {
            let (from, name) = (run::root().join(picture), Path::new(picture).file_name().unwrap_or_default());
            let to = run::root().join("docs").join(name);
            std::fs::copy(&from, &to).map_err(|cause| {
                Failure::new(format!("cannot copy {} to {}: {cause}", from.display(), to.display()))
            })?;
        }
    }
    Ok(())
}

/// What stands in an HTML comment that is a line of its own.
fn marker(line: &str) -> Option<&str> {
    line.trim().strip_prefix("<!-- ")?.strip_suffix(" -->")
}

/// The text with every block replaced by what its command prints now.
fn refresh(text: &str, check: bool) -> Result<String, Failure> {
    let mut fresh = String::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        fresh += line;
        fresh += "\n";
        let Some(command) = marker(line) else { continue };
        let printed = if let Some((_, arguments)) = command.split_once(" from host-sim ") {
            if !check {
                host_sim(arguments)?;
            }
            continue;
        } else if let Some(arguments) = command.strip_prefix("host-sim") {
            host_sim(arguments)?
        } else if let Some(path) = command.strip_prefix("file ") {
            std::fs::read_to_string(run::root().join(path))
                .map_err(|cause| Failure::new(format!("README.md: cannot read {path}: {cause}")))?
        } else {
            continue;
        };
        fresh += &format!("```text\n{}\n```\n", printed.trim_end());
        // The block that is replaced: from its opening fence to its closing one.
        if lines.next().is_none_or(|line| line != "```text") || !lines.by_ref().any(|line| line == "```") {
            return Err(Failure::new(format!("README.md: `{line}` is not followed by a ```text block")));
        }
    }
    Ok(fresh)
}

/// Standard output of host-sim, blanks at line ends removed; warnings it gave come first.
fn host_sim(arguments: &str) -> Result<String, Failure> {
    // The build that the tests have made: the golden traces show that any build computes the same bits.
    let mut command = cargo(&["run", "--quiet", "--locked", "--package", "host-sim", "--"]);
    let printed = output(command.args(arguments.split_whitespace()))?;
    Ok(printed.lines().map(str::trim_end).collect::<Vec<_>>().join("\n"))
}
