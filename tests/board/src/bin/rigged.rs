//! `cargo xtask rig --virtual`: the list of tests/rig, as far as two virtual boards can run it, through the rig's own image.

use std::process::ExitCode;
use std::time::Instant;

use board_bench::image::Firmware;
use board_bench::{reviewed, rig};
use haptic_rig::list::{TESTS, Virtual};
use haptic_rig::run::{self, Extent};

fn main() -> ExitCode {
    let begun = Instant::now();
    let mut rigged = match rig::start(Firmware::release()) {
        Ok(rigged) => rigged,
        Err(why) => {
            eprintln!("rig: {why}");
            return ExitCode::FAILURE;
        }
    };
    let mut failed = 0;
    for test in TESTS {
        let extent = match test.virtual_rig {
            Virtual::Runs(extent) => extent,
            Virtual::Not(reason) => {
                println!("{:<24}not run: {reason}", test.name);
                continue;
            }
        };
        let outcome =
            run::run(&mut rigged, &test, Extent::Virtual).unwrap_or(Err("nobody has written it down".to_owned()));
        let (verdict, figures) = match &outcome {
            Ok(figures) => ("passed", figures),
            Err(figures) => ("FAILED", figures),
        };
        failed += u32::from(outcome.is_err());
        println!("{:<24}{verdict} ({extent}): {figures}", test.name);
    }
    let seconds = rigged.now_ns() as f64 * 1e-9;
    for report in rigged.finish() {
        reviewed::check(&report);
    }
    println!(
        "{seconds:.1} s of two virtual boards in {:.1} s; nothing of it was silicon",
        begun.elapsed().as_secs_f64()
    );
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
