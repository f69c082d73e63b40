//! Tests of `src/board.rs` from inside.

use super::*;

fn refusal(arguments: &[&str]) -> String {
    crate::read("board", arguments).and_then(|given| check(&given)).expect_err("refused").to_string()
}

#[test]
fn a_wrong_command_line_is_one_line_that_says_what_is_allowed() {
    for (arguments, says) in [
        (&["--scenes", "x"][..], "there is no option --scenes;"),
        (&["--json=1"], "there is no option --json=1;"),
        (&["--json", "fast"], "there is no option fast;"),
        (&["--seconds"], "--seconds needs a value;"),
        (&["--seconds", "0.5"], "--seconds \"0.5\" is not allowed: it must be a number from 1 to 3600"),
        (&["--seconds=nan"], "--seconds \"nan\" is not allowed: it must be a number from 1 to 3600"),
        (&["--set", "mass=1"], "--set \"mass=1\" is not allowed: it must be TABLE.KEY=VALUE"),
        (&["--scene", "impulse"], "--scene \"impulse\" is not allowed: it must be a file or one of "),
    ] {
        let refusal = refusal(arguments);
        assert!(refusal.starts_with(says) && !refusal.contains('\n'), "{refusal}");
    }
}

#[test]
fn files_and_every_built_in_name_pass() {
    let file = run::root().join("scenes/impulsive.toml");
    let names: Vec<String> = built_in().chain([file.display().to_string()]).collect();
    assert!(names.len() > 12, "{names:?}");
    for name in &names {
        let arguments = ["--scene", name, "--set=user.1.push_n=1", "--seconds", "1e3", "--json", "--out", "x"];
        let given = crate::read("board", &arguments).unwrap();
        check(&given).unwrap();
        assert_eq!(given.words().collect::<Vec<_>>().join(" "), arguments.join(" ").replace("set=", "set "));
    }
}
