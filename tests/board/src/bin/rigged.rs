//! `cargo xtask rig`: the list of tests/rig with two boards on a table, or as far as two virtual boards can run it, through the rig's own image.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use board_bench::image::Firmware;
use board_bench::rig::openocd::OpenOcd;
use board_bench::rig::table::Table;
use board_bench::{reviewed, rig};
use clap::{Args, Parser, Subcommand};
use cohold_rig::list::{TESTS, Test, Virtual};
use cohold_rig::run::{self, Boards, Extent};
use cohold_rig::shown::{self, Shown};

/// What to run; without a table, on virtual boards.
#[derive(Debug, Parser)]
struct Asked {
    /// One test alone.
    #[arg(long, value_parser = TESTS.map(|test| test.name))]
    only: Option<String>,
    /// How long the soak takes, s.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=604_800))]
    seconds: Option<u32>,
    #[command(subcommand)]
    place: Option<Place>,
}

#[derive(Debug, Subcommand)]
enum Place {
    /// Two boards on a table.
    Table(OnATable),
}

/// Two boards on a table.
#[derive(Debug, Args)]
struct OnATable {
    /// The address of the board under test.
    #[arg(long)]
    board: SocketAddr,
    /// Its operator's key file.
    #[arg(long)]
    key: PathBuf,
    /// The rig's serial port.
    #[arg(long)]
    port: PathBuf,
    /// Serial number of the probe of the board under test.
    #[arg(long)]
    probe: String,
    /// Which image it runs.
    #[arg(long)]
    image: String,
    /// Which day it is.
    #[arg(long)]
    day: String,
    /// Where is kept what came of a test.
    #[arg(long)]
    kept: PathBuf,
}

fn main() -> ExitCode {
    let asked = Asked::parse();
    let all_passed = match &asked.place {
        Some(Place::Table(table)) => table.run(&asked),
        None => virtually(&asked),
    };
    match all_passed {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(why) => {
            eprintln!("rig: {why}");
            ExitCode::FAILURE
        }
    }
}

/// Runs tests one after the other, and tells of each: whether all passed.
fn run(
    boards: &mut dyn Boards,
    asked: &Asked,
    extent: Extent,
    mut each: impl FnMut(&Test, bool, &str) -> Result<(), String>,
) -> Result<bool, String> {
    let mut all_passed = true;
    for test in TESTS.iter().filter(|test| asked.only.as_deref().is_none_or(|only| only == test.name)) {
        let why_not = match (extent, test.virtual_rig) {
            (Extent::Virtual, Virtual::Not(reason)) => Some(reason),
            (Extent::Whole, _) if asked.only.is_none() && test.is_direct() => Some("its wires are others: --only"),
            _ => None,
        };
        let ran = if why_not.is_none() { run::run(boards, test, extent, asked.seconds) } else { None };
        let Some(outcome) = ran else {
            println!("{:<24}not run: {}", test.name, why_not.unwrap_or("nobody has written it down"));
            continue;
        };
        let (verdict, figures) = match &outcome {
            Ok(figures) => ("passed", figures),
            Err(figures) => ("FAILED", figures),
        };
        all_passed &= outcome.is_ok();
        let extent = match test.virtual_rig {
            Virtual::Runs(some) if extent == Extent::Virtual => format!(" ({some})"),
            _ => String::new(),
        };
        println!("{:<24}{verdict}{extent}: {figures}", test.name);
        each(test, outcome.is_ok(), figures)?;
    }
    Ok(all_passed)
}

fn virtually(asked: &Asked) -> Result<bool, String> {
    let begun = Instant::now();
    let mut rigged = rig::start(Firmware::release())?;
    let all_passed = run(&mut rigged, asked, Extent::Virtual, |_, _, _| Ok(()))?;
    let seconds = rigged.now_ns() as f64 * 1e-9;
    for report in rigged.finish() {
        reviewed::check(&report);
    }
    println!(
        "{seconds:.1} s of two virtual boards in {:.1} s; nothing of it was silicon",
        begun.elapsed().as_secs_f64()
    );
    Ok(all_passed)
}

impl OnATable {
    /// What comes of a test is kept at once: whoever pulls a plug in the tenth hour keeps nine.
    fn run(&self, asked: &Asked) -> Result<bool, String> {
        let probe = Box::new(OpenOcd::new(&self.probe));
        let mut table = Table::connect(self.board, &self.key, &self.port, probe)?;
        run::set_up(&mut table)?;
        run(&mut table, asked, Extent::Whole, |test, passed, figures| {
            let [name, day, image, figures] = [test.name, &self.day, &self.image, figures].map(str::to_owned);
            self.keep(Shown { name, passed, day, image, figures })
        })
    }

    fn keep(&self, shown: Shown) -> Result<(), String> {
        let at = self.kept.display();
        let text = std::fs::read_to_string(&self.kept).map_err(|cause| format!("cannot read {at}: {cause}"))?;
        let text = shown::with(&text, shown).map_err(|why| format!("{at}: {why}"))?;
        std::fs::write(&self.kept, text).map_err(|cause| format!("cannot write {at}: {cause}"))
    }
}
