//! Key files as programs meet them: endless ones, those that others can read, and a disk without room.
#![cfg(unix)]

use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("key-files").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for keys");
    folder
}

/// The program, started by a shell that has set a limit first.
fn limited(limit: &str, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_cohold");
    let line = format!("trap '' XFSZ; ulimit {limit}; exec {program} {}", arguments.join(" "));
    Command::new("sh").args(["-c", &line]).output().expect("a shell")
}

/// What it says in one line, having done nothing.
fn refusal(output: &Output) -> String {
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(output.stdout.is_empty() && error.trim_end().lines().count() == 1, "{error}");
    error
}

const PEER: [&str; 7] = [
    "peer",
    "--number=1",
    "--listen=127.0.0.1:0",
    "--connect=127.0.0.1:9",
    "--patience-s=0.1",
    "--seconds=1",
    "--key-file",
];

/// Without an end, a file must not be read to its end: with 256 MB of addresses the program would run out of them.
#[test]
fn an_endless_file_is_refused_after_a_few_bytes() {
    let error = refusal(&limited("-v 262144", &[&PEER[..], &["/dev/zero"]].concat()));
    assert!(error.contains("/dev/zero: it is a pipe or a device: it must be a regular file"), "{error}");
    let long = folder("endless").join("long.key");
    std::fs::write(&long, "0".repeat(1 << 20)).expect("a long file");
    let error = refusal(&limited("-v 262144", &[&PEER[..], &[&long.display().to_string()]].concat()));
    assert!(error.contains("a key file has at most 128 bytes, and it has more"), "{error}");
}

#[test]
fn what_others_can_read_is_refused_with_the_command_that_mends_it() {
    let key = folder("open").join("lab.key").display().to_string();
    assert!(limited("-f 100", &["key", "generate", &key]).status.success());
    let mode = std::fs::metadata(&key).expect("a key file").mode() & 0o7777;
    assert_eq!(mode, 0o600);
    for mode in [0o640, 0o604, 0o620, 0o601] {
        std::fs::set_permissions(&key, PermissionsExt::from_mode(mode)).expect("own file");
        let error = refusal(&limited("-f 100", &[&PEER[..], &[&key]].concat()));
        let names = [format!("the key file {key} (mode {mode:03o})"), format!("chmod 600 {key}")];
        assert!(names.iter().all(|name| error.contains(name)), "{error}");
    }
    // What is said mends it: then nobody is there.
    std::fs::set_permissions(&key, PermissionsExt::from_mode(0o600)).expect("own file");
    let error = refusal(&limited("-f 100", &[&PEER[..], &[&key]].concat()));
    assert!(!error.contains("key file"), "{error}");
}

/// A file of at most 0 blocks is a disk without room: nothing stays, and once there is room the same command works.
#[test]
fn a_full_disk_leaves_nothing_that_blocks_the_next_attempt() {
    let folder = folder("full");
    let (key, image) = (folder.join("lab.key").display().to_string(), folder.join("lab.bin").display().to_string());
    let there = || std::fs::read_dir(&folder).expect("a folder").count();
    let error = refusal(&limited("-f 0", &["key", "generate", &key]));
    assert!(error.contains("cannot make the key file") && error.contains(&key), "{error}");
    assert_eq!(there(), 0);
    assert!(limited("-f 100", &["key", "generate", &key]).status.success());
    let before = std::fs::read(&key).expect("a key file");
    let operator = folder.join("operator.key").display().to_string();
    assert!(limited("-f 100", &["key", "generate", &operator, "--operator"]).status.success());
    let both = ["key", "image", "--key-file", &key, "--operator-key-file", &operator, &image];
    refusal(&limited("-f 0", &both));
    assert_eq!(there(), 2);
    // And what is there stays as it is.
    let error = refusal(&limited("-f 100", &["key", "generate", &key]));
    assert!(error.contains("exists"), "{error}");
    assert_eq!((std::fs::read(&key).expect("a key file"), there()), (before, 2));
}
