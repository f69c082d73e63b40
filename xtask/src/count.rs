//! `cargo xtask count`: instructions on the board's processor against the reviewed tables.
//!
//! The programs of tests/count run under QEMU and print what they counted: the same on every run of the same binary, so the
//! tolerance is for another compiler, and for how the counting program itself happens to be laid out, which shows in the
//! shortest calls. What a change to the code does beyond it is for review (`--bless`).

use std::path::Path;
use std::process::Command;

use crate::run::{self, Failure, step};
use crate::setup;

/// Programs of tests/count, and where what they print was reviewed.
const TABLES: [(&str, &str); 2] =
    [("count", "host-sim/src/studies/accuracy/instructions-cortex-m7.txt"), ("wire", WIRE)];
/// The reviewed counts of the wire.
pub(crate) const WIRE: &str = "protocol/instructions-cortex-m7.txt";
/// Largest accepted change, either way, as a fraction.
const TOLERANCE: f64 = 0.02;
/// What is accepted in any case, instructions.
const FEW: f64 = 3.0;

/// Counts and compares, or counts and writes.
pub(crate) fn count(bless: bool) -> Result<(), Failure> {
    let ready = step("set-up", setup::setup)?;
    if !run::succeeds(&mut run::command("qemu-system-arm", &["--version"])) {
        return Err(Failure::new("qemu-system-arm does not run; `apt-get install qemu-system-arm` brings it"));
    }
    let mut changed = 0;
    for (program, file) in TABLES {
        let printed = step(program, || {
            let mut cargo = run::cargo(&["run", "--quiet", "--locked", "--release", "--bin", program]);
            if ready.fallback {
                cargo.arg("--ignore-rust-version");
            }
            // The target and the emulator are settings of that folder.
            output(cargo.current_dir(run::root().join("tests/count")).env("RUSTUP_TOOLCHAIN", &ready.thumb_toolchain))
        })?;
        if bless {
            write(&run::root().join(file), &printed)?;
            eprintln!("    {file} rewritten: look at its difference");
            continue;
        }
        let differences = differences(&reviewed(file)?, &printed);
        changed += differences.len();
        for difference in differences {
            eprintln!("    {file}: {difference}");
        }
        println!("{printed}");
    }
    match changed {
        0 => Ok(()),
        _ => Err(Failure::new(format!(
            "{changed} counts are not within {} % of the reviewed ones (see above): undo what changed them, or accept \
             them with `cargo xtask count --bless`",
            100.0 * TOLERANCE
        ))),
    }
}

/// A reviewed table.
pub(crate) fn reviewed(file: &str) -> Result<String, Failure> {
    std::fs::read_to_string(run::root().join(file))
        .map_err(|cause| Failure::new(format!("cannot read {file}: {cause}; `cargo xtask count --bless` writes it")))
}

fn output(command: &mut Command) -> Result<String, Failure> {
    eprintln!("    {}", run::spelled(command));
    run::output(command)
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(|cause| Failure::new(format!("cannot write {}: {cause}", path.display())))
}

/// A table's rows: what was counted, and the counts.
pub(crate) fn rows(table: &str) -> impl Iterator<Item = (String, Vec<f64>)> {
    table.lines().filter(|line| !line.starts_with('#')).map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let counts = words.iter().rev().take_while(|word| word.parse::<u64>().is_ok()).count();
        let (name, counts) = words.split_at(words.len() - counts);
        (name.join(" "), counts.iter().filter_map(|count| count.parse().ok()).collect())
    })
}

/// What differs beyond the tolerance, or is in one table only.
fn differences(reviewed: &str, printed: &str) -> Vec<String> {
    let before: Vec<_> = rows(reviewed).collect();
    let mut found = Vec::new();
    for (name, now) in rows(printed) {
        match before.iter().find(|(known, _)| *known == name) {
            None => found.push(format!("{name} was not counted before")),
            Some((_, then)) => {
                let near = |(now, then): (&f64, &f64)| (now - then).abs() <= FEW.max(TOLERANCE * then);
                if now.len() != then.len() || !now.iter().zip(then).all(near) {
                    found.push(format!("{name}: {now:?}, was {then:?}"));
                }
            }
        }
    }
    let gone = before.iter().filter(|(name, _)| rows(printed).all(|(known, _)| known != *name));
    found.extend(gone.map(|(name, _)| format!("{name} is no longer counted")));
    found
}

#[cfg(test)]
#[path = "../tests/inside/count.rs"]
mod tests;
