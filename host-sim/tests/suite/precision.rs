//! `cohold accuracy precision`: growth rates against the analyser's spectral radius, and chaos distinguished from
//! error.

use std::process::Command;

use serde_json::Value;

fn json(arguments: &[&str]) -> Value {
    let output =
        Command::new(env!("CARGO_BIN_EXE_cohold")).args(arguments).arg("--json").output().expect("cohold runs");
    // 1: `stability point` of an unstable scene.
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{arguments:?}: {error}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// Rows of `accuracy precision`.
fn rows(arguments: &[&str]) -> Vec<Value> {
    let rows = json(&[&["accuracy", "precision"], arguments].concat());
    rows.as_array().expect("rows").clone()
}

/// An unstable scene in which nobody does anything: f64, f32 and fixed point stay at zero, and the shadow grows as its worst
/// mode does, ln ρ / T_n with T_n = 8 ms.
#[test]
fn a_shadow_grows_as_the_spectral_radius_says() {
    let idle = ["--set", "user.1.push_n=0", "--set", "user.2.push_n=0", "--set", "user.1.pulse_n=0"];
    for stiffness in [310.0, 400.0] {
        let stiffness = format!("coordination.stiffness_n_per_m={stiffness}");
        let scene = [&["--scene", "paper-5.1-power-32ms", "--set", &stiffness][..], &idle].concat();
        let point = json(&[&["stability", "point"], &scene[..]].concat());
        let modes = point["modes"].as_array().expect("modes");
        let held = modes.iter().find(|mode| mode["mode"] == "both").expect("both hands on");
        let wanted = held["spectral_radius"].as_f64().expect("a radius").ln() / 0.008;
        let rows = rows(&[&scene[..], &["--seconds", "5"]].concat());
        let got = rows[0]["growth_per_s"].as_f64().expect("a rate");
        assert!((got / wanted - 1.0).abs() < 0.05, "{stiffness}: {got} per second, {wanted} by the analyser");
        assert_eq!(rows[0]["f32"]["position_m"], 0.0);
    }
}

/// Encoders, friction and a contact that begins and ends make millimetres of 1 nm; a paper's scene makes none of it, and is
/// many steps off in f32: the one is chaos, the other error.
#[test]
fn chaos_is_told_from_error() {
    for number in ["f32", "i32f32"] {
        let chaotic = &rows(&["--scene", "real-device", "--seconds", "20"])[0];
        assert!(chaotic["growth_per_s"].as_f64() > Some(1.0), "{chaotic}");
        assert!(chaotic["shadow"]["position_m"].as_f64() > Some(1e-4), "{chaotic}");
        assert_eq!(chaotic[number]["verdict"], "chaos", "{chaotic}");
        let linear = &rows(&["--scene", "paper-5.2-passive-wave-16ms", "--seconds", "20"])[0];
        assert!(linear["growth_per_s"].as_f64().is_some_and(|rate| rate.abs() < 0.01), "{linear}");
        assert!(linear["shadow"]["position_m"].as_f64() < Some(1e-9), "{linear}");
        assert_eq!(linear[number]["verdict"], "error", "{linear}");
    }
}

/// A row of several shared axes is the worst one's, which it names; where there is one axis there is nothing to name.
#[test]
fn the_worst_of_several_axes_is_named() {
    let several = rows(&["--scene", "space", "--seconds", "1"]);
    assert_eq!(several.len(), 1);
    assert!(["x", "y", "z"].contains(&several[0]["axis"].as_str().expect("a name")), "{several:?}");
    let one = rows(&["--seconds", "1"]);
    assert!(one[0].get("axis").is_none(), "{one:?}");
}

/// A row a minute in, and one at the end, no smaller; of every scene in its place.
#[test]
fn rows_go_on_in_time() {
    let rows = rows(&["--coupled", "--seconds", "90"]);
    assert_eq!(rows.len(), 6);
    for rows in rows.chunks(2) {
        assert_eq!(rows[0]["scene"], rows[1]["scene"]);
        assert_eq!([&rows[0]["time_s"], &rows[1]["time_s"]].map(Value::as_f64), [Some(60.0), Some(90.0)]);
        for number in ["f32", "i32f32"] {
            let relative = [0, 1].map(|at| rows[at][number]["relative_m"].as_f64().expect("a number"));
            assert!(relative[0] > 0.0 && relative[0] <= relative[1], "{relative:?}");
        }
    }
}
