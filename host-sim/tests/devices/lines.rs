//! The lines of docs/guides/devices/index.md as they stand there, with addresses that are free.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::emulated::haply;
use super::{Running, number};
use crate::program::{cohold, free};

const PAGE: &str = include_str!("../../../docs/guides/devices/index.md");

/// What stands below this heading, up to the next one.
fn section(heading: &str) -> &'static str {
    let (_, rest) = PAGE.split_once(&format!("\n## {heading}\n")).expect("the page has it");
    rest.split("\n## ").next().unwrap_or_default()
}

/// The lines of shell there, and how many lines of the page they are; one that goes on is one.
fn shell(section: &str) -> (Vec<String>, usize) {
    let lines: Vec<&str> = section.lines().filter_map(|line| line.strip_prefix("    ")).collect();
    (lines.join("\n").replace("\\\n", " ").lines().map(str::to_owned).collect(), lines.len())
}

/// The distance that a section promises, mm.
fn promised_mm(section: &str) -> f64 {
    let (_, rest) = section.split_once("less than ").expect("it says how far");
    rest.split_once(" mm apart").expect("it says how far").0.parse().expect("a number")
}

/// An empty folder of the test's own, in which the lines are run.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// The program of a line, its words changed so; what it reports is one JSON document.
fn program(line: &str, folder: &Path, mut change: impl FnMut(&str) -> String) -> Command {
    let words = line.trim_end_matches('&').split_whitespace().skip(1).map(&mut change);
    let mut command = cohold(&["--json"]);
    command.args(words).current_dir(folder);
    command
}

/// Both ends held one object all the time, less than so far apart.
fn held(peers: [Running; 2], most_mm: f64) {
    for (ended, live, said) in peers.map(Running::end) {
        assert!(ended && live["fault"] == Value::Null, "{said}\n{live}");
        let (apart_mm, felt_n) = (number(&live, "true_discrepancy_mm"), number(&live, "coordination_force_n"));
        println!("{apart_mm:.3} mm apart, {felt_n:.3} N, {} missed", live["punctuality"]["missed"]);
        assert!(apart_mm < most_mm && felt_n.abs() > 1.0, "{apart_mm} mm of {most_mm}, {felt_n} N: {live}");
    }
}

#[test]
fn ten_lines_hold_one_object_with_two_emulated_devices() {
    let (section, folder) = (section("Without a device, in ten lines"), folder("ten-lines"));
    let (lines, count) = shell(section);
    assert!(count <= 10, "{count} lines");
    let mut addresses = HashMap::new();
    let mut moved = |word: &str| match word.split_once("127.0.0.1:") {
        Some((before, port)) => format!("{before}{}", addresses.entry(port.to_owned()).or_insert_with(free)),
        None => word.to_owned(),
    };
    let (mut aside, mut peers) = (Vec::new(), Vec::new());
    // The first builds. The devices start last: a shell does not wait for one either.
    let (late, early): (Vec<_>, Vec<_>) = lines[1..].iter().partition(|line| line.contains(" devices "));
    for line in early.into_iter().chain(late) {
        let kind = line.split_whitespace().nth(1);
        let mut command = program(line, &folder, &mut moved);
        if kind == Some("devices") {
            // It ends where the test does not come to end it, too.
            command.args(["--seconds", "120"]);
        }
        let running = Running::start(command);
        match kind {
            Some("key") => assert!(running.end().0),
            Some("peer") => peers.push(running),
            _ => aside.push(running),
        }
    }
    let peers: [Running; 2] = peers.try_into().unwrap_or_else(|_| panic!("two peers"));
    held(peers, promised_mm(section));
    let devices = aside.into_iter().map(Running::asked_to_end);
    let pushed = devices.filter(|report| report["orders"].as_u64().is_some_and(|orders| orders > 10_000)).count();
    assert_eq!(pushed, 2, "both devices were driven");
}

#[test]
fn two_inverse3s_hold_one_object_by_the_page_s_lines() {
    let (section, folder) = (section("With two Inverse3s"), folder("two-inverse3s"));
    let (lines, count) = shell(section);
    assert!(count <= 10, "{count} lines");
    let (devices, places) = ([haply(0.0), haply(0.0)], [free(), free()]);
    let mut peers = Vec::new();
    for line in lines.iter().filter(|line| line.starts_with("cohold ")) {
        if line.contains(" key ") {
            assert!(program(line, &folder, str::to_owned).status().expect("cohold runs").success());
            continue;
        }
        let own = peers.len();
        let mut before = String::new();
        let mut command = program(line, &folder, |word| {
            let word = match before.as_str() {
                "--listen" => places[own].clone(),
                "--connect" => places[1 - own].clone(),
                "--device" => format!("{word}:{}", devices[own].at),
                _ => word.to_owned(),
            };
            before.clone_from(&word);
            word
        });
        // Both services run on this machine, beside other tests.
        peers.push(Running::start({
            command.args(["--device-silent-s", "0.2"]);
            command
        }));
    }
    let mut peers: [Running; 2] = peers.try_into().unwrap_or_else(|_| panic!("two peers"));
    peers.iter_mut().for_each(|peer| peer.until(" s  armed, "));
    devices[0].world().reach([0.02, 0.0, 0.0]);
    held(peers, promised_mm(section));
}
