//! `cargo xtask drawings`: draws the sheets of docs/guides/board/assembly.md and writes its tables, or with `--check` says what differs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use cohold_wiring::netlist::Netlist;
use cohold_wiring::{page, rules, sheet, svg};

fn main() -> ExitCode {
    let check = std::env::args().any(|word| word == "--check");
    match written(check) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

fn written(check: bool) -> Result<(), String> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let netlist = Netlist::parse(&read(&here.join("netlist.toml"))?)?;
    let wrong = rules::wrong(&netlist);
    if !wrong.is_empty() {
        return Err(wrong.join("\n"));
    }
    let docs = here.join("../../docs");
    let [first, second] = page::PAGES.map(|page| docs.join(page));
    let filled = page::filled([read(&first)?, read(&second)?], &netlist)?;
    let mut files: Vec<(PathBuf, String)> = [first, second].into_iter().zip(filled).collect();
    for sheet in &netlist.sheet {
        let drawing = sheet::draw(&netlist, sheet)?;
        files.push((docs.join(format!("{}.svg", sheet.file)), svg::svg(&drawing, &sheet.title)));
    }
    for (path, text) in files {
        if check && read(&path)? != text {
            return Err(format!("{} is not what the netlist says; `cargo xtask drawings` writes it", path.display()));
        }
        if !check {
            std::fs::write(&path, text).map_err(|cause| format!("cannot write {}: {cause}", path.display()))?;
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|cause| format!("cannot read {}: {cause}", path.display()))
}
