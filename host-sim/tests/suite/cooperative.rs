//! The cooperative environment as a command.

/// Bad input: exit status 2, nothing on standard output, one line that names it.
#[test]
fn the_command_refuses_what_makes_no_sense() {
    for (arguments, names) in [
        (&["--users", "17"][..], "from 1 to 16"),
        (&["--users", "0"], "from 1 to 16"),
        (&["--delay-ms", "-1"], "from 0 to 1000 ms"),
        (&["--delay-ms", "nan"], "from 0 to 1000 ms"),
        (&["--seconds", "nan"], "to 3600 s"),
        (&["--bounder", "maybe"], "maybe"),
        (&["--collision", "server", "--engine", "client"], "the engine must be at the server"),
        (&["--set", "contact.stifness_n_per_m=1"], "did you mean contact.stiffness_n_per_m?"),
    ] {
        let command = std::process::Command::new(env!("CARGO_BIN_EXE_cohold"))
            .args(["shared", "cooperative"])
            .args(arguments)
            .output();
        let output = command.expect("cohold runs");
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty() && error.contains(names) && error.trim_end().lines().count() == 1, "{error}");
    }
}
