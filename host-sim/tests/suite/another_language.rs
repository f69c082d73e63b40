//! A program in another language, written from protocol/FORMAT.md alone, is the other end of what a user runs:
//! protocol/tests/inside/peer.py, which needs Python 3 and nothing else.

use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};

use crate::program::{Keys, free, host_sim, report};
use crate::static_scene::TWO_ROOMS;

/// The program in Python as number `from` of this line, from one address to another.
fn python(key: &str, [from, to]: [u8; 2], line: u32, [listen, connect]: [&str; 2], asks: bool) -> Child {
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("../protocol/tests/inside/peer.py");
    let port = |address: &str| address.rsplit(':').next().and_then(|port| port.parse::<u16>().ok()).expect("a port");
    let told = json!({
        "key": key, "from": from, "to": to, "line": line, "listen": port(listen), "connect": port(connect), "seconds": 2.5, "ask": asks,
    });
    let mut command = Command::new("python3");
    command.arg(&program).arg(told.to_string()).env("PYTHONDONTWRITEBYTECODE", "1");
    let started = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    started.unwrap_or_else(|cause| panic!("this test needs Python 3, and `python3` does not start: {cause}"))
}

fn number(document: &Value, key: &str) -> f64 {
    document[key].as_f64().unwrap_or_else(|| panic!("{key} in {document}"))
}

/// What was reported of an end, in order.
fn notices(of: &Value) -> Vec<&str> {
    of["notices"].as_array().expect("a list").iter().filter_map(|one| one[1].as_str()).collect()
}

/// Flow both ways for a while, and a goodbye.
fn was_there(of: &Value, python: &Value) {
    assert_eq!(python["confirmed"], true, "{python}");
    assert!(number(python, "flows") > 50.0 && number(python, "replies") > 10.0, "{python}");
    let told = notices(of);
    for notice in ["Joined", "Engaged", "Disengaged", "Lost"] {
        assert!(told.contains(&notice), "{notice} is missing in {of}");
    }
    assert!(number(of, "datagrams_taken") > 100.0, "{of}");
}

#[test]
fn a_peer_meets_it() {
    let (keys, own, other) = (Keys::new("python-peer", 0), free(), free());
    let key = keys.file(0);
    // A packet every 8 ms, which Python keeps up with.
    let peer = host_sim(&["peer", "--json", "--number", "1", "--listen", &own, "--connect", &other, "--seconds", "8"])
        .args(["--scene", "hub", "--key-file", &key])
        .spawn()
        .expect("host-sim runs");
    let python = report(python(&key, [2, 1], 0, [&other, &own], false));
    was_there(&report(peer), &python);
}

#[test]
fn a_hub_meets_two_of_it() {
    let (keys, hub, others) = (Keys::new("python-hub", 2), free(), [free(), free()]);
    let running =
        host_sim(&["hub", "--json", "--users", "2", "--listen", &hub, "--seconds", "8", "--key-file", &keys.file(0)])
            .spawn()
            .expect("host-sim runs");
    let one = python(&keys.file(1), [1, 2], 0, [&others[0], &hub], false);
    let two = python(&keys.file(2), [2, 1], 0, [&others[1], &hub], false);
    let (ends, hub) = ([one, two].map(report), report(running));
    (0..2).for_each(|line| was_there(&hub["lines"][line], &ends[line]));
}

#[test]
fn a_server_gives_it_the_whole_world() {
    let (keys, address, other) = (Keys::new("python-server", 3), free(), free());
    let server = ["shared", "world", "serve", "--json", "--world", TWO_ROOMS, "--listen", &address, "--seconds", "8"];
    let running = host_sim(&server).args(["--key-file", &keys.file(0)]).spawn().expect("host-sim runs");
    let (python, server) = (report(python(&keys.file(3), [0, 1], 3, [&other, &address], true)), report(running));
    assert_eq!(python["confirmed"], true, "{python}");
    assert_eq!(
        (&python["objects"], &python["computed"], &python["world"]),
        (&json!(7), &server["world"], &server["world"])
    );
    let counts = &server["counts"];
    assert_eq!((number(&server, "clients"), number(counts, "refused")), (1.0, 0.0), "{server}");
    assert!(number(counts, "asks") > 50.0 && number(counts, "parts") > 50.0, "{server}");
}
