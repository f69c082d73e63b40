//! `cohold study` as a user runs it.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::declared::has_columns_of;
use crate::program::{cohold, report};

/// Two laws at three gains over two networks, of four seeds: 48 runs.
const QUESTION: &[&str] = &[
    "study",
    "--json",
    "wave",
    "power",
    "--over",
    "coordination.damping_n_s_per_m=2,4,8",
    "--network",
    "own",
    "--network",
    "loss-20-%",
    "--seconds",
    "2",
    "--seeds",
    "4",
];

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("study").join(name);
    let _ = fs::remove_dir_all(&folder);
    folder
}

fn study(folder: &Path, more: &[&str]) -> Value {
    let out = ["--out", folder.to_str().expect("a name in UTF-8")];
    report(cohold(&[QUESTION, &out, more].concat()).spawn().expect("cohold runs"))
}

fn text(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap_or_default()
}

/// One command: rows, answers, pairs and a figure; again it runs nothing, and another bound asks the same runs.
#[test]
fn one_command_answers_and_goes_on() {
    let folder = folder("whole");
    let done = study(&folder, &[]);
    assert_eq!((&done["runs"], &done["new_runs"]), (&48.into(), &48.into()));
    assert_eq!(["best", "pairs", "points"].map(|name| done[name].as_array().map_or(0, Vec::len)), [4, 3, 12]);
    for name in ["study", "study-best", "study-pairs", "study-points"] {
        let first = text(&folder, &format!("{name}.csv")).lines().next().unwrap_or_default().to_owned();
        assert!(first.contains("entrant") && folder.join(format!("{name}.parquet")).exists(), "{name}: {first}");
    }
    has_columns_of("study-pairs", &folder.join("study-pairs.csv"));
    for ending in ["svg", "pdf", "png"] {
        assert!(folder.join("study-best").with_extension(ending).exists(), "{ending}");
    }
    assert!(text(&folder, "study-best.svg").contains(" width=\"88mm\" "), "a column wide");
    let bound = study(&folder, &["--at-most", "peak_coordination_force_n=0.001"]);
    assert_eq!(bound["new_runs"], 0);
    assert!(bound["best"].as_array().expect("answers").iter().all(|one| one["allowed_points"] == 0), "{bound}");
    assert!(bound["pairs"].as_array().expect("pairs").iter().all(|pair| pair["common_networks"] == 0));
}

/// A journal that was cut in the middle of a line, and shards in one folder: the same table to the last bit.
#[test]
fn stopped_and_in_shards_it_is_the_same() {
    let (whole, parts) = (folder("all"), folder("parts"));
    study(&whole, &[]);
    study(&parts, &["--shard", "1/3"]);
    assert!(!parts.join("study.csv").exists() && !parts.join("study-best.csv").exists());
    let rows = text(&parts, "rows-1-of-3.csv");
    fs::write(parts.join("rows-1-of-3.csv"), &rows[..rows.len() - 30]).expect("a torn file");
    study(&parts, &["--shard", "2/3"]);
    let done = study(&parts, &[]);
    assert_eq!(done["runs"], 48);
    for name in ["study.csv", "study-best.csv", "study-pairs.csv"] {
        assert_eq!(text(&whole, name), text(&parts, name), "{name}");
    }
}

/// The search in shards, each of which decides for the entrants on networks that are its own: the same tables to the last bit.
#[test]
fn a_search_in_shards_is_the_same() {
    let (whole, parts) = (folder("searched"), folder("searched-parts"));
    let search = ["--search", "halving"];
    let done = study(&whole, &search);
    for shard in ["2/3", "1/3", "3/3"] {
        study(&parts, &[&search[..], &["--shard", shard]].concat());
        assert!(!parts.join("study.csv").exists(), "{shard}");
    }
    let after = study(&parts, &search);
    assert_eq!((&after["new_runs"], &after["runs"]), (&0.into(), &done["runs"]));
    for name in ["study.csv", "study-best.csv", "study-pairs.csv", "study-points.csv"] {
        assert!(!text(&whole, name).is_empty());
        assert_eq!(text(&whole, name), text(&parts, name), "{name}");
    }
}

/// One scene on its own network: the rows of `study sweep`.
#[test]
fn of_one_scene_it_is_a_sweep() {
    let (one, other) = (folder("study"), folder("sweep"));
    let ask = |command: &[&str], folder: &Path| {
        let axis = ["--over", "network.loss=0,0.2", "--seeds", "3", "--seconds", "2", "--json", "--out"];
        report(cohold(&[command, &axis, &[folder.to_str().expect("UTF-8")]].concat()).spawn().expect("cohold runs"))
    };
    ask(&["study", "paper-5.2-wave-16ms"], &one);
    ask(&["study", "sweep", "--scene", "paper-5.2-wave-16ms"], &other);
    let journal = |folder: &Path| {
        let text = text(folder, "rows-1-of-1.csv");
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines.sort();
        lines
    };
    assert_eq!(journal(&one), journal(&other));
    assert_eq!(journal(&one).len(), 7);
}

/// One line that names what is wrong, and what there is.
#[test]
fn bad_ones_are_refused() {
    let refused = |arguments: &[&str], says: &[&str]| {
        let output = cohold(&[&["study"], arguments].concat()).output().expect("cohold runs");
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), error.trim_end().lines().count()), (Some(2), 1), "{arguments:?}: {error}");
        says.iter().for_each(|says| assert!(error.contains(says), "{arguments:?}: {says:?} is missing in: {error}"));
    };
    refused(&[], &["SCENE|LAW"]);
    refused(&["wafe"], &["wafe is neither a file nor a built-in scene", "the laws are power, p-plus-d, wave,"]);
    refused(&["wave", "--over", "object.mas_kg=1,2"], &["did you mean object.mass_kg?"]);
    refused(
        &["wave", "--network", "los 5 %"],
        &["no network called \"los 5 %\"", "did you mean \"loss 5 %\"?", "\"all\""],
    );
    refused(&["wave", "--network", "loss-5-%", "--over", "network.loss=0,0.1"], &["\"loss 5 %\" rules it"]);
    refused(&["wave", "--best", "force"], &["they are true_discrepancy_mm,"]);
    refused(&["wave", "--at-most", "energy_made_mj"], &["write it as NAME=MOST"]);
    refused(&["wave", "--trace", "nowhere.csv"], &["--trace: ", "nowhere.csv"]);
    refused(&["wave", "wave"], &["wave takes part twice"]);
}
