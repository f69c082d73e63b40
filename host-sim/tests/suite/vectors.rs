//! The program for wider vectors that lies beside this one: it is started where the processor has them, and may be forbidden.

use std::process::Command;

#[cfg(all(unix, target_arch = "x86_64"))]
#[test]
fn the_widest_program_that_the_processor_has_runs() {
    use std::fs;
    use std::os::unix::fs::PermissionsExt;
    use std::path::Path;

    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("vectors");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    let program = folder.join("cohold");
    fs::copy(env!("CARGO_BIN_EXE_cohold"), &program).expect("a copy");
    let said = |most: &str| {
        let mut command = Command::new(&program);
        let output = command.args(["listing of", "--json"]).env("COHOLD_VECTORS", most).output().expect("it runs");
        String::from_utf8(output.stdout).expect("text")
    };
    let alone = said("");
    for level in ["x86-64-v3", "x86-64-v4"] {
        let wider = folder.join(format!("cohold-{level}"));
        fs::write(&wider, format!("#!/bin/sh\nprintf '{level} %s.' \"$@\"\n")).expect("a file");
        fs::set_permissions(&wider, fs::Permissions::from_mode(0o755)).expect("permissions");
    }
    let of = |level: &str| format!("{level} listing of.{level} --json.");
    let (has_v3, has_v4) = (is_x86_feature_detected!("avx2"), is_x86_feature_detected!("avx512vl"));
    let v3 = if has_v3 { of("x86-64-v3") } else { alone.clone() };
    assert_eq!(said(""), if has_v4 { of("x86-64-v4") } else { v3.clone() });
    assert_eq!(said("x86-64-v3"), v3);
    assert_eq!(said("compiled"), alone);
}

/// A word that is no level is refused, and not taken for another one.
#[test]
fn a_word_that_is_no_level_is_refused() {
    for wrong in ["v4", "x86-64-v5", "Compiled"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cohold"));
        let output =
            command.args(["recording", "columns", "--json"]).env("COHOLD_VECTORS", wrong).output().expect("it runs");
        let said = String::from_utf8(output.stderr).expect("text");
        let must = "it must be x86-64-v4, x86-64-v3 or compiled, or not be set";
        assert_eq!(said, format!("cohold: COHOLD_VECTORS = {wrong:?} is not allowed: {must}\n"));
        assert_eq!((output.status.code(), output.stdout.as_slice()), (Some(2), &b""[..]));
    }
}
