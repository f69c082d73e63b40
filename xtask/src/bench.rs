//! `cargo xtask bench`: measures the tick and the two-peer simulation, prints the README's tables in Markdown.
//!
//! Instructions are exact (callgrind, see [`crate::count`]). Times are those of criterion's fastest sample: what the
//! code takes when nothing else runs in between, which is what repeats on a machine that is shared.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::count::{self, SCALARS};
use crate::run::{self, Failure, cargo};

/// Runs both benches and prints.
pub(crate) fn bench(quick: bool) -> Result<(), Failure> {
    let counts = run::step("instructions", || match count::obstacle() {
        None => count::count_ticks(),
        Some(obstacle) => {
            eprintln!("    NOT COUNTED: {obstacle}");
            Ok(String::new())
        }
    })?;
    let counts: BTreeMap<String, Vec<f64>> = count::rows(&counts).collect();
    let home = run::step("times", || times(quick))?;

    println!("One tick of one peer on x86-64 ({}): instructions, and nanoseconds in brackets.\n", processor());
    println!("| scene | f32 | f64 | I32F32 |\n|---|---:|---:|---:|");
    let ticks = Group::read(&home, "tick")?;
    for scene in &ticks.names {
        let mut row = format!("| {scene} |");
        for (at, scalar) in SCALARS.iter().enumerate() {
            let count = counts.get(scene).and_then(|counts| counts.get(at)).map(f64::to_string);
            let time = ticks.fastest_ns(&format!("{scene}/{scalar}"))? / TICKS_PER_RECORDING;
            row += &format!(" {} ({time:.1}) |", count.unwrap_or_else(|| "–".to_owned()));
        }
        println!("{row}");
    }

    println!("\nTwo peers with their devices and the network between them, f32, one core.\n");
    println!("| scene | million two-peer ticks per second |\n|---|---:|");
    let seconds = Group::read(&home, "two-peer-second")?;
    for scene in &seconds.names {
        println!("| {scene} | {:.1} |", TICKS_PER_SECOND / seconds.fastest_ns(scene)? * 1e3);
    }

    println!("\nThe wire on the board's processor, a Cortex-M7 (reviewed; `cargo xtask count` counts anew).\n");
    println!("| what a link does | instructions |\n|---|---:|");
    for (what, counts) in count::rows(&count::reviewed("count", count::WIRE)?) {
        println!("| {what} | {} |", counts.iter().map(f64::to_string).collect::<String>());
    }
    Ok(())
}

/// Ticks in one replay of a recording: `cases::TICKS` of the benches.
const TICKS_PER_RECORDING: f64 = 800.0;
/// Ticks in a second of the two-peer bench.
const TICKS_PER_SECOND: f64 = 1000.0;

/// Runs criterion; gives where it leaves its results.
fn times(quick: bool) -> Result<PathBuf, Failure> {
    let home = run::root().join("target/criterion");
    // What an earlier version measured must not end up in the tables.
    if home.exists() {
        std::fs::remove_dir_all(&home)
            .map_err(|cause| Failure::new(format!("cannot remove {}: {cause}; remove it by hand", home.display())))?;
    }
    let mut bench = cargo(&["bench", "--locked", "--package", "cohold", "--bench", "ticks", "--"]);
    if quick {
        bench.arg("--quick");
    }
    run::run(bench.env("CRITERION_HOME", &home))?;
    Ok(home)
}

/// Results of one of criterion's groups.
struct Group {
    folder: PathBuf,
    /// Benches of the group, in the order they were run (each writes to a folder of its own).
    names: Vec<String>,
}

impl Group {
    fn read(home: &std::path::Path, group: &str) -> Result<Self, Failure> {
        let folder = home.join(group);
        let lost = |cause| Failure::new(format!("criterion left no results in {}: {cause}", folder.display()));
        let mut found = Vec::new();
        for entry in std::fs::read_dir(&folder).map_err(lost)? {
            let entry = entry.map_err(lost)?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if name != "report" {
                found.push((entry.metadata().and_then(|data| data.modified()).map_err(lost)?, name));
            }
        }
        found.sort();
        Ok(Self { folder, names: found.into_iter().map(|(_, name)| name).collect() })
    }

    /// Time of one iteration in the fastest sample, ns.
    fn fastest_ns(&self, bench: &str) -> Result<f64, Failure> {
        let file = self.folder.join(bench).join("new/sample.json");
        let text = run::read(&file)?;
        let samples = numbers(&text, "\"times\":[").zip(numbers(&text, "\"iters\":["));
        samples.map(|(time, iterations)| time / iterations).min_by(f64::total_cmp).ok_or_else(|| {
            Failure::new(format!("criterion's {} holds no samples: has its format changed?", file.display()))
        })
    }
}

/// The numbers of the JSON array that opens with `label`.
fn numbers<'a>(text: &'a str, label: &str) -> impl Iterator<Item = f64> + use<'a> {
    let inside = text.split_once(label).and_then(|(_, rest)| rest.split_once(']')).map_or("", |(inside, _)| inside);
    inside.split(',').map_while(|number| number.trim().parse().ok())
}

/// What Linux calls the processor.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")).and_then(|line| line.split_once(':'));
    model.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}
