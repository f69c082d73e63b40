//! Instructions of one tick, exactly: every case is replayed under valgrind's callgrind, which counts nothing but the
//! step.
//!
//! `cargo bench --bench instructions` prints the table that `instructions.txt` holds, which
//! `cargo xtask bench-check` compares it with. The program starts itself once more for every case:
//! `… --case SCENE SCALAR` replays that case alone. The same binary gives the same count on every run; what an update of
//! the compiler changes is for review.
//!
//! Counted: `ticks::measured_tick` with everything it calls, mean of [`TICKS`] ticks; the exchange before every 8th
//! tick is in the mean with an eighth of its cost.

use std::process::{Command, ExitCode};

use cohold_cases::ticks::{self, Measure, Recording, TICKS};
use cohold_core::law::Law;
use cohold_core::num::Scalar;
use cohold_core::settings::Settings;

/// Replays the one case that was asked for.
struct Replay<'a> {
    scene: &'a str,
    scalar: &'a str,
    found: bool,
}

impl Measure for Replay<'_> {
    fn case<S: Scalar, L: Law<S>>(&mut self, scene: &'static str, settings: &Settings) {
        if scene == self.scene && S::NAME == self.scalar {
            self.found = true;
            Recording::<S, L>::new(settings).replay(ticks::measured_tick);
        }
    }
}

/// Starts a counter for every case: rows of a scene and its counts, in the order of the columns; or why there are none.
struct Count(Result<Vec<(&'static str, Vec<u64>)>, String>);

impl Measure for Count {
    fn case<S: Scalar, L: Law<S>>(&mut self, scene: &'static str, _: &Settings) {
        let Ok(rows) = &mut self.0 else { return };
        match (count(scene, S::NAME), rows.last_mut().filter(|(last, _)| *last == scene)) {
            (Ok(count), Some((_, counts))) => counts.push(count),
            (Ok(count), None) => rows.push((scene, vec![count])),
            (Err(why), _) => self.0 = Err(why),
        }
    }
}

/// Instructions per tick of one case, counted in a process of its own.
fn count(scene: &str, scalar: &str) -> Result<u64, String> {
    let program = std::env::current_exe().map_err(|cause| format!("cannot find this program's own file: {cause}"))?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null", "--toggle-collect=*measured_tick*"])
        .arg(program)
        .args(["--case", scene, scalar])
        .output()
        .map_err(|cause| format!("cannot run valgrind: {cause}; `cargo xtask bench-check` installs it"))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let collected = text.lines().find_map(|line| line.split_once("Collected :")).map(|(_, count)| count.trim());
    match collected.and_then(|count| count.parse::<u64>().ok()) {
        Some(count) if output.status.success() => Ok((count + TICKS as u64 / 2) / TICKS as u64),
        _ => Err(format!("valgrind gave no count for {scene} in {scalar}; it said:\n{text}")),
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [flag, scene, scalar] = arguments.as_slice()
        && flag == "--case"
    {
        let mut replay = Replay { scene, scalar, found: false };
        ticks::measure_all(&mut replay);
        return if replay.found { ExitCode::SUCCESS } else { ExitCode::from(2) };
    }
    let mut count = Count(Ok(Vec::new()));
    ticks::measure_all(&mut count);
    let rows = match count.0 {
        Ok(rows) => rows,
        Err(why) => {
            eprintln!("error: {why}");
            return ExitCode::FAILURE;
        }
    };
    println!(
        "# Instructions of one tick, x86-64, release build. Checked by `cargo xtask bench-check`, rewritten by its --bless."
    );
    println!("{:<36} {:>7} {:>7} {:>7}", "scene", "f32", "f64", "i32f32");
    for (scene, counts) in rows {
        println!("{scene:<36}{}", counts.iter().map(|count| format!(" {count:>7}")).collect::<String>());
    }
    ExitCode::SUCCESS
}
