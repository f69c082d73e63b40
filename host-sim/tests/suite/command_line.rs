//! The commands as a script sees them: one JSON document on standard output, the papers' numbers in it.

use std::process::Command;

use serde_json::Value;

fn json(arguments: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_cohold")).args(arguments).output().expect("cohold runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{arguments:?}: {error}");
    let document: Value = serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else");
    // 1: it is done, and not good.
    let is_bad = ["cooperate", "point"].iter().any(|word| arguments.contains(word)) && document["stable"] == false;
    assert_eq!(output.status.code(), Some(i32::from(is_bad)), "{arguments:?}: {error}");
    document
}

#[track_caller]
fn close(got: &Value, want: f64, relative: f64) {
    let number = got.as_f64().unwrap_or_else(|| panic!("{got} is no number"));
    assert!((number / want - 1.0).abs() <= relative, "{number} is not {want} within {relative}");
}

/// Exit status 1 and a sentence for what is done and is not good, as a script and a person need it; the document is the same.
#[test]
fn what_is_not_stable_ends_with_status_1_and_says_why() {
    let stiff = ["--json", "--set=coordination.comm=power", "--set=coordination.stiffness_n_per_m=2000"];
    for (command, says) in [
        (&["cooperate", "--seconds=2", "--set=user.1.push_n=1"][..], "cohold: peer 1 stopped at"),
        (&["cooperate", "--seconds=0.1"], "cohold: the scene is unstable: spectral radius 1.07"),
        (&["stability", "point"], "cohold: scene is unstable: spectral radius 1.232393"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_cohold")).args(command).args(stiff).output().expect("it runs");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(1) && error.contains(says), "{command:?}: {error}");
        let document: Value = serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else");
        assert_eq!(document["stable"], false);
    }
}

/// THEORY §4, marked checked: the decoded discrepancies beside the paper's 3.5, 0.644 and 0.099 mm, the true ones beside.
/// Who finds a file in two years knows which program made it.
#[test]
fn results_name_the_commit() {
    let made = json(&["--json", "stability", "point"])["made"].clone();
    let commit = made["commit"].as_str().expect("a commit").trim_end_matches(", changed");
    let git = Command::new("git").args(["cat-file", "-t", commit]).output().expect("git runs");
    assert_eq!(String::from_utf8_lossy(&git.stdout).trim(), "commit", "{commit}");
}

#[test]
fn the_papers_discrepancies() {
    let document = json(&["paper", "--json"]);
    let experiments = document["experiments"].as_array().expect("a list of experiments");
    let find = |section: &str, law: &str, round_trip: f64| {
        experiments
            .iter()
            .find(|one| one["section"] == section && one["comm"] == law && one["round_trip_ms"] == round_trip)
            .unwrap_or_else(|| panic!("no experiment {section} {law} {round_trip}"))
    };
    for (law, decoded, decoded_within, true_mm, paper) in [
        ("power", 3.25, 0.01, 3.24, 3.5),
        ("wave", 0.638, 0.02, 2.24, 0.644),
        ("passive-wave", 0.0946, 0.01, 1.78, 0.099),
    ] {
        let one = find("5.2", law, 16.0);
        assert_eq!(one["stable"], true, "{law}");
        close(&one["decoded_discrepancy_mm"], decoded, decoded_within);
        close(&one["true_discrepancy_mm"], true_mm, 0.02);
        close(&one["paper_discrepancy_mm"], paper, 0.0);
    }
    // §5.1: at 32 ms the power-domain gain of 16 ms no longer holds; both wave gains do.
    for (law, stable) in [("power", false), ("wave", true), ("passive-wave", true)] {
        assert_eq!(find("5.1", law, 32.0)["stable"], stable, "{law} at 32 ms");
        assert_eq!(find("5.1", law, 16.0)["stable"], true, "{law} at 16 ms");
    }
}

/// THEORY §4: the matched line comes near the floor of an elastic rod of the same mass.
#[test]
fn the_matched_line() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/matched-line.toml");
    let report = json(&["cooperate", "--scene", scene, "--json"]);
    assert_eq!(report["stable"], true);
    let per_newton = report["true_discrepancy_mm_per_n"].as_f64().expect("a number");
    let mass = report["apparent_object_mass_kg"].as_f64().expect("a number");
    assert!(per_newton <= 0.37, "{per_newton} mm/N");
    assert!((0.60..=0.70).contains(&mass), "{mass} kg");
}

/// Each shared axis has the figures of a run of its own, and all together their distance.
#[test]
fn several_axes_in_one_run() {
    let keys =
        ["axis.count=3", "axis.shared=3", "user.1.push_n=1", "user.1.direction_rad=0.7", "user.1.elevation_rad=0.4"];
    let scene = ["user.2.push_n=1", "user.2.direction_rad=0.7", "user.2.elevation_rad=0.4"];
    let sets = keys.iter().chain(&scene).flat_map(|key| ["--set", key]);
    let arguments: Vec<_> =
        ["cooperate", "--json", "--scene", "matched-line", "--seconds", "4"].into_iter().chain(sets).collect();
    let report = json(&arguments);
    assert_eq!(report["stable"], true);
    let axes = report["axes"].as_array().expect("a list of axes");
    let names: Vec<_> = axes.iter().map(|axis| axis["axis"].as_str().expect("a name")).collect();
    assert_eq!(names, ["x", "y", "z"]);
    // Both push with 1 N against each other along one line: the coordination forces are its parts.
    let force: f64 = axes.iter().map(|axis| axis["coordination_force_n"]["mean"].as_f64().expect("N").powi(2)).sum();
    close(&Value::from(force.sqrt()), 1.0, 0.02);
    let apart: f64 = axes.iter().map(|axis| axis["true_discrepancy_mm"].as_f64().expect("mm").powi(2)).sum();
    close(&report["true_discrepancy_mm"], apart.sqrt(), 0.05);
}

/// Of axes that the device couples, `stability` says which direction is worst.
#[test]
fn stability_of_several_axes_names_a_direction() {
    let point = |keys: &[&str]| {
        let both = ["axis.count=2", "axis.shared=2", "coordination.comm=power", "coordination.stiffness_n_per_m=250"];
        let sets = both.iter().chain(keys).flat_map(|key| ["--set", key]);
        json(&["stability", "point", "--json"].into_iter().chain(sets).collect::<Vec<_>>())
    };
    let alike = point(&[]);
    assert_eq!(alike["direction"], "any");
    // The same mechanism on both sides of its mirror: unlike along its axes, which do not couple.
    let five_bar = point(&["kinematics.model=five-bar", "device.joint_inertia=0.002"]);
    let along = five_bar["modes"][0]["direction"]["along"].as_array().expect("a direction").clone();
    let size = |axis: usize| along[axis].as_f64().expect("a part").abs();
    assert!((size(0).max(size(1)) - 1.0).abs() < 1e-6 && size(0).min(size(1)) < 1e-6, "{along:?}");
    assert!(five_bar["modes"][0]["spectral_radius"] != alike["modes"][0]["spectral_radius"]);
}

/// The dot in a scene's name is no extension: scenes in one folder once overwrote each other's files.
#[test]
fn files_of_scenes_with_dots_in_their_names() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("dotted");
    let out = folder.display().to_string();
    for name in ["paper-5.1-passive-wave-16ms", "impulsive"] {
        let report = json(&["cooperate", "--json", "--seconds", "0.1", "--scene", name, "--out", &out]);
        assert_eq!((&report["scene"], &report["warnings"]), (&name.into(), &Value::Array(vec![])));
        for kind in ["csv", "parquet"] {
            assert!(folder.join(format!("{name}.{kind}")).exists(), "{name}.{kind} in {report}");
        }
    }
}

#[test]
fn a_scene_in_which_nobody_pushes_says_so() {
    let report = json(&["cooperate", "--json", "--seconds", "0.1"]);
    let warning = report["warnings"][0].as_str().expect("a warning");
    assert!(warning.starts_with("nobody pushes: set user.1.push_n"), "{warning}");
}

/// `cohold cooperate --keys | head -3`: quiet, and no success.
#[test]
fn a_reader_that_goes_away_ends_the_program_quietly() {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let output = Command::new(env!("CARGO_BIN_EXE_cohold"))
        .args(["cooperate", "--keys"])
        .stdout(writer)
        .output()
        .expect("it runs");
    assert_eq!((output.status.code(), String::from_utf8_lossy(&output.stderr).as_ref()), (Some(141), ""));
}

#[test]
fn cooperate_reports_what_scripts_rely_on() {
    let report = json(&["cooperate", "--json", "--seconds", "2", "--set", "user.1.push_n=1"]);
    assert_eq!(report["ticks"], 2000);
    assert_eq!(report["seed"], 1);
    for key in ["true_discrepancy_mm", "decoded_discrepancy_mm", "wall_s", "spectral_radius"] {
        assert!(report[key].is_number(), "{key} in {report}");
    }
    for key in ["mean", "sd"] {
        assert!(report["coordination_force_n"][key].is_number(), "coordination_force_n.{key}");
    }
}

/// An unstable scene is a result, with a fault that says why the machine stopped, and a warning that says what to change.
#[test]
fn an_unstable_scene_is_a_result_with_advice() {
    let report = json(&[
        "cooperate",
        "--json",
        "--set",
        "coordination.comm=power",
        "--set",
        "coordination.stiffness_n_per_m=2000",
        "--set",
        "user.1.push_n=1",
        "--set",
        "user.2.push_n=1",
    ]);
    assert_eq!((&report["stable"], &report["verdict"]), (&false.into(), &"NO".into()));
    assert!(report["reason"].as_str().is_some_and(|reason| reason.contains(" stopped at ")), "{report}");
    for metric in
        ["true_discrepancy_mm", "decoded_discrepancy_mm", "peak_coordination_force_n", "apparent_object_mass_kg"]
    {
        assert!(report[metric].is_null(), "{metric} in {report}");
    }
    assert!(report["spectral_radius"].as_f64().is_some_and(|radius| radius > 1.0));
    let warning = report["warnings"][0].as_str().expect("a warning");
    assert!(warning.contains("coordination.stiffness_n_per_m"), "{warning}");
}

#[test]
fn files_hold_the_run() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("cooperate");
    let report = json(&["cooperate", "--json", "--seconds", "1", "--out", &folder.display().to_string()]);
    let files = report["files"].as_array().expect("a list of files");
    for extension in ["csv", "parquet", "svg", "pdf", "png"] {
        let file = files
            .iter()
            .filter_map(Value::as_str)
            .find(|file| file.ends_with(extension))
            .unwrap_or_else(|| panic!("no .{extension} in {files:?}"));
        assert!(std::fs::metadata(file).expect("the file is there").len() > 1000, "{file}");
    }
    let named = |ending: &str| files.iter().filter_map(Value::as_str).find(|file| file.ends_with(ending)).expect("it");
    assert_eq!(csv::Reader::from_path(named(".csv")).expect("a table").into_records().count(), 1000);

    // What made the files is a scene file: it runs the same again, and other settings go beside, not over it.
    let again = json(&["cooperate", "--json", "--seconds", "1", "--scene", named(".toml")]);
    assert_eq!(again["state_hash"], report["state_hash"]);
    assert_eq!(again["made"]["settings"], report["made"]["settings"]);
    let out = folder.display().to_string();
    let longer = json(&["cooperate", "--json", "--seconds", "1.5", "--out", &out]);
    assert_ne!(longer["files"], report["files"]);
    let other = json(&["cooperate", "--json", "--seconds", "1", "--out", &out, "--set", "user.1.push_n=1"]);
    assert!(other["files"].as_array().expect("a list of files").iter().all(|file| !files.contains(file)), "{other}");
}

/// `stability tune` proposes gains as overrides that can be pasted, proved with their margin and tried out.
#[test]
fn tune_proposes_gains_that_hold() {
    let report = json(&["stability", "tune", "--json", "--margin", "0.3", "--set", "coordination.comm=power"]);
    let proposal = &report["proposal"];
    for key in ["spectral_radius", "raised_spectral_radius"] {
        assert!(proposal[key].as_f64().is_some_and(|radius| radius < 1.0), "{key} in {report}");
    }
    assert_eq!(report["trial"]["bounded"], true);
    assert_eq!(report["trial"]["released"]["bounded"], true, "{report}");
    let set = report["set"].as_str().expect("a line of overrides");
    let mut arguments = vec!["stability", "point", "--json", "--set", "coordination.comm=power"];
    arguments.extend(set.split_whitespace());
    assert_eq!(json(&arguments)["spectral_radius"], proposal["spectral_radius"]);
}

/// Impulsive rendering: what the hand is given of the impacts, per peer; within the limits it is all, and below them what was not
/// needed any more is left.
#[test]
fn impacts_are_accounted() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/impulsive.toml");
    for (limit, least) in [("safety.max_force_n=40", 1.0 - 1e-12), ("safety.max_force_n=2", 0.9)] {
        let report = json(&["cooperate", "--scene", scene, "--set", limit, "--json"]);
        assert!(report["fault"].is_null());
        for peer in report["impacts"].as_array().expect("both peers") {
            let number = |key: &str| peer[key].as_f64().expect("a number");
            assert!(number("count") > 10.0 && number("lost_j") > 0.0, "{peer}");
            let share = number("delivered_n_s") / number("wanted_n_s");
            assert!((least..=1.0 + 1e-12).contains(&share), "{limit}: {peer}");
        }
    }
    assert!(json(&["cooperate", "--json"])["impacts"].is_null());
}

/// Wave peers around the server's node, and what does not go with them.
#[test]
fn wave_peers_around_a_node() {
    let rows =
        json(&["shared", "cooperative", "--waves", "--users", "5", "--delay-ms", "40", "--seconds", "4", "--json"]);
    assert_eq!(rows[0]["stable"], true);
    close(&rows[0]["node_out_over_in"], 1.0, 1e-12);
}

/// A stroke around an object: three corners that point out, one that points in, and the work accounted for.
#[test]
fn a_stroke_around_an_object() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("stroke");
    let document = json(&["shared", "world", "stroke", "--json", "--out", folder.to_str().expect("a name")]);
    let parts = document["parts"].as_array().expect("a list of sides");
    let held = parts.iter().filter(|part| part["leaves_at_m"].is_number()).count();
    assert_eq!((parts.len(), held), (4, 3));
    let [open, work] =
        [&document["remainder_j"], &document["energy"]["work_j"]].map(|energy| energy.as_f64().expect("J"));
    assert!(work > 0.1 && open.abs() < 1e-3 * work, "{document}");
    for file in document["files"].as_array().expect("a list of files") {
        let path = file.as_str().expect("a path");
        let size = std::fs::metadata(path).expect("the file is there").len();
        // What made them is a page of settings; the table and the picture are much more.
        assert!(size > if path.ends_with(".toml") { 200 } else { 5000 }, "{file}");
    }
}

/// Every command has a line of its own in the help, under a heading, in a terminal of 100 columns.
#[test]
fn commands_are_listed() {
    let output = Command::new(env!("CARGO_BIN_EXE_cohold")).arg("--help").output().expect("cohold runs");
    let help = String::from_utf8(output.stdout).expect("text");
    let listed = help.lines().skip_while(|line| !line.starts_with("Usage:")).skip(2);
    let listed: Vec<&str> = listed.take_while(|line| *line != "Options:").filter(|line| !line.is_empty()).collect();
    let names: Vec<&str> = listed.iter().map(|line| line.split("  ").find(|word| !word.is_empty()).unwrap()).collect();
    let want = "Simulate and see: play cooperate scene paper Analyse and compare: stability study accuracy Connect real peers: \
                peer meet shared network key Use devices and boards: devices board Read data: recording";
    assert_eq!(names.join(" "), want);
    assert!(listed.iter().all(|line| line.len() <= 100), "{listed:#?}");
}

/// What can be named is listed wherever a scene or a world is asked for, whatever else is missing there.
#[test]
fn keys_scenes_and_completions_are_listed() {
    for command in ["cooperate", "peer", "shared cooperative", "network trace", "stability map", "board operator"] {
        let words = |flag| command.split(' ').chain([flag, "--json"]).collect::<Vec<_>>();
        let find = |list: &Value, key: &str, name: &str| {
            list.as_array().is_some_and(|rows| rows.iter().any(|row| row[key] == name))
        };
        assert!(find(&json(&words("--keys")), "key", "coordination.stiffness_n_per_m"), "{command}");
        assert!(find(&json(&words("--scenes")), "name", "matched-line"), "{command}");
    }
    assert!(json(&["shared", "world", "serve", "--keys", "--json"])[0]["unit"].is_string());
    for shell in ["bash", "zsh", "fish"] {
        let output = Command::new(env!("CARGO_BIN_EXE_cohold")).args(["--completions", shell]).output();
        let script = String::from_utf8(output.expect("cohold runs").stdout).expect("text");
        assert!(script.contains("architectures") && script.contains("patience-s"), "{shell}");
    }
}

/// One scene, one seed, one time, by the same flags, whatever the command.
#[test]
fn a_scene_means_the_same_everywhere() {
    let short = ["--scene", "matched-line", "--seed", "3", "--seconds", "0.1", "--json"];
    assert_eq!(json(&[&["cooperate"], &short[..]].concat())["seed"], 3);
    let one = json(&[&["shared", "cooperative", "--delay-ms", "1"], &short[..]].concat());
    let none = json(&["shared", "cooperative", "--delay-ms", "1", "--seconds", "0.1", "--json"]);
    assert!(one["rows"][0]["felt_n"].is_number() && one["rows"] != none["rows"]);
}

/// A push so small that a run shows nothing of the instability: the analyser's word stands on top, whatever the number of axes.
#[test]
fn an_unstable_scene_is_called_so_along_several_axes_too() {
    let at = |stiffness: &str, axes: &[&str]| {
        let stiffness = format!("coordination.stiffness_n_per_m={stiffness}");
        let mut words = vec!["cooperate", "--json", "--seconds", "2", "--set", "coordination.comm=power"];
        words.extend(["--set", &stiffness, "--set", "user.1.push_n=0.01"]);
        words.extend(axes);
        json(&words)
    };
    let two = ["--set", "axis.count=2", "--set", "axis.shared=2"];
    let [one_axis, two_axes] = [at("359", &[]), at("359", &two)];
    for report in [&one_axis, &two_axes] {
        assert_eq!((&report["stable"], &report["verdict"]), (&false.into(), &"NO".into()), "{report}");
        close(&report["spectral_radius"], 1.000238, 1e-6);
        assert!(
            report["reason"].as_str().is_some_and(|reason| reason.contains("spectral radius 1.000238")),
            "{report}"
        );
    }
    assert_eq!(one_axis["warnings"], two_axes["warnings"]);
    // Stable while both hold it, and not where it is let go of.
    let [one_axis, two_axes] = [at("310", &[]), at("310", &two)];
    let warned = |report: &Value| report["warnings"].to_string().contains("unstable where the object is let go of");
    assert!(warned(&one_axis) && one_axis["warnings"] == two_axes["warnings"], "{two_axes}");
    // What user 1 does along the first axis is all that happens.
    for figure in ["true_discrepancy_mm", "decoded_discrepancy_mm", "peak_coordination_force_n", "energy_made_mj"] {
        close(&two_axes[figure], one_axis[figure].as_f64().expect("a figure"), 1e-9);
    }
    assert_eq!(two_axes["axes"].as_array().map(Vec::len), Some(2));
}

/// The two commands that docs/guides/leader-follower.md begins with say one thing: copies 34 mm apart through a line of 160 ms are an object, as statics
/// have it, and the scene is stable.
#[test]
fn a_run_and_the_analyser_agree_on_leader_and_follower() {
    let page = include_str!("../../../docs/guides/leader-follower.md");
    let commands: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("    cohold ")).take(2).collect();
    let said = |command: &str| {
        let words: Vec<&str> = command.split_whitespace().collect();
        let output = crate::program::cohold(&words).arg("--json").output().expect("cohold runs");
        assert_eq!(output.status.code(), Some(0), "{command}: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<Value>(&output.stdout).expect("one JSON document")
    };
    let [run, judged] = commands[..] else { panic!("the page has two commands: {commands:?}") };
    let [run, judged] = [run, judged].map(said);
    assert_eq!((&run["verdict"], &run["stable"], &judged["stable"]), (&"stable".into(), &true.into(), &true.into()));
    assert!(run["true_discrepancy_mm"].as_f64().is_some_and(|mm| (20.0..50.0).contains(&mm)), "{run}");
}

/// What says whether motors are on, and that they are stopped.
const OF_STOP: [&str; 15] = [
    include_str!("../../../firmware/src/hold.rs"),
    include_str!("../../../firmware/src/port.rs"),
    include_str!("../../../firmware/src/supervisor.rs"),
    include_str!("../../../protocol/src/lease.rs"),
    include_str!("../../board-tools/src/bringup.rs"),
    include_str!("../../board-tools/src/operator.rs"),
    include_str!("../../live/src/endpoint.rs"),
    include_str!("../../live/src/operator.rs"),
    include_str!("../../cli/src/board/operator.rs"),
    include_str!("../../guests/page/src/boards.rs"),
    include_str!("../../guests/page/src/site/delay.js"),
    include_str!("../../guests/page/src/site/join.js"),
    include_str!("../../guests/page/src/site/page.js"),
    include_str!("../../guests/page/src/site/status.js"),
    include_str!("../../guests/page/src/site/stiff.js"),
];

/// The sentences of Stop in docs/guides/play.md are those of the sources, whole. Words in italics, in braces in a source, differ.
#[test]
fn every_sentence_of_stop_is_in_the_documentation() {
    const WORDS: &str =
        "stopped|confirmed|motors are o|board * are on|board * may be|motors off|motors run|has ended|press the stop";
    let unfilled = |text: &str, marks: &[char]| text.split(marks).step_by(2).collect::<Vec<_>>().join("*");
    let (_, table) = include_str!("../../../docs/guides/play.md").split_once("| sentence | where |").expect("a table");
    let rows = table.lines().skip(2).map_while(|row| row.strip_prefix("| ")?.split_once(" |"));
    let told: Vec<_> = rows.map(|(sentence, _)| unfilled(sentence, &['*'])).collect();
    let mut said = Vec::new();
    for source in OF_STOP {
        let lines: Vec<_> = source.lines().map(str::trim).filter(|line| !line.starts_with("//")).collect();
        let text = lines.join("\n").replace("\\\n", "").replace("` +\n`", "").replace("${", "{");
        let quoted = |quote| text.lines().flat_map(move |line| line.split(quote).skip(1).step_by(2));
        let strings = quoted('"').chain(quoted('`')).map(|text| unfilled(text, &['{', '}']).replace("**", "*"));
        said.extend(strings.map(|text| text.trim_matches([';', ' ']).to_owned()));
    }
    let of_stop = |text: &&String| WORDS.split('|').any(|word| text.to_lowercase().contains(word));
    let missing: Vec<_> = said.iter().filter(of_stop).filter(|text| !told.contains(text)).collect();
    let unsaid: Vec<_> = told.iter().filter(|text| !said.contains(text)).collect();
    assert!(told.len() > 30 && missing.is_empty() && unsaid.is_empty(), "{missing:?} {unsaid:?}");
}
