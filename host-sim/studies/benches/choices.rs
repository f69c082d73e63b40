//! Instructions of every numerical choice, exactly: each is replayed under valgrind's callgrind, which counts nothing but
//! the call.
//!
//! `cargo bench --package cohold-studies --bench choices` prints the table that `src/accuracy/instructions-x86-64.txt` holds: written over that
//! file, its difference in the commit is what changed. The program starts itself once under callgrind for every number type (`--replay SCALAR`);
//! after each case [`case_done`] makes callgrind write what it counted. The same binary gives the same counts on every run.
//!
//! Counted: `measured_call` with everything it calls, so loading parameters, storing state and the call itself are in it;
//! mean over the calls of a case. What is called and on which data, `cohold_cases` says.

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use cohold_cases::{Case, Meter};
use cohold_core::num::Fixed;
use cohold_laws::EveryLaw;
use cohold_studies::Error;
use cohold_studies::accuracy::counts::SCALARS;

/// What callgrind counts: `body`, in a function that it can find by its name.
#[inline(never)]
fn measured_call<I, O>(body: &mut impl FnMut(I) -> O, input: I) -> O {
    body(input)
}

/// Where callgrind writes what it counted since the last time.
#[inline(never)]
fn case_done(case: &str) {
    black_box(case);
}

/// Callgrind, addressed by names.
struct Callgrind;

impl Meter for Callgrind {
    fn call<I, O>(body: &mut impl FnMut(I) -> O, input: I) -> O {
        measured_call(body, input)
    }
}

/// The cases of the number type called `scalar`.
fn cases_of(scalar: &str) -> Box<dyn Iterator<Item = Case>> {
    match scalar {
        "f32" => Box::new(cohold_cases::all::<f32, EveryLaw<f32>, Callgrind>()),
        "f64" => Box::new(cohold_cases::all::<f64, EveryLaw<f64>, Callgrind>()),
        _ => Box::new(cohold_cases::all::<Fixed, EveryLaw<Fixed>, Callgrind>()),
    }
}

/// Instructions per call of every case in one number type, counted in a process of its own.
fn count(scalar: &str) -> Result<Vec<(String, u64)>, Error> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("choices-{}", std::process::id()));
    let failed = |what: &str, cause: &dyn std::fmt::Display| format!("{what} {}: {cause}", folder.display());
    std::fs::create_dir_all(&folder).map_err(|cause| failed("cannot make", &cause))?;
    let program = std::env::current_exe().map_err(|cause| failed("cannot find this program for", &cause))?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--toggle-collect=*::measured_*", "--dump-after=*::case_done*"])
        .arg(format!("--callgrind-out-file={}", folder.join("part").display()))
        .arg(program)
        .args(["--replay", scalar])
        .output()
        .map_err(|cause| format!("cannot run valgrind: {cause}; install it, for example with apt-get"))?;
    if !output.status.success() {
        return Err(format!("the replay of {scalar} failed:\n{}", String::from_utf8_lossy(&output.stderr)).into());
    }
    let counts = cases_of(scalar).enumerate().map(|(at, case)| {
        let total = total(&folder.join(format!("part.{}", at + 1)))?;
        let calls = case.calls as u64;
        Ok((case.name, (total + calls / 2) / calls))
    });
    let counts = counts.collect::<Result<Vec<_>, Error>>()?;
    std::fs::remove_dir_all(&folder).map_err(|cause| failed("cannot remove", &cause))?;
    Ok(counts)
}

/// The total of one of callgrind's files.
fn total(file: &Path) -> Result<u64, Error> {
    let text = std::fs::read_to_string(file).map_err(|cause| format!("cannot read {}: {cause}", file.display()))?;
    let total = text.lines().find_map(|line| line.strip_prefix("totals: "));
    match total.and_then(|total| total.trim().parse().ok()) {
        Some(total) if total > 0 => Ok(total),
        _ => Err(format!("{} has no count: was `measured_call` inlined?", file.display()).into()),
    }
}

/// The table as it is reviewed.
fn table() -> Result<String, Error> {
    let mut rows: Vec<(String, Vec<u64>)> = Vec::new();
    for scalar in SCALARS {
        for (at, (name, count)) in count(scalar)?.into_iter().enumerate() {
            match rows.get_mut(at) {
                Some((_, counts)) => counts.push(count),
                None => rows.push((name, vec![count])),
            }
        }
    }
    let mut text = format!(
        "# Instructions per call, x86-64, release build; tick/… per tick of a whole peer.\n\
         # Counted by `cargo bench --package cohold-studies --bench choices`, which prints this table.\n\
         # {:<32} {:>7} {:>7} {:>7}\n",
        "case", SCALARS[0], SCALARS[1], SCALARS[2]
    );
    for (name, counts) in rows {
        text += &format!("{name:<34}");
        counts.iter().for_each(|count| text += &format!(" {count:>7}"));
        text += "\n";
    }
    Ok(text)
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        ["--replay", scalar] => {
            for case in cases_of(scalar) {
                (case.replay)();
                case_done(&case.name);
            }
            Ok(())
        }
        [] => table().map(|text| print!("{text}")),
        _ => Err(format!("there is no option {}", words.join(" ")).into()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}
