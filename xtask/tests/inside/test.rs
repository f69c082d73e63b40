//! Tests of `src/test.rs` from inside.

use super::*;

/// Whether a source file has a test, and whether its documentation has an example that is compiled.
fn tests_in(text: &str) -> (bool, bool) {
    let mut inside = false;
    let mut example = false;
    for line in text.lines().map(str::trim_start).filter(|line| line.starts_with("//")) {
        let line = line.trim_start_matches(['/', '!']).trim();
        if let Some(kind) = line.strip_prefix("```") {
            example |= !inside && ["", "rust", "no_run", "should_panic", "compile_fail"].contains(&kind);
            inside = !inside;
        }
    }
    (text.contains("#[test]") || text.contains("#[cfg(test)]"), example)
}

#[test]
fn what_is_said_to_have_no_tests_has_none() {
    assert_eq!(tests_in("/// ```text\n/// a\n/// ```\nfn a() {}\n"), (false, false));
    assert_eq!(tests_in("//! ```\n//! a();\n//! ```\n#[cfg(test)]\nmod tests;\n"), (true, true));
    let manifests = run::output(&mut run::command("git", &["ls-files", "*Cargo.toml"])).expect("git lists files");
    let mut without = [0, 0];
    for manifest in manifests.lines().map(|name| run::root().join(name)) {
        let text = run::read(&manifest).expect("a manifest");
        // The library's section alone: programs in bin/ have their own.
        let lib = text.split("[lib]").nth(1).and_then(|rest| rest.split("\n[").next()).unwrap_or_default();
        let off = ["\ntest = false", "\ndoctest = false"].map(|line| lib.contains(line));
        without = [0, 1].map(|at| without[at] + usize::from(off[at]));
        let mut folders = vec![manifest.with_file_name("src")];
        while let Some(folder) = folders.pop().filter(|_| off != [false; 2]) {
            for path in folder.read_dir().into_iter().flatten().flatten().map(|entry| entry.path()) {
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|ending| ending == "rs") {
                    let (tests, examples) = tests_in(&run::read(&path).expect("a source file"));
                    assert!(!(off[0] && tests), "{}: Cargo.toml says that there are no tests", path.display());
                    assert!(!(off[1] && examples), "{}: Cargo.toml says that there are no examples", path.display());
                }
            }
        }
    }
    assert!(without[0] >= 9 && without[1] >= 9, "{without:?}");
}

#[test]
#[cfg(unix)]
fn a_failed_test_runs_again_only_if_the_machine_had_stopped_a_program() {
    let shell = |says: &str| {
        let script = format!("[ \"$1\" = of::a ] && exit 0; echo 'test of::a ... FAILED'; echo '{says}'; exit 101");
        run::command("sh", &["-c", &script])
    };
    undisturbed(&mut shell("fault 29: this end stood still for 943 ms, of 50 allowed")).expect("it passes alone");
    let failure = undisturbed(&mut shell("left: 1, right: 2")).expect_err("nobody was stopped");
    assert!(failure.to_string().contains("failed"), "{failure}");
}
