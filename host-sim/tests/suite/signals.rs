//! Ctrl-C and SIGTERM: every live command ends with its report and exit status 0, and the others know at once.

use std::process::Child;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::program::{Keys, cohold, free, report, signal};

/// When a notice was given, s.
fn when(notices: &Value, wanted: &str) -> Option<f64> {
    let notices = notices.as_array().expect("a list");
    notices.iter().find(|notice| notice["notice"] == wanted).and_then(|notice| notice["time_s"].as_f64())
}

/// Whether the other end said that it goes: who falls silent fades first, and is lost later. Before that a busy machine may have made a line
/// fade, which came back.
fn said_goodbye(notices: &Value) -> bool {
    let names: Vec<&str> =
        notices.as_array().expect("a list").iter().filter_map(|notice| notice["notice"].as_str()).collect();
    let Some(lost) = names.iter().position(|name| *name == "Lost") else { return false };
    let line = names[..lost].iter().rfind(|name| ["Engaged", "Fading", "Resumed"].contains(name));
    line != Some(&"Fading") && when(notices, "Disengaged") == when(notices, "Lost")
}

/// What a process that was asked to end reports, and how long that took.
fn ended(child: Child, name: &str) -> (Value, Duration) {
    let start = Instant::now();
    signal(&child, name);
    (report(child), start.elapsed())
}

/// Two peers in the middle of a long experiment: the one that is ended reports what it did, the other hears a goodbye and not 12
/// packet periods of silence.
#[test]
fn a_peer_that_is_ended_reports_and_tells_the_other() {
    for name in ["TERM", "INT"] {
        let keys = Keys::new(&format!("ended-{name}"), 0);
        let (one, two, key) = (free(), free(), keys.file(0));
        let peer = |number: &str, listen: &str, connect: &str| {
            let own = ["peer", "--json", "--number", number, "--listen", listen, "--connect", connect];
            let all = [&own[..], &["--scene", "any-network", "--seconds", "60", "--key-file", &key]].concat();
            cohold(&all).spawn().expect("cohold runs")
        };
        let (first, second) = (peer("1", &one, &two), peer("2", &two, &one));
        std::thread::sleep(Duration::from_millis(2_500));
        let (seen, took) = ended(first, name);
        assert!(took < Duration::from_secs(5), "{took:?}");
        assert!(seen["ticks"].as_u64().is_some_and(|ticks| (100..10_000).contains(&ticks)), "{seen}");
        // It ended by itself: nothing was lost before.
        assert!(when(&seen["notices"], "Engaged").is_some() && when(&seen["notices"], "Lost").is_none(), "{seen}");
        std::thread::sleep(Duration::from_millis(300));
        let (seen, _) = ended(second, name);
        assert!(said_goodbye(&seen["notices"]), "silence came first: {seen}");
    }
}

/// Nobody is there: what was asked to end has nothing to complain of.
#[test]
fn whoever_waits_ends_with_an_empty_report() {
    let keys = Keys::new("waits", 1);
    let (key, line, address, nobody) = (keys.file(0), keys.file(1), free(), free());
    let server = format!("1={nobody}");
    let addresses = format!("{address},{nobody},{}", free());
    let (one, two) = (free(), free());
    for (arguments, field) in [
        (&["peer", "--number", "1", "--listen", &address, "--connect", &nobody, "--key-file", &key][..], "ticks"),
        (&["shared", "hub", "--users", "2", "--listen", &address, "--key-file", &key], "packets"),
        (&["shared", "world", "visit", "--line", "1", "--server", &server, "--key-file", &line], "objects"),
        (
            &[
                "shared",
                "squash",
                "live",
                "--number",
                "0",
                "--addresses",
                &addresses,
                "--seconds",
                "60",
                "--key-file",
                &key,
            ],
            "links",
        ),
    ] {
        let waits = cohold(&[arguments, &["--json"]].concat()).spawn().expect("cohold runs");
        std::thread::sleep(Duration::from_millis(700));
        let (seen, took) = ended(waits, "TERM");
        assert!(seen[field] == 0 && took < Duration::from_secs(5), "{took:?}: {seen}");
    }
    let relay = cohold(&["network", "relay", "--json", "--listen-1", &one, "--listen-2", &two])
        .args(["--peer-1", "127.0.0.1:9", "--peer-2", "127.0.0.1:9"])
        .spawn()
        .expect("cohold runs");
    std::thread::sleep(Duration::from_millis(700));
    let (seen, took) = ended(relay, "TERM");
    assert!(seen["ways"][0]["taken"] == 0 && took < Duration::from_secs(5), "{took:?}: {seen}");
    let crowd = ["shared", "world", "crowd", "--json", "--clients", "5,6", "--warm-up-s", "0.5", "--seconds", "60"];
    let crowd = cohold(&crowd).spawn().expect("cohold runs");
    std::thread::sleep(Duration::from_millis(2_500));
    let crowd = ended(crowd, "TERM").0;
    assert_eq!(crowd["runs"].as_array().map(Vec::len), Some(1), "the second crowd is not begun: {crowd}");
    assert!(crowd["runs"][0]["answered"].as_u64() > Some(10), "{crowd}");
}

/// A server, a hub and a game tell theirs.
#[test]
fn servers_and_hubs_say_goodbye() {
    let keys = Keys::new("goodbyes", 2);
    let (key, address) = (keys.file(0), free());
    let world = crate::static_scene::TWO_ROOMS;
    let serve = [
        "shared",
        "world",
        "serve",
        "--json",
        "--world",
        world,
        "--region",
        "1",
        "--listen",
        &address,
        "--key-file",
        &key,
    ];
    let server = cohold(&serve).spawn().expect("cohold runs");
    let (at, line) = (format!("1={address}"), keys.file(1));
    let visit =
        ["shared", "world", "visit", "--json", "--line", "1", "--server", &at, "--seconds", "60", "--key-file", &line];
    let visitor = cohold(&visit).spawn().expect("cohold runs");
    std::thread::sleep(Duration::from_millis(1_500));
    let (seen, _) = ended(visitor, "INT");
    assert_eq!(seen["objects"], 5, "{seen}");
    let (seen, _) = ended(server, "INT");
    assert!(seen["clients"] == 1 && seen["served_s"].as_f64().is_some_and(|served_s| served_s < 60.0), "{seen}");

    let hub = ["shared", "hub", "--json", "--users", "2", "--listen", &address, "--seconds", "60", "--key-file", &key];
    let hub = cohold(&hub).spawn().expect("cohold runs");
    let peers = [1, 2].map(|line: u32| {
        let (number, key) = (line.to_string(), keys.file(line));
        let own = ["peer", "--json", "--scene", "hub", "--number", &number, "--listen", "127.0.0.1:0"];
        let all = [&own[..], &["--connect", &address, "--seconds", "60", "--key-file", &key]].concat();
        cohold(&all).spawn().expect("cohold runs")
    });
    std::thread::sleep(Duration::from_millis(2_500));
    let [first, second] = peers;
    let (_, _) = ended(first, "TERM");
    std::thread::sleep(Duration::from_millis(300));
    let (seen, _) = ended(hub, "TERM");
    assert!(seen["packets"].as_u64().is_some_and(|packets| (50..3_000).contains(&packets)), "{seen}");
    let notices = |line: usize| seen["lines"][line]["notices"].clone();
    assert!(said_goodbye(&notices(0)), "{seen}");
    assert!(when(&notices(1), "Engaged").is_some() && when(&notices(1), "Lost").is_none(), "{seen}");
    std::thread::sleep(Duration::from_millis(300));
    let (seen, _) = ended(second, "TERM");
    assert!(said_goodbye(&seen["notices"]), "{seen}");
}
