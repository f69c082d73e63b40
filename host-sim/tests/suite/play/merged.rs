//! What two pages of two processes recorded, brought together: as far apart as both copies were by the machine's own clock.

use std::f32::consts::TAU;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use cohold_live::recording::file::{Recording, read};
use serde_json::Value;

use super::Play;
use super::socket::Socket;
use crate::program::{Keys, cohold, free, report};

/// A copy of the object while its peer was armed: times by the machine's steady clock, s, and where it was, m.
fn course(recording: &Recording, number: u8) -> Vec<[f64; 2]> {
    let topic = format!("/peer_{number}/ticks");
    let rows = recording.channels.iter().find(|rows| rows.topic == topic).expect("ticks of the peer");
    let column = |name: &str| rows.column(name).expect("a column");
    let [times, modes, places] = ["time_s", "mode", "object_m"].map(column);
    let start_s = 1e-9 * recording.origin.start_clock_ns as f64;
    (0..rows.len()).filter(|at| modes[*at] == 1.0).map(|at| [start_s + times[at], places[at]]).collect()
}

/// Mean distance over the second half of these instants, mm; between two ticks a copy is on the straight line between them.
fn apart_mm(instants_s: &[f64], [one, two]: [&[[f64; 2]]; 2]) -> f64 {
    let was_at = |course: &[[f64; 2]], time_s: f64| {
        let after = course.partition_point(|place| place[0] < time_s).clamp(1, course.len() - 1);
        let ([t0, x0], [t1, x1]) = (course[after - 1], course[after]);
        x0 + (x1 - x0) * (time_s - t0) / (t1 - t0)
    };
    let half = &instants_s[instants_s.len() / 2..];
    half.iter().map(|at| 1e3 * (was_at(one, *at) - was_at(two, *at)).abs()).sum::<f64>() / half.len() as f64
}

fn merge(files: &[&Path]) -> Value {
    report(cohold(&["recording", "merge", "--json"]).args(files).spawn().expect("cohold runs"))
}

/// What `recording merge` says to what it refuses.
#[track_caller]
fn refused(files: &[&Path], says: &str) {
    let output = cohold(&["recording", "merge"]).args(files).output().expect("cohold runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && error.contains(says), "{error}");
}

/// What `recording merge` makes of the two is what the machine's clock says, at the instants that it compared (a busy machine leaves gaps, into which
/// it lays nothing); the error of the clock that it found is within what it states.
fn compare(one: &Path, two: &Path) {
    let table = one.with_extension("csv");
    let merged = merge(&[one, two, &table]);
    let number = |key: &str| merged[key].as_f64().unwrap_or_else(|| panic!("{key} in {merged}"));
    let read = [one, two].map(|file| read(file).expect("a recording"));
    let start_s = 1e-9 * read[0].origin.start_clock_ns as f64;
    let rows = std::fs::read_to_string(&table).expect("a table");
    let time = |row: &str| row.split(',').next()?.parse().ok();
    let instants_s: Vec<f64> = rows.lines().filter_map(time).map(|at: f64| start_s + at).collect();
    assert_eq!(instants_s.len() as f64, number("instants"));
    let wanted = apart_mm(&instants_s, [&course(&read[0], 1), &course(&read[1], 2)]);
    assert!(wanted > 0.05, "the copies were apart: {wanted} mm");
    let apart = number("true_discrepancy_mm");
    assert!((apart - wanted).abs() < 0.01 * wanted + number("rms_clock_error_mm"), "{wanted} mm: {merged}");
    assert!(number("same_machine_less_this_us").abs() <= number("clock_error_us"), "{merged}");
    assert_eq!(merged["ends"], serde_json::json!(["peer 1", "peer 2"]));
    assert!(number("instants") > 2000.0, "{merged}");
}

fn files<const N: usize>(keys: &Keys, names: [&str; N]) -> [PathBuf; N] {
    names.map(|name| keys.0.join(name))
}

#[test]
fn recordings_of_two_pages_are_merged() {
    let (keys, at) = (Keys::new("play-merged", 0), free());
    let recordings = files(&keys, ["one.mcap", "two.mcap"]);
    let page = |end: [&str; 2], file: &Path| {
        let file = file.display().to_string();
        Play::start(&["--json", end[0], end[1], "--key-file", &keys.file(0), "--seconds", "9", "--record", &file])
    };
    let pages = [page(["--listen", &at], &recordings[0]), page(["--join", &at], &recordings[1])];
    // Both hands move, not alike, for as long as both are there.
    let mut hands = [0, 1].map(|hand| Socket::open(&pages[hand].addresses[1]).expect("it is let in"));
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(6) {
        let turns = start.elapsed().as_secs_f32() * 0.7;
        hands[0].points(0.03 * (TAU * turns).sin());
        hands[1].points(0.03 * (TAU * turns + 0.8).sin());
        std::thread::sleep(Duration::from_millis(16));
    }
    drop(hands);
    pages.into_iter().for_each(|page| drop(page.report()));
    let [one, two] = [&recordings[0], &recordings[1]].map(PathBuf::as_path);
    compare(one, two);

    // Each is one end, and says so; what one process recorded of both ends is merged alone, and with nothing else.
    refused(&[one], "the recording of peer 1 holds one end only");
    refused(&[one, one], "both are recordings of peer 1");
    let [both] = files(&keys, ["both.mcap"]);
    let file = both.display().to_string();
    Play::start(&["--json", "--seconds", "1", "--record", &file]).report();
    let whole =
        "the recording of both peers holds both ends already, on one clock: `cohold recording merge` takes it alone";
    refused(&[&both, two], whole);
    refused(&[one, &both], whole);
    assert_eq!(merge(&[&both])["instants"], 1000);
}

#[test]
fn recordings_of_a_page_and_of_a_peer_are_merged() {
    let (keys, [at, own]) = (Keys::new("play-merged-peer", 0), [free(), free()]);
    let [one, two] = files(&keys, ["page.mcap", "peer.mcap"]);
    let (page, peer) = (one.display().to_string(), two.display().to_string());
    let page =
        Play::start(&["--json", "--listen", &at, "--key-file", &keys.file(0), "--seconds", "9", "--record", &page]);
    let peer =
        cohold(&["peer", "--quiet", "--json", "--number", "2", "--listen", &own, "--connect", &at, "--seconds", "4"])
            .args(["--key-file", &keys.file(0), "--record", &peer, "--scene", "any-network"])
            .spawn()
            .expect("cohold runs");
    let mut hand = Socket::open(&page.addresses[1]).expect("it is let in");
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(7) {
        hand.points(0.04 * (TAU * 0.7 * start.elapsed().as_secs_f32()).sin());
        std::thread::sleep(Duration::from_millis(16));
    }
    drop(hand);
    report(peer);
    page.report();
    compare(&one, &two);
}
