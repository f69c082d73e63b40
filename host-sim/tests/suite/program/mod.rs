//! cohold as a user runs it: programs, addresses and keys, for every test that starts processes with lines of their own.

pub(crate) mod built;
mod free;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use serde_json::Value;

/// The program with these arguments, its output kept.
pub(crate) fn cohold(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cohold"));
    command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// A program in Python that needs nothing installed, by its path from this package, with what it is told; its output is kept.
pub(crate) fn in_python(program: &Path, told: &Value) -> Command {
    let mut command = Command::new("python3");
    command.arg(Path::new(env!("CARGO_MANIFEST_DIR")).join(program)).arg(told.to_string());
    command.env("PYTHONDONTWRITEBYTECODE", "1").stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// An address on loopback that nobody listens on.
pub(crate) fn free() -> String {
    free::free().to_string()
}

/// The key of a server or a hub, and those of its lines; the folder that they lie in.
pub(crate) struct Keys(pub(crate) PathBuf);

impl Keys {
    /// Makes them, in a folder of this test program's own: line 0 is the server's.
    pub(crate) fn new(name: &str, lines: u32) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(env!("CARGO_CRATE_NAME")).join(name);
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a folder for keys");
        let keys = Self(folder);
        let run = |arguments: &[&str]| assert!(cohold(arguments).status().expect("cohold runs").success());
        run(&["key", "generate", &keys.file(0)]);
        for line in 1..=lines {
            run(&["key", "generate", &keys.file(line), "--line", &line.to_string(), "--of", &keys.file(0)]);
        }
        keys
    }

    /// The file of a line's key.
    pub(crate) fn file(&self, line: u32) -> String {
        self.0.join(format!("{line}.key")).display().to_string()
    }
}

/// What a program that went well printed, which is one JSON document.
pub(crate) fn report(child: Child) -> Value {
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else")
}

/// Asks a process to end, as the system does.
pub(crate) fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args(["-s", name, &child.id().to_string()]).status();
    assert!(sent.expect("kill runs").success());
}
