//! On one machine, without routers: a link is made, used, and used up; the meeting place dies and comes back.

use std::path::PathBuf;
use std::process::Command;

use super::peers::{COHOLD, Running, peer};

pub(crate) fn cohold() -> Command {
    Command::new(COHOLD)
}

pub(crate) fn meet(listen: &str) -> (Running, String) {
    let mut command = cohold();
    command.args(["meet", "--json", "--listen", listen]);
    let meet = Running::start(command);
    let line = meet.says("meeting place on");
    let place = line.split_whitespace().nth(3).expect("an address").to_owned();
    (meet, place)
}

/// A path that is not there yet.
pub(crate) fn fresh(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("homes-{name}"));
    let _ = std::fs::remove_file(&path);
    path
}

#[test]
fn a_link_is_all_that_the_other_side_needs_and_it_serves_once() {
    let (meet, place) = meet("127.0.0.1:0");
    let (key, recordings) = (fresh("kept.key"), ["one", "two"].map(|name| fresh(&format!("{name}.mcap"))));
    let [kept, recorded, other] =
        [&key, &recordings[0], &recordings[1]].map(|path| path.to_str().expect("a name").to_owned());
    let one = peer(cohold(), 4, &["--invite", "--meet", &place, "--keep", &kept, "--record", &recorded]);
    let link = one.says("haptic://");
    let two = peer(cohold(), 4, &["--accept", &link, "--record", &other]);
    one.says("a key is agreed on");
    // Both read the same six digits to each other.
    let codes = [&one, &two].map(|end| end.says("code of this meeting: "));
    assert!(codes[0] == codes[1] && codes[0].len() == "code of this meeting: 123 456".len(), "{codes:?}");
    // Whoever has the link now has nothing.
    let mut thief = cohold();
    thief.args(["peer", "--accept", &link]);
    let thief = Running::start(thief);
    thief.says("this link has been used");
    one.says("somebody else came with the link and was refused");
    let told = [one.report(), two.report()];
    for told in &told {
        assert!(told.first(&["relayed", "both"]).is_some_and(|at| at < 5.0), "{:?}", told.ways);
        assert!(told.first(&["both", "direct"]).is_some_and(|at| at < 8.0), "{:?}", told.ways);
        assert!(told.noticed("Engaged").is_some() && told.noticed("Lost").is_none_or(|at| at > 4.0), "{told:?}");
        assert_eq!(told.report["path"]["lan"], true, "both are on this machine");
        assert!(told.number("/ticks") >= 3999.0, "{}", told.report);
        assert_eq!(told.number("/datagrams_missing"), 0.0, "{}", told.report);
        // For a second or more both paths brought everything: copies are no refusals.
        assert_eq!(told.number("/datagrams_refused"), 0.0, "{}", told.report);
        assert!(told.number("/path/copies") > 500.0, "{}", told.report);
    }
    // What was agreed on is kept as a key file, and every change of path is in the recording.
    assert_eq!(std::fs::read_to_string(&key).expect("a key file").trim().len(), 64);
    // A board takes it as it takes any (`cargo xtask provision` has its two keys made into this image).
    let (operator, image) = (fresh("kept-operator.key"), fresh("kept.bin"));
    assert!(
        cohold().args(["key", "generate", "--operator"]).arg(&operator).output().expect("it runs").status.success()
    );
    let files = [key.as_os_str(), "--operator-key-file".as_ref(), operator.as_os_str(), image.as_os_str()];
    let made = cohold().args(["key", "image", "--key-file"]).args(files).output().expect("it runs");
    assert!(made.status.success() && image.exists(), "{}", String::from_utf8_lossy(&made.stderr));
    let (table, paths) = (fresh("one.csv"), fresh("one-paths.csv"));
    let mut convert = cohold();
    convert.args(["recording", "convert", &recorded]).arg(&table);
    fresh("one-exchanges.csv");
    fresh("one-log.csv");
    fresh("one-seconds.csv");
    fresh("one.toml");
    assert!(convert.output().expect("it runs").status.success());
    let text = std::fs::read_to_string(&paths).expect("a table");
    let changes = told[0].ways.len();
    assert!(
        text.lines().count() > changes + 3 && text.lines().next().is_some_and(|line| line.contains("direct_p99_s")),
        "{text}"
    );
    // The recordings of both homes have one clock, as on a LAN: this machine's, to within half of a round trip and some.
    let merged = cohold().args(["recording", "merge", "--json", &recorded, &other]).output().expect("it runs");
    let merged: serde_json::Value = serde_json::from_slice(&merged.stdout).expect("JSON");
    let number = |name: &str| merged[name].as_f64().unwrap_or(f64::NAN);
    assert!(number("instants") > 2000.0 && number("largest_true_discrepancy_mm") < 5.0, "{merged}");
    assert!(number("same_machine_less_this_us").abs() <= number("clock_error_us"), "{merged}");
    meet.interrupt();
    let (good, said) = meet.end();
    let counts: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    assert!(good && counts["passed"].as_u64().is_some_and(|passed| passed > 100), "{counts}");
}

/// A thief takes the link on its way and sends on one of his own. Each of his two ends agrees with one of the two people.
#[test]
fn a_link_that_was_replaced_shows_other_digits_at_each_end() {
    let (meet, place) = meet("127.0.0.1:0");
    let ends = |more: &[&str]| peer(cohold(), 1, more);
    let (one, thief) = (ends(&["--invite", "--meet", &place]), ends(&["--invite", "--meet", &place]));
    let (link, replaced) = (one.says("haptic://"), thief.says("haptic://"));
    let (near, two) = (ends(&["--accept", &link]), ends(&["--accept", &replaced]));
    let [one, near, far, two] = [&one, &near, &thief, &two].map(|end| end.says("code of this meeting: "));
    assert!(one == near && far == two, "{one}, {near}, {far}, {two}");
    assert_ne!(one, two, "the two people read each other other digits");
    meet.kill();
}

#[test]
fn a_wrong_link_is_refused_before_anything_is_sent() {
    for (link, says) in [
        ("haptic://127.0.0.1:9/aaaaaaaaaaaaaaaaaaaaaaaaaaaab", "a letter of this link is wrong"),
        ("https://127.0.0.1:9", "this is no link"),
    ] {
        let mut command = cohold();
        command.args(["peer", "--accept", link]);
        let output = command.output().expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(says), "{said}");
    }
}

#[test]
fn two_with_a_key_file_meet_on_the_relay_and_outlive_its_restart() {
    let (first, place) = meet("127.0.0.1:0");
    let key = fresh("pair.key");
    let name = key.to_str().expect("a name");
    assert!(cohold().args(["key", "generate", name]).output().expect("it runs").status.success());
    let ends = ["1", "2"]
        .map(|number| peer(cohold(), 6, &["--number", number, "--meet", &place, "--key-file", name, "--relay-only"]));
    std::thread::sleep(std::time::Duration::from_secs(4));
    first.kill();
    let (second, again) = meet(&place);
    assert_eq!(place, again);
    for end in ends {
        let told = end.report();
        assert_eq!(told.way(), "relayed", "{}", told.report);
        assert!(told.ways.iter().all(|(_, way)| way == "relayed" || way == "nowhere"), "{:?}", told.ways);
        assert!(told.number("/ticks") >= 5999.0 && told.report["fault"].is_null(), "{}", told.report);
        assert_eq!(told.number("/path/direct/signals"), 0.0, "no address was told");
    }
    second.kill();
}
