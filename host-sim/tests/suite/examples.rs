//! The programs of `examples/`, built from outside the packages that they use, and run.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::program::built::built;

fn run(program: &Path, arguments: &[&str]) -> Output {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("examples");
    std::fs::create_dir_all(&folder).expect("a folder for its files");
    Command::new(program).args(arguments).current_dir(folder).output().expect("it runs")
}

/// What it printed as JSON.
fn json(program: &Path, arguments: &[&str]) -> Value {
    let output = run(program, &[&["--json"], arguments].concat());
    assert!(matches!(output.status.code(), Some(0 | 1)), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON document")
}

#[test]
fn a_law_from_outside_is_simulated_proved_and_compared() {
    let program = built().join("outside-law");
    let predict = |ahead_s: &'static str| ["--set", "coordination.comm=predict", "--set", ahead_s];
    let of = |command: &[&str], ahead_s| json(&program, &[command, &predict(ahead_s)[..]].concat());
    let radius = |ahead_s| of(&["stability", "point"], ahead_s)["spectral_radius"].as_f64().expect("a radius");
    let limit = |ahead_s| {
        let range = ["stability", "limit", "--of", "coordination.stiffness_n_per_m", "--from", "0", "--to", "5000"];
        of(&range, ahead_s)["crossings"][0].as_f64().expect("a limit")
    };
    // Carried on by nothing it is the power-domain law; carried on by a packet's delay it bears more, but not much more.
    let power = json(&program, &["stability", "point", "--set", "coordination.comm=power"]);
    assert_eq!(Some(radius("predict.ahead_s=0")), power["spectral_radius"].as_f64());
    assert_ne!(radius("predict.ahead_s=0"), radius("predict.ahead_s=0.008"));
    let limits = [limit("predict.ahead_s=0"), limit("predict.ahead_s=0.008")];
    assert!(limits.iter().all(|limit| (10.0..5000.0).contains(limit)) && limits[0] != limits[1], "{limits:?}");

    // On the bench it has a row, and one for each network.
    let bench = json(&program, &["study", "laws", "predict"]);
    assert_eq!((&bench["laws"][0]["law"], &bench["networks"][0]["comm"]), (&"predict".into(), &"predict".into()));
    assert_eq!(bench["networks"].as_array().map(Vec::len), Some(38));

    // Two users push; the run is another one when the copy is carried on, and says what it was configured with.
    let pushed = ["coordination.stiffness_n_per_m=310", "user.1.push_n=1", "user.2.push_n=0.5"];
    let pushed: Vec<&str> = pushed.iter().flat_map(|setting| ["--set", setting]).collect();
    let metrics = |ahead_s| of(&[&["cooperate", "--seconds", "2"], &pushed[..]].concat(), ahead_s);
    let (plain, ahead) = (metrics("predict.ahead_s=0"), metrics("predict.ahead_s=0.01"));
    assert!(plain["stable"] == true && ahead["stable"] == true, "{plain} {ahead}");
    assert!(plain["true_discrepancy_mm"].as_f64() > Some(1.0) && plain["state_hash"] != ahead["state_hash"], "{plain}");
    assert_eq!(ahead["made"]["settings"]["predict.ahead_s"], "0.01");
    let table = json(&program, &["study", "networks"]);
    let rows: Vec<&Value> = table.as_array().expect("rows").iter().filter(|row| row["comm"] == "predict").collect();
    assert!(rows.len() > 20 && rows.iter().any(|row| row["stable"] == true), "{rows:?}");

    let refused = |setting: &str, wanted: &[&str]| {
        let output = run(&program, &["cooperate", "--set", "coordination.comm=predict", "--set", setting]);
        let line = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!((output.status.code(), line.lines().count()), (Some(2), 1), "{line}");
        assert!(wanted.iter().all(|word| line.contains(word)), "{line}");
    };
    refused("predict.ahead_s=1", &["predict.ahead_s = 1 is not allowed", "from 0 to 0.2 s"]);
    refused("predict.ahaed_s=0.1", &["did you mean predict.ahead_s?"]);
    refused("coordination.comm=predikt", &["did you mean predict?", "\"power\""]);
    let keys = json(&program, &["cooperate", "--keys"]);
    assert!(keys.as_array().expect("keys").iter().any(|key| key["key"] == "predict.ahead_s" && key["unit"] == "s"));
}

#[test]
fn an_observer_and_a_plant_from_outside_run() {
    let observer = run(&built().join("observer"), &[]);
    assert!(observer.status.success(), "{}", String::from_utf8_lossy(&observer.stderr));
    let figure = Path::new(env!("CARGO_TARGET_TMPDIR")).join("examples/out/felt.svg");
    let figure = std::fs::read_to_string(figure).expect("its figure");
    assert!(figure.contains("user 2") && figure.contains("Contact force"));

    let plant = run(&built().join("plant"), &[]);
    assert!(plant.status.success(), "{}", String::from_utf8_lossy(&plant.stderr));
    // Both handles are pulled home by springs, and pushed to where these hold them.
    let text = String::from_utf8_lossy(&plant.stdout).into_owned();
    assert!(text.lines().count() == 2 && text.lines().all(|line| line.contains("handle at ")), "{text}");
}

/// What a command from outside prints, and that it stands beside the others.
#[test]
fn a_command_and_a_study_from_outside_run() {
    let program = built().join("outside-command");
    let rows = json(&program, &["delays", "--most", "2"]);
    let rows = rows.as_array().expect("rows");
    assert_eq!(rows.len(), 3);
    for (packets, row) in rows.iter().enumerate() {
        // What the command line says of the same scene.
        let delay = format!("network.one_way_delay_packets={packets}");
        let sets = ["--set", &delay, "--set", "user.1.push_n=1", "--set", "user.2.push_n=1", "--seconds", "5"];
        let alone = json(&program, &[&["cooperate"], &sets[..]].concat());
        let verdict = &alone["verdict"];
        assert_eq!((&row["one_way_delay_packets"], &row["verdict"]), (&packets.into(), verdict), "{row}");
        if verdict == "stable" {
            assert_eq!(row["true_discrepancy_mm"], alone["true_discrepancy_mm"], "{row}");
        }
    }
    assert!(rows.iter().any(|row| row["true_discrepancy_mm"].is_number()), "{rows:?}");
    let help = String::from_utf8_lossy(&run(&program, &["--help"]).stdout).into_owned();
    assert!(help.contains("delays") && help.contains("over one-way delays") && help.contains("cooperate"), "{help}");
    let refused = run(&program, &["delays", "--most", "-1"]);
    assert_eq!(refused.status.code(), Some(2), "{}", String::from_utf8_lossy(&refused.stderr));
}

/// Lines of what somebody writes from outside: without comments, blank lines, what is imported, and what only an example has.
fn lines(name: &str, from: &str, to: &str) -> usize {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the repository").join("examples").join(name);
    let text = std::fs::read_to_string(file.join("src/main.rs")).expect("an example");
    let part = text.split_once(from).and_then(|(_, rest)| rest.split_once(to)).expect("its part").0;
    let counts = |line: &&str| !line.is_empty() && !line.starts_with("//");
    1 + part.lines().skip(1).map(str::trim).filter(counts).count()
}

/// A law, a device, a command and a study are short; a quantity is one line (`columns::a_quantity_more_is_one_line`).
#[test]
fn what_comes_from_outside_is_short() {
    let law = lines("outside-law", "const AHEAD", "/// The law in every number type.");
    let device = lines("plant", "impl Device<f32> for Handle", "fn main");
    let command = lines("outside-command", "#[derive(clap::Args)]", "fn main");
    println!("a law takes {law} lines, a device {device}, a command with its study {command}");
    assert!(law <= 45 && device <= 40 && command <= 30, "law {law}, device {device}, command {command}");
}
