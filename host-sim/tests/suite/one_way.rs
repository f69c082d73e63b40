//! There is one way to read a file, one to write one and one to print: `cohold_io`. Sources of every PC package are searched for others.

use std::path::Path;

/// What opens, reads, writes or prints around it.
const OTHERS: [&str; 16] = [
    "fs::read(",
    "fs::read_to_string(",
    "fs::write(",
    "fs::rename(",
    "fs::copy(",
    "fs::hard_link(",
    "File::open(",
    "File::create",
    "OpenOptions",
    "from_path(",
    "NamedTempFile",
    "println!(",
    "print!(",
    "dbg!(",
    "io::stdout()",
    "io::stderr()",
];

/// Where a line has one of them all the same, and why.
const ALLOWED: [(&str, &str); 4] = [
    // The way itself.
    ("host-sim/io/src/", ""),
    // What the system says of itself.
    ("", "\"/proc/"),
    ("host-sim/guests/devices/src/find.rs", "interface.join(\"type\")"),
    // A serial line is no file.
    ("host-sim/guests/devices/src/can.rs", "OpenOptionsExt"),
];

fn search(folder: &Path, found: &mut Vec<String>, files: &mut usize) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            search(&path, found, files);
            continue;
        }
        if path.extension().is_none_or(|ending| ending != "rs") {
            continue;
        }
        *files += 1;
        let (text, place) = (std::fs::read_to_string(&path).expect("a source"), path.display().to_string());
        for (number, line) in (1..).zip(text.lines()) {
            let is_comment = line.trim_start().starts_with("//");
            let is_allowed = ALLOWED.iter().any(|(of, what)| place.contains(of) && line.contains(what));
            if !is_comment && !is_allowed && OTHERS.iter().any(|other| line.contains(other)) {
                found.push(format!("{place}:{number}: {}", line.trim()));
            }
        }
    }
}

#[test]
fn every_file_and_every_line_goes_one_way() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut found, mut files) = (Vec::new(), 0);
    let packages = std::fs::read_dir(here).expect("a folder").map(|entry| entry.expect("an entry").path().join("src"));
    for sources in packages.filter(|sources| sources.is_dir()).chain([here.join("src")]) {
        search(&sources, &mut found, &mut files);
    }
    assert!(files > 300, "{files} files");
    assert!(found.is_empty(), "{}", found.join("\n"));
}
