//! `cohold study sweep` as a user runs it: the rows of single runs, the same rows in every way they can come, nothing lost by a kill.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use cohold_sim::rng::Rng;
use serde_json::Value;

use crate::program::{cohold, report};

/// 24 points, among them faulted ones and ones in which the seeds differ.
const QUESTION: &[&str] = &[
    "study",
    "sweep",
    "--json",
    "--scene",
    "paper-5.2-wave-16ms",
    "--over",
    "coordination.stiffness_n_per_m=200..20000:8:log",
    "--over",
    "network.loss=0,0.2,0.5",
    "--seconds",
    "4",
];
/// With three seeds.
const RUNS: usize = 72;

/// An empty folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sweep").join(name);
    let _ = fs::remove_dir_all(&folder);
    folder
}

fn arguments<'a>(folder: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
    let seeds: &[&str] = if more.contains(&"--seeds") { &[] } else { &["--seeds", "3"] };
    with_out(&[QUESTION, seeds, more].concat(), folder)
}

fn with_out<'a>(question: &[&'a str], folder: &'a Path) -> Vec<&'a str> {
    [question, &["--out", folder.to_str().expect("a name in UTF-8")]].concat()
}

fn sweep(folder: &Path, more: &[&str]) -> Value {
    report(cohold(&arguments(folder, more)).spawn().expect("cohold runs"))
}

fn text(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap_or_default()
}

/// The runs of a folder's journals, sorted; without a line that was torn.
fn journals(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("a file").file_name());
    let names = names.map(|name| name.to_string_lossy().into_owned()).filter(|name| name.starts_with("rows-"));
    let lines = |name: String| {
        let text = text(folder, &name);
        text.split_inclusive('\n').skip(1).filter(|line| line.ends_with('\n')).map(str::to_owned).collect::<Vec<_>>()
    };
    let mut lines: Vec<String> = names.flat_map(lines).collect();
    lines.sort();
    lines
}

/// What nobody disturbed.
fn undisturbed(name: &str) -> (PathBuf, String) {
    let folder = folder(name);
    let done = sweep(&folder, &[]);
    assert_eq!((&done["runs"], &done["new_runs"]), (&RUNS.into(), &RUNS.into()));
    let csv = text(&folder, "sweep.csv");
    assert_eq!(csv.lines().count(), RUNS + 1);
    (folder, csv)
}

/// A run tells of both hands on; beside it stands what the analyser says of every mode, in a sweep, in `cooperate` and in `stability` alike.
#[test]
fn what_grows_when_let_go_is_said_beside_every_run() {
    let laws = ["power", "wave", "passive-wave"];
    let of = |section: &'static str, ms: u32| laws.map(|law| format!("paper-{section}-{law}-{ms}ms"));
    let scenes = [of("5.1", 16), of("5.1", 32), of("5.2", 16)].concat();
    let mut let_go = 0;
    for scene in &scenes {
        let said = |arguments: &[&str]| {
            let output = cohold(arguments).args(["--json", "--scene", scene]).output().expect("cohold runs");
            serde_json::from_slice::<Value>(&output.stdout).expect("one JSON document")
        };
        let judged = said(&["stability", "point"]);
        let modes = judged["modes"].as_array().expect("modes");
        let unstable = modes.iter().filter(|mode| mode["stable"] == false).filter_map(|mode| mode["mode"].as_str());
        let unstable = Some(unstable.collect::<Vec<_>>().join("; ")).filter(|modes| !modes.is_empty());
        let swept = said(&["study", "sweep", "--over", "network.loss=0", "--seconds", "1"])["points"][0].take();
        for row in [&swept, &said(&["cooperate", "--seconds", "1"])] {
            assert_eq!(row["every_mode_stable"], judged["stable"], "{scene}");
            assert_eq!(row["unstable_modes"].as_str(), unstable.as_deref(), "{scene}");
        }
        let_go += usize::from(swept["unstable_runs"] == 0 && swept["every_mode_stable"] == false);
    }
    // Runs of five hold, of scenes that grow where a hand lets go.
    assert_eq!(let_go, 5, "of {scenes:?}");
}

/// The commands of docs/guides/sweeps.md, with fewer runs: somebody pushes in each, so that there is something to measure, and their points differ.
#[test]
fn what_the_documentation_sweeps_moves() {
    let page = include_str!("../../../docs/guides/sweeps.md");
    let commands = page.lines().filter_map(|line| line.strip_prefix("    cohold "));
    let commands: Vec<&str> = commands.filter(|line| line.starts_with("study sweep ")).collect();
    assert_eq!(commands.len(), 2, "{commands:?}");
    let folder = folder("documented");
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join("my-scene.toml"), "[user.1]\npush_n = 0.5\n[user.2]\npush_n = 0.5\n").expect("a scene");
    for command in commands {
        let mut words: Vec<&str> = command.split_whitespace().collect();
        for (option, few) in [("--points", "4"), ("--seeds", "2")] {
            if let Some(at) = words.iter().position(|word| *word == option) {
                words[at + 1] = few;
            }
        }
        let output = cohold(&words).args(["--json", "--seconds", "4"]).current_dir(&folder).output().expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && !said.contains("nobody pushes"), "{command}: {said}");
        let told: Value = serde_json::from_slice(&output.stdout).expect("one JSON document");
        let figures = |rows: &Value, name: &str| -> Vec<f64> {
            rows.as_array().into_iter().flatten().filter_map(|row| row[name].as_f64()).collect()
        };
        let mut seen = figures(&told["points"], "true_discrepancy_mm");
        seen.sort_by(f64::total_cmp);
        assert!(seen.len() > 1 && seen[0] > 0.01 && seen[0] < seen[seen.len() - 1], "{command}: {seen:?}");
    }
}

/// A row is what `cooperate` says of the same settings and seed; one that failed says why, and has no figures.
#[test]
fn a_row_is_a_run_of_cooperate() {
    let (_, csv) = undisturbed("rows");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let names = reader.headers().expect("a heading").clone();
    let rows: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().expect("rows");
    let cell = |row: &csv::StringRecord, name: &str| {
        row[names.iter().position(|known| known == name).unwrap_or_else(|| panic!("no column {name}"))].to_owned()
    };
    let (mut stable, mut failed) = (0, 0);
    for row in rows.iter().step_by(5) {
        let set = |key: &str| format!("{key}={}", cell(row, key));
        let sets = ["coordination.stiffness_n_per_m", "network.loss", "network.seed"];
        let sets =
            sets.map(|key| if key == "network.seed" { format!("{key}={}", cell(row, "seed")) } else { set(key) });
        let mut arguments = vec!["cooperate", "--json", "--seconds", "4", "--scene", "paper-5.2-wave-16ms"];
        sets.iter().for_each(|set| arguments.extend(["--set", set]));
        // Status 1 where it is not stable.
        let alone = cohold(&arguments).output().expect("cohold runs");
        let alone: Value = serde_json::from_slice(&alone.stdout).expect("one JSON document and nothing else");
        for name in ["state_hash", "verdict", "reason"] {
            assert_eq!(alone[name].as_str().unwrap_or_default(), cell(row, name), "{name} of {sets:?}");
        }
        let figures = [
            ("true_discrepancy_mm", &alone["true_discrepancy_mm"]),
            ("coordination_force_mean_n", &alone["coordination_force_n"]["mean"]),
            ("peak_coordination_force_n", &alone["peak_coordination_force_n"]),
            ("energy_made_mj", &alone["energy_made_mj"]),
        ];
        for (name, figure) in figures {
            // serde_json reads to the last bit but one.
            match (figure.as_f64(), cell(row, name).parse::<f64>().ok()) {
                (Some(alone), Some(swept)) => {
                    assert!((alone - swept).abs() <= 1e-15 * alone.abs(), "{name} of {sets:?}")
                }
                (alone, swept) => assert_eq!(alone, swept, "{name} of {sets:?}"),
            }
        }
        *(if alone["stable"] == true { &mut stable } else { &mut failed }) += 1;
    }
    assert!(stable > 2 && failed > 2, "{stable} stable, {failed} failed: neither is tried");
}

/// Mean and interval by hand from the rows; none where the seeds are the same run, and none where any run failed.
#[test]
fn a_point_is_the_mean_of_its_runs_and_never_of_some_of_them() {
    let folder = folder("points");
    let done = sweep(&folder, &[]);
    let mut reader = csv::Reader::from_path(folder.join("sweep.csv")).expect("a table");
    let rows: Vec<std::collections::HashMap<String, String>> =
        reader.deserialize().map(|row| row.expect("a row")).collect();
    let points = done["points"].as_array().expect("points");
    assert_eq!(points.len(), 24);
    let (mut random, mut sure, mut none) = (0, 0, 0);
    for (point, runs) in points.iter().zip(rows.chunks(3)) {
        let got = &point["coordination_force_mean_n"];
        let values: Vec<f64> = runs.iter().filter_map(|run| run["coordination_force_mean_n"].parse().ok()).collect();
        assert_eq!(point["reason"].is_string(), runs.iter().any(|run| run["stable"] != "1"), "{point}");
        if values.len() < runs.len() {
            assert!(got.is_null() && point["reason"].is_string(), "{point}");
            none += 1;
            continue;
        }
        let mean = values.iter().sum::<f64>() / 3.0;
        assert!((got.as_f64().expect("a mean") - mean).abs() < 1e-12);
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 2.0;
        let within = &point["coordination_force_mean_95_n"];
        if point["network"]["loss"] == 0.0 {
            assert!(within.is_null(), "{point}");
            sure += 1;
        } else {
            let want = 4.302_652_73 * (variance / 3.0).sqrt();
            assert!((within.as_f64().expect("an interval") / want - 1.0).abs() < 1e-8, "{within} is not {want}");
            random += 1;
        }
    }
    let all = [random, sure, none];
    assert!(all.iter().all(|count| *count > 0), "{all:?}: random, sure, failed");
}

/// Shards, threads and order change no byte; who asks for all of it after the shards runs nothing again.
#[test]
fn any_number_of_shards_and_threads_gives_the_same_rows() {
    let (whole, csv) = undisturbed("whole");
    let shards = folder("shards");
    for shard in ["2/3", "1/3", "3/3"] {
        let part = sweep(&shards, &["--shard", shard]);
        assert_eq!((&part["new_runs"], &part["files"]), (&24.into(), &Value::Array(vec![])));
    }
    assert_eq!(sweep(&shards, &[])["new_runs"], 0);
    assert_eq!(text(&shards, "sweep.csv"), csv);
    assert_eq!(journals(&shards), journals(&whole));

    let one = folder("one-thread");
    report(cohold(&arguments(&one, &[])).env("RAYON_NUM_THREADS", "1").spawn().expect("cohold runs"));
    assert_eq!(text(&one, "sweep.csv"), csv);
}

/// Killed again and again, each time when as much more has been written as is drawn: the next one goes on, and in the end the rows are
/// those of one that nobody disturbed.
fn killed(name: &str, question: &[&str], runs: usize, kills: u64) {
    let (whole, killed) = (folder(&format!("{name}-undisturbed")), folder(&format!("{name}-killed")));
    let start = |folder: &Path| cohold(&with_out(question, folder)).spawn().expect("cohold runs");
    let sweep = |folder: &Path| report(start(folder));
    assert_eq!(sweep(&whole)["new_runs"], runs);
    let bytes = |folder: &Path| fs::metadata(folder.join("rows-1-of-1.csv")).map_or(0, |file| file.len());
    let all = bytes(&whole);
    let mut random = Rng::new(20_261_121);
    let mut there = vec![0];
    for _ in 0..kills {
        let until = bytes(&killed) + random.below(all / kills);
        let mut child = start(&killed);
        while bytes(&killed) < until && child.try_wait().expect("a child").is_none() {
            std::thread::sleep(Duration::from_micros(random.below(2000)));
        }
        child.kill().expect("it can be killed");
        child.wait().expect("it ends");
        there.push(if killed.exists() { journals(&killed).len() } else { 0 });
    }
    assert!(there.is_sorted(), "rows got lost: {there:?}");
    let struck = there.windows(2).filter(|pair| pair[0] < pair[1] && pair[1] < runs).count();
    assert!(struck >= 2, "only {struck} kills came in the middle: {there:?}");
    let new = sweep(&killed)["new_runs"].as_u64().expect("a count") as usize;
    assert_eq!(new, runs - there[there.len() - 1], "after {there:?}");
    assert!(journals(&killed) == journals(&whole), "other rows after {there:?}");
    assert!(text(&killed, "sweep.csv") == text(&whole, "sweep.csv"), "another table after {there:?}");
    println!("{runs} runs, killed when there were {there:?}: the same rows");
}

#[test]
fn kills_lose_nothing_and_repeat_nothing() {
    killed("grid", &[QUESTION, &["--seeds", "25"]].concat(), 24 * 25, 8);
}

/// Short runs at points of Sobol's sequence.
const SAMPLED: &[&str] = &[
    "study",
    "sweep",
    "--json",
    "--scene",
    "paper-5.2-wave-16ms",
    "--sample",
    "coordination.stiffness_n_per_m=10..20000:log",
    "--sample",
    "network.loss=0..0.5",
    "--sample",
    "object.mass_kg=0.1..1:log",
    "--seconds",
    "0.02",
];

#[test]
fn five_kills_of_a_sample() {
    killed("sample", &[SAMPLED, &["--points", "3000"]].concat(), 3000, 5);
}

#[test]
#[ignore = "takes minutes: cargo test --release -p cohold --test suite -- --ignored --nocapture five_kills"]
fn five_kills_of_a_hundred_thousand_points() {
    killed("sample-100000", &[SAMPLED, &["--points", "100000"]].concat(), 100_000, 5);
}

/// Shards of a sample over a grid are its rows, and a row lies where the sample says, whoever runs it and whatever else is run.
#[test]
fn a_sample_is_the_same_in_shards_and_beside_more_points() {
    let question =
        [SAMPLED, &["--over", "coordination.comm=power,wave", "--design", "latin-hypercube", "--points", "20"]];
    let question = question.concat();
    let with = |folder: &Path, more: &[&str]| {
        report(cohold(&with_out(&[&question, more].concat(), folder)).spawn().expect("cohold runs"))
    };
    let (whole, shards) = (folder("sample-whole"), folder("sample-shards"));
    assert_eq!(with(&whole, &[])["new_runs"], 40);
    for shard in ["3/3", "1/3", "2/3"] {
        with(&shards, &["--shard", shard]);
    }
    assert_eq!(with(&shards, &[])["new_runs"], 0);
    assert_eq!(text(&shards, "sweep.csv"), text(&whole, "sweep.csv"));

    let mut reader = csv::Reader::from_path(whole.join("sweep.csv")).expect("a table");
    let rows: Vec<std::collections::HashMap<String, String>> =
        reader.deserialize().map(|row| row.expect("a row")).collect();
    for (power, wave) in rows[..20].iter().zip(&rows[20..]) {
        assert_eq!((power["coordination.comm"].as_str(), wave["coordination.comm"].as_str()), ("power", "wave"));
        for key in ["coordination.stiffness_n_per_m", "network.loss", "object.mass_kg"] {
            assert_eq!(power[key], wave[key]);
        }
    }
    // One of 20 equal parts of a range each.
    let mut parts: Vec<usize> =
        rows[..20].iter().map(|row| (row["network.loss"].parse::<f64>().expect("a number") * 40.0) as usize).collect();
    parts.sort_unstable();
    assert_eq!(parts, (0..20).collect::<Vec<_>>());
}

/// Whatever of a line a kill left: it is cut off, and its run is done again.
#[test]
fn a_torn_line_is_done_again() {
    let (folder, csv) = undisturbed("torn");
    let path = folder.join("rows-1-of-1.csv");
    let (rows, lines) = (fs::read(&path).expect("rows"), journals(&folder));
    let line = rows.len() - rows[..rows.len() - 1].iter().rposition(|byte| *byte == b'\n').expect("a line") - 1;
    for (cut, again) in
        [(1, 1), (line / 2, 1), (line - 1, 1), (line, 1), (line + 1, 2), (rows.len() - 5, RUNS), (rows.len(), RUNS)]
    {
        fs::write(&path, &rows[..rows.len() - cut]).expect("written");
        assert_eq!(sweep(&folder, &[])["new_runs"], again, "{cut} bytes short");
        assert_eq!(journals(&folder), lines, "{cut} bytes short");
        assert_eq!(text(&folder, "sweep.csv"), csv);
    }
}

/// What is wrong is said in one line, and leaves what is there as it is.
#[test]
fn another_question_and_bad_ones_are_refused() {
    let (folder, _) = undisturbed("refused");
    let before = journals(&folder);
    let refused = |arguments: &[&str], names: &[&str]| {
        let output = cohold(arguments).output().expect("cohold runs");
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), error.trim_end().lines().count()), (Some(2), 1), "{arguments:?}: {error}");
        names.iter().for_each(|name| assert!(error.contains(name), "{arguments:?}: {name:?} is missing in: {error}"));
    };
    refused(
        &arguments(&folder, &["--set", "object.mass_kg=0.5"]),
        &["sweep.toml is of another sweep", "`object.mass_kg = 0.5`"],
    );
    refused(&arguments(&folder, &["--over", "network.jitter_s=0,0.001"]), &["of another sweep", "over_3"]);
    assert_eq!(journals(&folder), before);

    let over = |over: &str, names: &[&str]| refused(&["study", "sweep", "--json", "--over", over], names);
    over("object.mas_kg=1,2", &["there is no key object.mas_kg", "did you mean object.mass_kg?"]);
    over("object.mass_kg=-1..1:3", &["object.mass_kg = -1 is not allowed"]);
    over("network.one_way_delay_packets=1..2:3", &["network.one_way_delay_packets = 1.5 is not allowed", "whole"]);
    over("network.jitter=none,gama", &["network.jitter = \"gama\"", "did you mean gamma?"]);
    over("network.seed=1,2", &["network.seed is no key to sweep over"]);
    over("network.loss=0..0.1:1", &["2 to 1000000 values"]);
    over("network.loss=0..0.1:3:log", &["ends above 0"]);
    over("network.loss=0..0.1", &["TABLE.KEY=A..B:N"]);
    over("network.loss=0.1,0.1", &["0.1 stands there twice"]);
    let sample = |more: &[&str], names: &[&str]| refused(&[&["study", "sweep", "--json"], more].concat(), names);
    sample(&["--sample", "network.loss=0..1.5", "--points", "64"], &["network.loss = 1.", "is not allowed"]);
    sample(&["--sample", "network.loss=0..0.1"], &["--points"]);
    sample(&["--sample", "network.loss=0.1..0", "--points", "9"], &["from a number to a larger one"]);
    sample(&["--sample", "network.loss=0..0.1", "--points", "0"], &["1 to 1000000 points"]);
    sample(&["--sample", "network.seed=1..9:whole", "--points", "9"], &["network.seed is no key to sweep over"]);
    sample(
        &["--sample", "network.loss=0..0.1", "--over", "network.loss=0,0.1", "--points", "9"],
        &["network.loss is varied twice"],
    );
    refused(
        &["study", "sweep", "--over", "network.loss=0,0.1", "--shard", "3/2", "--out", "x"],
        &["I/N, I from 1 to N"],
    );
}
