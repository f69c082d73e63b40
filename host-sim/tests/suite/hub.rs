//! Processes over UDP on loopback, as a user runs them.

use std::process::Child;
use std::time::Duration;

use serde_json::Value;

use crate::program::{Keys, cohold, free, report};

/// The peer on a line, whose user does this.
fn peer(keys: &Keys, line: u32, hub: &str, user: &[&str], duration_s: &str) -> Child {
    let (number, key) = (if line % 2 == 1 { "1" } else { "2" }, keys.file(line));
    cohold(&["peer", "--json", "--scene", "hub", "--number", number, "--listen", "127.0.0.1:0"])
        .args(["--connect", hub, "--key-file", &key, "--seconds", duration_s])
        .args(user.iter().flat_map(|setting| ["--set", setting]))
        .spawn()
        .expect("cohold runs")
}

fn number(document: &Value, key: &str) -> f64 {
    document[key].as_f64().unwrap_or_else(|| panic!("{key} in {document}"))
}

/// Two push against each other and swing a little, a third holds on; it is killed in the middle and comes back.
#[test]
fn three_processes_hold_one_object_and_one_of_them_restarts() {
    let keys = Keys::new("three", 3);
    let address = free();
    let hub =
        cohold(&["shared", "hub", "--json", "--users", "3", "--listen", &address, "--seconds", "7", "--key-file"])
            .arg(keys.file(0))
            .spawn()
            .expect("cohold runs");
    let first = peer(&keys, 1, &address, &["user.1.push_n=1", "user.1.sine_n=0.1"], "6");
    let second = peer(&keys, 2, &address, &["user.2.push_n=1"], "6");
    let mut third = peer(&keys, 3, &address, &[], "60");
    std::thread::sleep(Duration::from_millis(2_500));
    third.kill().expect("it is running");
    let _ = third.wait();
    let third = peer(&keys, 3, &address, &[], "2");
    let peers = [first, second, third].map(report);
    let hub = report(hub);

    for (peer, wanted_n) in peers.iter().zip([-1.0, 1.0, 0.0]) {
        assert_eq!(peer["fault"], Value::Null, "{peer}");
        // The coordination force holds against the push; what is left is the object's motion.
        assert!((number(peer, "coordination_force_n") - wanted_n).abs() < 0.25, "{peer}");
        assert!(number(peer, "decoded_discrepancy_mm") < 1.0, "{peer}");
        assert_eq!(peer["other"]["state"], "armed", "{peer}");
    }
    // Alone, 1 N moves a device and its copy by metres.
    assert!(number(&hub, "apart_mm") < 50.0 && number(&hub, "object_mm").abs() < 50.0, "{hub}");
    assert!(number(&hub, "energy_made_mj") <= 1e-6, "{hub}");
    assert!(number(&hub, "packets") == 875.0, "{hub}");
    let lines = hub["lines"].as_array().expect("lines");
    let lives: Vec<f64> = lines.iter().map(|line| number(line, "lives")).collect();
    assert_eq!(lives, [1.0, 1.0, 2.0], "{hub}");
    for line in lines {
        assert!(number(line, "sent_j") > 0.0 && number(line, "taken_j") <= number(line, "put_in_j") + 1e-12, "{line}");
        // No more came out at the peer than the hub gave to its line; the peer said so a little earlier.
        assert!(number(&line["said"], "energy_received_j") <= number(line, "sent_j") + 1e-6, "{line}");
        assert!(number(line, "datagrams_taken") > 200.0 && number(line, "round_trip_us") > 0.0, "{line}");
    }
    let told: Vec<&str> =
        lines[2]["notices"].as_array().expect("a list").iter().filter_map(|one| one["notice"].as_str()).collect();
    let engaged = told.iter().filter(|notice| **notice == "Engaged").count();
    assert!(engaged >= 2 && told.contains(&"Disengaged"), "{told:?}");
}

/// Two axes: one pushes along the first, one along the second, and both copies stand between both arms, ΣF/(2·k) along each; who shares one
/// axis is refused, and told why at both ends.
#[test]
fn processes_around_a_hub_share_a_plane() {
    let keys = Keys::new("plane", 3);
    let address = free();
    let recording = keys.0.join("hub.mcap");
    let plane = ["axis.count=2", "axis.shared=2"];
    let hub =
        cohold(&["shared", "hub", "--json", "--users", "3", "--listen", &address, "--seconds", "3", "--key-file"])
            .args([&keys.file(0), "--record", &recording.display().to_string(), "--patience-s", "20"])
            .args(plane.iter().flat_map(|setting| ["--set", setting]))
            .spawn()
            .expect("cohold runs");
    let (status, error) = ended(peer(&keys, 3, &address, &[], "1"));
    // A peer of one axis has no such table: the hub has its name.
    assert!(
        status == Some(2) && error.contains("told other parameters: table [a table that this peer does not"),
        "{error}"
    );
    let push = |line: u32, direction_rad: &str| {
        let of_user = ["push_n=1", "arm_stiffness_n_per_m=200", "arm_damping_n_s_per_m=8", direction_rad];
        let own = of_user.map(|setting| format!("user.{line}.{setting}"));
        let settings: Vec<&str> = plane.into_iter().chain(own.iter().map(String::as_str)).collect();
        peer(&keys, line, &address, &settings, "3")
    };
    let peers = [push(1, "direction_rad=0"), push(2, "direction_rad=1.570796")].map(report);
    let output = hub.wait_with_output().expect("it ends");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    assert!(error.lines().any(|line| line.contains("line 3: ") && line.contains("table [axis] differs")), "{error}");
    let hub: Value = serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else");
    assert!(hub["lines"][2]["refused"].as_str().is_some_and(|why| why.contains("[axis]")), "{hub}");
    for live in &peers {
        assert!(live["fault"] == Value::Null && number(live, "decoded_discrepancy_mm") < 1.0, "{live}");
    }
    let table = recording.with_extension("csv");
    let converted = cohold(&["recording", "convert", &recording.display().to_string()]).arg(&table).output();
    assert!(converted.expect("cohold runs").status.success());
    let axes = hub["axes"].as_array().expect("axes");
    assert_eq!(axes.iter().map(|axis| &axis["axis"]).collect::<Vec<_>>(), ["x", "y"], "{hub}");
    // User 2 sits at the other end, and pushes the other way.
    for (axis, (ending, wanted_mm)) in axes.iter().zip([("", 2.5), ("-ticks-y", -2.5)]) {
        let (object_mm, made_mj) = (number(axis, "object_mm"), number(axis, "energy_made_mj"));
        assert!((object_mm - wanted_mm).abs() < 0.5 && made_mj <= 1e-6, "{hub}");
        let name = format!("{}{ending}.csv", table.file_stem().expect("a name").display());
        let text = std::fs::read_to_string(table.with_file_name(name)).expect("a table");
        let (names, last) = (text.lines().next().expect("names"), text.lines().last().expect("rows"));
        let at = names.split(',').position(|name| name == "object_m").expect("a column");
        let recorded_m: f64 = last.split(',').nth(at).and_then(|text| text.parse().ok()).expect("a number");
        assert!((1e3 * recorded_m - object_mm).abs() < 1e-6, "{recorded_m} m: {axis}");
    }
    assert_eq!(axes[0]["object_mm"], hub["object_mm"], "{hub}");
}

#[test]
fn what_is_wrong_is_said_in_one_line() {
    let keys = Keys::new("wrong", 1);
    let (key, address) = (keys.file(0), free());
    let hub = ["shared", "hub", "--listen", &address, "--key-file", &key];
    for (arguments, names) in [
        (&["--users", "1"][..], "from 2 to 16"),
        (&["--users", "17"], "from 2 to 16"),
        (&["--users", "-1"], "from 2 to 16"),
        (&["--users", "2", "--seconds", "0"], "--seconds 0"),
        (&["--users", "2", "--patience-s", "-1"], "--patience-s -1"),
        (&["--users", "2", "--set", "coordination.comm=power"], "coordination.comm"),
        (&["--users", "2", "--set", "coordination.ledger=false"], "coordination.drift_correction"),
        (&["--users", "2", "--scene", "paper-5.2-passive-wave-16ms"], "coordination.ledger = false"),
        (
            &["--users", "3", "--patience-s", "0.1"],
            "0 of 3 peers came within 0.1 s; nobody on line 1 (peer number 1), 2 (peer number 2), 3 (peer number 1)",
        ),
    ] {
        let output = cohold(&[&hub[..], arguments].concat()).output().expect("cohold runs");
        let error = String::from_utf8_lossy(&output.stderr);
        // What it does is said first, on the same stream.
        let said: Vec<&str> = error.trim_end().lines().filter(|line| !line.starts_with("hub for")).collect();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty() && error.contains(names) && said.len() == 1, "{arguments:?}: {error}");
    }
    // A peer with other settings.
    let mut waiting = cohold(&[&hub[..], &["--users", "2"]].concat()).spawn().expect("cohold runs");
    let other = cohold(&["peer", "--scene", "hub", "--set", "object.mass_kg=0.5", "--number", "1"])
        .args(["--listen", "127.0.0.1:0", "--connect", &address, "--key-file", &keys.file(1)])
        .output()
        .expect("cohold runs");
    let _ = waiting.kill();
    let _ = waiting.wait();
    let error = String::from_utf8_lossy(&other.stderr);
    assert!(other.status.code() == Some(2) && error.contains("table [object]"), "{error}");
}

/// What a program that ended said on standard error.
fn ended(child: Child) -> (Option<i32>, String) {
    let output = child.wait_with_output().expect("it ends");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// The third of three was configured with another mass: it is refused and learns which table, the hub says so as well, and the other two
/// hold their object as if it were not there.
#[test]
fn one_client_cannot_stop_a_hub() {
    let keys = Keys::new("stop", 3);
    let address = free();
    let hub =
        cohold(&["shared", "hub", "--json", "--users", "3", "--listen", &address, "--seconds", "3", "--key-file"])
            .arg(keys.file(0))
            .args(["--patience-s", "20"])
            .spawn()
            .expect("cohold runs");
    let third = peer(&keys, 3, &address, &["object.mass_kg=0.5"], "1");
    let (status, error) = ended(third);
    assert!(status == Some(2) && error.contains("told other parameters: table [object]"), "{error}");
    let first = peer(&keys, 1, &address, &["user.1.push_n=1"], "2");
    let second = peer(&keys, 2, &address, &["user.2.push_n=1"], "2");
    // In the middle of it, once more, and junk from a socket of nobody's.
    std::thread::sleep(Duration::from_millis(700));
    let third = peer(&keys, 3, &address, &["object.mass_kg=0.5"], "1");
    let junk = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket on loopback");
    for count in 0..2_000_usize {
        let _ = junk.send_to(&[count as u8; 200][..count % 200], &address);
    }
    assert_eq!(ended(third).0, Some(2));
    for held in [first, second].map(report) {
        assert!(held["fault"] == Value::Null && number(&held, "decoded_discrepancy_mm") < 1.0, "{held}");
        assert!((number(&held, "coordination_force_n").abs() - 1.0).abs() < 0.25, "{held}");
    }
    let output = hub.wait_with_output().expect("it ends");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    let hub: Value = serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else");
    let said = |text: &str| error.lines().filter(|line| line.contains(text)).count();
    assert!(said("line 3: ") >= 1 && said("told other parameters: table [object] differs") >= 1, "{error}");
    assert!(said("begins without line 3 (peer number 1: ") == 1, "{error}");
    assert!(hub["lines"][2]["refused"].as_str().is_some_and(|why| why.contains("[object]")), "{hub}");
    // Two thousand datagrams of junk are no two thousand lines, beside a line a second and what happens to the three lines.
    assert!(number(&hub, "datagrams_refused") > 100.0 && error.lines().count() < 32, "{error}{hub}");
}

/// Another key, another number, the wrong family of addresses, and itself: said at both ends, each in one line.
#[test]
fn who_is_wrong_is_said_at_both_ends() {
    let (keys, others) = (Keys::new("told", 2), Keys::new("told-others", 1));
    let address = free();
    let hub = cohold(&["shared", "hub", "--users", "2", "--listen", &address, "--key-file", &keys.file(0)])
        .args(["--patience-s", "12"])
        .spawn()
        .expect("cohold runs");
    let call = |number: &str, key: &str, to: &str| {
        let peer = cohold(&["peer", "--scene", "hub", "--number", number, "--listen", "127.0.0.1:0"])
            .args(["--connect", to, "--key-file", key, "--patience-s", "2", "--quiet"])
            .spawn();
        let (status, error) = ended(peer.expect("cohold runs"));
        assert!(status == Some(2) && error.trim_end().lines().count() == 1, "{error}");
        error
    };
    let error = call("1", &others.file(1), &address);
    assert!(error.contains(&format!("{address} holds another key")), "{error}");
    let error = call("2", &keys.file(1), &address);
    assert!(error.contains(&format!("{address} has the number of this end")), "{error}");
    let error = call("1", &keys.file(1), "[::1]:7700");
    assert!(error.contains("[::1]:7700 cannot be reached from 127.0.0.1:") && error.contains("IPv6"), "{error}");
    let own = cohold(&["peer", "--scene", "hub", "--number", "1", "--listen", "0.0.0.0:7765"])
        .args(["--connect", "127.0.0.1:7765", "--key-file", &keys.file(1), "--patience-s", "2"])
        .spawn();
    let (status, error) = ended(own.expect("cohold runs"));
    assert!(status == Some(2) && error.contains("127.0.0.1:7765 is where this end listens itself"), "{error}");
    let (_, error) = ended(hub);
    assert!(error.contains("on no line: ") && error.contains("holds another key: give both ends"), "{error}");
    assert!(error.contains("line 1: ") && error.contains("is peer 2: on this line it must be 1"), "{error}");
}
