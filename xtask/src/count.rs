//! `cargo xtask bench-check` and `cargo xtask count`: instructions against reviewed tables.
//!
//! The first counts one tick on a PC: the bench `instructions` of cohold-cases, under callgrind. The second counts on the
//! board's processor: the programs of tests/count, under QEMU. Either is exact, the same on every run of the same binary,
//! so the tolerance is for C libraries that copy memory differently, for another compiler, and for how the counting
//! program itself happens to be laid out, which shows in the shortest calls. What a change to the code does beyond it is
//! for review (`--bless`, then the difference is in the commit).

use std::process::Command;

use crate::run::{self, Failure, cargo, step};
use crate::setup;

/// The reviewed counts of one tick.
const TICKS: &str = "host-sim/cases/benches/instructions.txt";
/// Number types, in the order of that table's columns.
pub(crate) const SCALARS: [&str; 3] = ["f32", "f64", "i32f32"];
/// Programs of tests/count, and where what they print was reviewed.
const TABLES: [(&str, &str); 2] =
    [("count", "host-sim/studies/src/accuracy/instructions-cortex-m7.txt"), ("wire", WIRE)];
/// The reviewed counts of the wire.
pub(crate) const WIRE: &str = "protocol/instructions-cortex-m7.txt";
/// Largest accepted change, either way, as a fraction.
const TOLERANCE: f64 = 0.02;
/// What is accepted in any case, instructions.
const FEW: f64 = 3.0;

/// Counts one tick and compares, or counts and writes.
pub(crate) fn ticks(bless: bool) -> Result<(), Failure> {
    obstacle().map_or(Ok(()), |obstacle| Err(Failure::new(obstacle)))?;
    match review("bench-check", TICKS, &count_ticks()?, bless)? {
        0 => Ok(()),
        changed => Err(beyond(changed, "bench-check")),
    }
}

/// Why the instructions of one tick cannot be counted here, if so; installs valgrind where that is all that is missing.
pub(crate) fn obstacle() -> Option<String> {
    if !cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        return Some(format!("{TICKS} holds counts of x86-64 Linux; this is another machine"));
    }
    setup::program("valgrind", "valgrind")
}

/// The table of one tick as it is now.
pub(crate) fn count_ticks() -> Result<String, Failure> {
    let mut bench = bench();
    eprintln!("    {}", run::spelled(&bench));
    run::output(&mut bench)
}

/// The bench, on what a first build has compiled: packages chosen together have one set of features.
pub(crate) fn bench() -> Command {
    cargo(&["bench", "--locked", "--quiet", "--bench", "instructions"])
}

/// Counts on the board's processor and compares, or counts and writes.
pub(crate) fn board(bless: bool) -> Result<(), Failure> {
    let ready = step("set-up", setup::setup)?;
    if !run::succeeds(&mut run::command("qemu-system-arm", &["--version"])) {
        return Err(Failure::new("qemu-system-arm does not run; `apt-get install qemu-system-arm` brings it"));
    }
    let mut changed = 0;
    for (program, file) in TABLES {
        let printed = step(program, || {
            let mut cargo = ready.cargo(&["run", "--quiet", "--locked", "--release", "--bin", program]);
            eprintln!("    {}", run::spelled(&cargo));
            // The target and the emulator are settings of that folder.
            run::output(cargo.current_dir(run::root().join("tests/count")))
        })?;
        changed += review("count", file, &printed, bless)?;
        if !bless {
            println!("{printed}");
        }
    }
    if changed == 0 { Ok(()) } else { Err(beyond(changed, "count")) }
}

fn beyond(changed: usize, chore: &str) -> Failure {
    Failure::new(format!(
        "{changed} counts are not within {} % of the reviewed ones (see above): undo what changed them, or accept them \
         with `cargo xtask {chore} --bless`",
        100.0 * TOLERANCE
    ))
}

/// Compares with a reviewed table and gives how many rows differ, or rewrites it.
fn review(chore: &str, file: &str, printed: &str, bless: bool) -> Result<usize, Failure> {
    if bless {
        std::fs::write(run::root().join(file), printed)
            .map_err(|cause| Failure::new(format!("cannot write {file}: {cause}")))?;
        eprintln!("    {file} rewritten: look at its difference");
        return Ok(0);
    }
    let differences = differences(&reviewed(chore, file)?, printed);
    differences.iter().for_each(|difference| eprintln!("    {file}: {difference}"));
    Ok(differences.len())
}

/// A reviewed table.
pub(crate) fn reviewed(chore: &str, file: &str) -> Result<String, Failure> {
    std::fs::read_to_string(run::root().join(file))
        .map_err(|cause| Failure::new(format!("cannot read {file}: {cause}; `cargo xtask {chore} --bless` writes it")))
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
