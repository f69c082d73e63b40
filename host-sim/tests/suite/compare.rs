//! `host-sim compare` as a user runs it.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::program::{host_sim, report};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("compare").join(name);
    let _ = fs::remove_dir_all(&folder);
    folder
}

fn compare(arguments: &[&str], folder: &Path) -> Value {
    let common = ["compare", "--json", "--seconds", "4", "--out", folder.to_str().expect("a name in UTF-8")];
    report(host_sim(&[&common, arguments].concat()).spawn().expect("host-sim runs"))
}

/// A column of a table of runs, scene by scene.
fn of_scene(folder: &Path, number: &str, column: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(folder.join("compare-runs.csv")).expect("a table");
    let rows = reader.deserialize().map(|row| row.expect("a row"));
    let of = rows.filter(|row: &HashMap<String, String>| row["number"] == number);
    of.map(|row| row[column].parse().unwrap_or(f64::NAN)).collect()
}

/// A scene against itself is no difference at all, to the last bit, and no interval around it; against another one the mean and the
/// interval are those of the runs, by hand.
#[test]
fn against_itself_and_against_another() {
    let folder = folder("pairs");
    let wave = "paper-5.2-wave-16ms,network.loss=0.2";
    let done = compare(&[wave, wave, "paper-5.2-wave-16ms,network.loss=0.1", "--seeds", "5"], &folder);
    let differences = done["differences"].as_array().expect("differences");
    assert_eq!((done["runs"].as_u64(), differences.len()), (Some(15), 28));
    let (mut told, mut zero) = (0, 0);
    for one in differences {
        let name = one["merit"].as_str().expect("a name");
        let [first, this] = ["1", if one["number"] == 2 { "2" } else { "3" }].map(|at| of_scene(&folder, at, name));
        let pairs: Vec<f64> = this.iter().zip(&first).map(|(this, first)| this - first).collect();
        let mean = pairs.iter().sum::<f64>() / 5.0;
        let square = pairs.iter().map(|pair| (pair - mean).powi(2)).sum::<f64>() / 4.0;
        let within = 2.776_445_105 * (square / 5.0).sqrt();
        let [got, got_within] = ["difference", "difference_95"].map(|field| one[field].as_f64().expect("a number"));
        if one["number"] == 2 {
            assert_eq!((got, got_within, &one["differs"]), (0.0, 0.0, &false.into()), "{one}");
            zero += 1;
        } else {
            assert!((got - mean).abs() <= 1e-12 * mean.abs(), "{one}: {mean}");
            assert!((got_within - within).abs() <= 1e-8 * within, "{one}: {within}");
            assert_eq!(one["differs"].as_bool(), Some(mean.abs() > within));
            told += usize::from(mean.abs() > within);
        }
    }
    assert!(zero == 14 && told > 0, "{zero} of itself, {told} told apart");
    for ending in ["csv", "parquet", "svg", "pdf", "png", "toml"] {
        assert!(folder.join("compare").with_extension(ending).exists(), "{ending}");
    }
}

/// Laws by their names, at their own gains; one whose run fails is there with its reason, and has no mean and no difference.
#[test]
fn laws_and_what_fails() {
    let folder = folder("laws");
    let done = compare(&["wave", "power,coordination.stiffness_n_per_m=20000", "self-timed", "--seeds", "2"], &folder);
    let mut failed = 0;
    for one in done["differences"].as_array().expect("differences") {
        if one["number"] == 2 {
            assert!(one["difference"].is_null() && one["this"].is_null(), "{one}");
            assert!(one["reason"].as_str().is_some_and(|reason| reason.contains("stopped at")), "{one}");
            failed += 1;
        } else {
            // Nothing is random: no interval.
            assert!(one["difference"].is_number() && one["difference_95"].is_null(), "{one}");
        }
    }
    assert_eq!((failed, done["not_stable_runs"].as_u64()), (14, Some(2)));
    let first = fs::read_to_string(folder.join("compare.toml")).expect("what made it");
    assert!(first.contains("scene_2_differs = \"coordination.comm=\\\"power\\\""), "{first}");
}

/// One line that names what is wrong.
#[test]
fn bad_ones_are_refused() {
    let refused = |arguments: &[&str], says: &[&str]| {
        let output = host_sim(&[&["compare"], arguments].concat()).output().expect("host-sim runs");
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), error.trim_end().lines().count()), (Some(2), 1), "{arguments:?}: {error}");
        says.iter().for_each(|says| assert!(error.contains(says), "{arguments:?}: {says:?} is missing in: {error}"));
    };
    refused(&["wave"], &["2 values required"]);
    refused(&["wave", "wafe"], &["wafe is neither a file nor a built-in scene", "the laws are power, p-plus-d, wave,"]);
    refused(&["wave", "wave,object.mas_kg=1"], &["there is no key object.mas_kg", "did you mean object.mass_kg?"]);
    refused(&["wave", "power", "--merit", "true"], &["they are true_discrepancy_mm,"]);
    refused(&["wave", "power", "--seeds", "0"], &["--seeds 0 is not allowed"]);
}
