//! `cargo xtask rig`: prints what each test would do, or with `--page` writes docs/silicon.md.

use std::process::ExitCode;

use haptic_rig::page;

fn main() -> ExitCode {
    if !std::env::args().any(|word| word == "--page") {
        print!("{}", page::plan());
        return ExitCode::SUCCESS;
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/silicon.md");
    match std::fs::write(path, page::silicon()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(cause) => {
            eprintln!("cannot write {path}: {cause}");
            ExitCode::FAILURE
        }
    }
}
