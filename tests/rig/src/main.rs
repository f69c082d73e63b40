//! `cargo xtask rig`: prints what each test would do, or with `--page` writes docs/results/hardware.md.

use std::process::ExitCode;

use cohold_rig::{page, shown};

fn main() -> ExitCode {
    if !std::env::args().any(|word| word == "--page") {
        print!("{}", page::plan());
        return ExitCode::SUCCESS;
    }
    match write() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

/// The page of what was kept.
fn write() -> Result<(), String> {
    let kept = concat!(env!("CARGO_MANIFEST_DIR"), "/silicon.txt");
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/results/hardware.md");
    let text = std::fs::read_to_string(kept).map_err(|cause| format!("cannot read {kept}: {cause}"))?;
    let shown = shown::read(&text).map_err(|why| format!("{kept}: {why}"))?;
    std::fs::write(page, page::silicon(&shown)).map_err(|cause| format!("cannot write {page}: {cause}"))
}
