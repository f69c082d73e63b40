//! `cargo xtask bench`: measures the tick and the two-peer simulation, prints the README's tables in Markdown.
//!
//! Instructions are exact (callgrind, see [`crate::instructions`]); times are criterion's medians on this machine, so the
//! tables name it.

use std::path::PathBuf;

use crate::instructions::{self, SCALARS};
use crate::run::{self, Failure, cargo};

/// Runs both benches and prints.
pub(crate) fn bench(quick: bool) -> Result<(), Failure> {
    let counts = run::step("instructions", || match instructions::obstacle()? {
        None => instructions::count().map(Some),
        Some(obstacle) => {
            eprintln!("    NOT COUNTED: {obstacle}");
            Ok(None)
        }
    })?;
    let home = run::step("times", || times(quick))?;

    println!("One tick of one peer on x86-64 ({}): instructions, and nanoseconds in brackets.\n", processor());
    println!("| scene | f32 | f64 | I32F32 |\n|---|---:|---:|---:|");
    let ticks = Group::read(&home, "tick")?;
    for scene in &ticks.names {
        let mut row = format!("| {scene} |");
        for (at, scalar) in SCALARS.iter().enumerate() {
            let count = counts.as_ref().and_then(|counts| counts.of.get(scene)).map(|counts| counts[at].to_string());
            let time = ticks.median_ns(&format!("{scene}/{scalar}"))? / TICKS_PER_RECORDING;
            row += &format!(" {} ({time:.1}) |", count.unwrap_or_else(|| "–".to_owned()));
        }
        println!("{row}");
    }

    println!("\nTwo peers with their devices and the network between them, f32, one core.\n");
    println!("| scene | million two-peer ticks per second |\n|---|---:|");
    let seconds = Group::read(&home, "two-peer-second")?;
    for scene in &seconds.names {
        println!("| {scene} | {:.1} |", TICKS_PER_SECOND / seconds.median_ns(scene)? * 1e3);
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
    let mut bench = cargo(&["bench", "--locked", "--package", "host-sim", "--bench", "ticks", "--"]);
    if quick {
        bench.arg("--quick");
    }
    run::run(bench.env("CRITERION_HOME", &home))?;
    Ok(home)
}

/// Results of one of criterion's groups.
struct Group {
    folder: PathBuf,
    /// Benches of the group, in the order they were run.
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
                found.push((entry.metadata().and_then(|data| data.created()).map_err(lost)?, name));
            }
        }
        found.sort();
        Ok(Self { folder, names: found.into_iter().map(|(_, name)| name).collect() })
    }

    /// Median time of one iteration, ns.
    fn median_ns(&self, bench: &str) -> Result<f64, Failure> {
        let file = self.folder.join(bench).join("new/estimates.json");
        let text = std::fs::read_to_string(&file)
            .map_err(|cause| Failure::new(format!("cannot read criterion's {}: {cause}", file.display())))?;
        let estimate = text.split_once("\"median\"").and_then(|(_, rest)| rest.split_once("\"point_estimate\":"));
        let number =
            estimate.and_then(|(_, rest)| rest.split([',', '}']).next()).and_then(|number| number.trim().parse().ok());
        number.ok_or_else(|| {
            Failure::new(format!("criterion's {} holds no median: has its format changed?", file.display()))
        })
    }
}

/// What Linux calls the processor.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")).and_then(|line| line.split_once(':'));
    model.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned())
}
