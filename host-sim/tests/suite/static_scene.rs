//! Servers and clients as processes over UDP on loopback, as a user runs them; and what is refused.

use std::net::UdpSocket;
use std::process::{Child, Stdio};
use std::time::Duration;

use serde_json::Value;

pub(crate) const TWO_ROOMS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/worlds/two-rooms.toml");
use crate::program::{Keys, cohold, free, report};

/// A server that ends with the test.
struct Served(Child);

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn serve(keys: &Keys, region: &str, address: &str) -> Served {
    let key = keys.file(0);
    let arguments =
        ["shared", "world", "serve", "--world", TWO_ROOMS, "--region", region, "--listen", address, "--key-file", &key];
    Served(cohold(&arguments).stderr(Stdio::null()).spawn().expect("cohold runs"))
}

fn visit(keys: &Keys, line: u32, arguments: &[&str]) -> Child {
    let (key, line) = (keys.file(line), line.to_string());
    let all = [&["shared", "world", "visit", "--json", "--key-file", &key, "--line", &line], arguments].concat();
    cohold(&all).spawn().expect("cohold runs")
}

#[test]
fn two_rooms_two_servers_two_clients() {
    let keys = Keys::new("two-rooms", 2);
    let (first, second) = (free(), free());
    let _servers = [serve(&keys, "1", &first), serve(&keys, "2", &second)];
    let (one, two) = (format!("1={first}"), format!("2={second}"));
    // One client stays in the first room, the other goes through the door, along the ledge, and back.
    let stays = visit(&keys, 1, &["--server", &one, "--seconds", "7"]);
    let strokes = ["--from-m=-0.2,-0.102", "--to-m=0.2,-0.102", "--stroke-s", "4", "--seconds", "4"];
    let goes = visit(&keys, 2, &[&["--server", &one, "--server", &two, "--radius-m", "0.2"], &strokes[..]].concat());
    let (goes, stays) = (report(goes), report(stays));
    assert_eq!(
        (&goes["ticks"], &goes["moves"], &goes["home"], &goes["corrupt"]),
        (&4_000.into(), &2.into(), &1.into(), &0.into())
    );
    assert!(goes["complete_after_s"].is_number() && goes["felt_ticks"].as_u64() > Some(100), "{goes}");
    // Within the radius of (−0.2, −0.102) are the ledge, the ball above, and at the end of the turn nothing else.
    assert!(goes["objects"].as_u64() >= Some(2), "{goes}");
    // The whole room: both walls that reach it, the two balls, the ledge; the strip is behind the margin.
    assert_eq!(stays["objects"], 5, "{stays}");
    assert_eq!(stays["world"], goes["world"]);
    // K = 1000 N/m, 1 cm deep at the end of a stroke.
    assert!((stays["largest_force_n"].as_f64().expect("a number") - 10.0).abs() < 0.2, "{stays}");
    assert_eq!(stays["others"], Value::Array(vec![]), "the other one left three seconds ago: {stays}");
    assert_eq!(goes["others"][0]["line"], 1, "{goes}");
}

#[test]
fn a_server_process_that_ends_takes_nothing_with_it() {
    let keys = Keys::new("gone", 1);
    let address = free();
    let server = serve(&keys, "1", &address);
    let visitor = visit(&keys, 1, &["--server", &format!("1={address}"), "--stroke-s", "0.5", "--seconds", "3"]);
    std::thread::sleep(Duration::from_millis(1_500));
    drop(server);
    let seen = report(visitor);
    assert!(seen["complete_after_s"].is_number(), "{seen}");
    assert_eq!(seen["objects"], 5);
    let (felt, alone) = (seen["felt_ticks"].as_u64(), seen["felt_alone_ticks"].as_u64());
    assert!(alone > Some(50) && felt > alone, "{seen}");
}

#[test]
fn two_clients_that_tell_each_other_straight() {
    let keys = Keys::new("friends", 2);
    let pair = keys.0.join("pair.key").display().to_string();
    assert!(cohold(&["key", "generate", &pair]).status().expect("cohold runs").success());
    let (one, two, nobody) = (free(), free(), format!("1={}", free()));
    let join = |line, arguments: &[&str]| visit(&keys, line, arguments);
    let visit = |line: u32, listen: &str, friend: String| {
        let place = format!("--from-m=0.{line},0.1");
        let at = format!("--to-m=0.{line},0.1");
        let own = ["--server", &nobody, "--listen", listen, "--seconds", "1.5", "--friend-key-file", &pair];
        join(line, &[&own[..], &["--friend", &friend, &place, &at]].concat())
    };
    let (first, second) = (visit(1, &one, format!("2={two}")), visit(2, &two, format!("1={one}")));
    for (line, child) in [(1, first), (2, second)] {
        let seen = report(child);
        // No server, and aware all the same.
        assert!(seen["complete_after_s"].is_null() && seen["objects"] == 0, "{seen}");
        assert_eq!(seen["others"][0]["line"], 3 - line, "{seen}");
        let x = seen["others"][0]["position_m"][0].as_f64().expect("a number");
        assert!((x - 0.1 * f64::from(3 - line)).abs() < 1e-6, "{seen}");
    }
}

#[test]
fn a_small_crowd_is_answered() {
    let output =
        cohold(&["shared", "world", "crowd", "--json", "--clients", "20", "--seconds", "0.5", "--warm-up-s", "1"])
            .arg("--beside")
            .output()
            .expect("runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).expect("one JSON document");
    let run = &document["runs"][0];
    assert_eq!((&run["clients"], &run["complete"]), (&20.into(), &20.into()), "{run}");
    let (packets, answered) = (run["packets"].as_u64().expect("a number"), run["answered"].as_u64().expect("a number"));
    // No speed is asked for: what was sent was answered, with the places of four others each.
    assert!(packets > 100 && answered * 10 >= packets * 9 && answered <= packets, "{run}");
    assert_eq!(run["sightings"].as_u64(), Some(4 * answered), "{run}");
    assert_eq!(run["server"]["clients"], 20);
    assert_eq!(run["server"]["counts"]["refused"], 0, "{run}");
    // The echo is asked for as much as the server was, and sealing takes some time.
    let (heard, echoed) = (run["server"]["answer"]["samples"].as_f64(), run["echo"]["pairs"].as_f64());
    assert!(echoed.zip(heard).is_some_and(|(echoed, heard)| (0.5..1.5).contains(&(echoed / heard))), "{run}");
    let sealing = ["here_ns", "ring_ns"].map(|by| document["sealing"][by].as_f64());
    assert!(sealing.iter().all(|ns| ns.is_some_and(|ns| (10.0..1e6).contains(&ns))), "{document}");
}

#[test]
fn worlds_as_documents() {
    let json = |arguments: &[&str]| -> Value {
        let output = cohold(arguments).output().expect("cohold runs");
        serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else")
    };
    let world = json(&["shared", "world", "show", "--json", "--world", TWO_ROOMS]);
    assert_eq!(
        (&world["objects"], &world["regions"], &world["bytes"]),
        (&7.into(), &2.into(), &(7 * 64 + 2 * 32).into())
    );
    let keys = json(&["shared", "world", "show", "--json"]);
    assert!(keys.as_array().is_some_and(|keys| keys.iter().any(|key| key["key"] == "strip.spring_n_per_m")));
}

#[track_caller]
fn refused(arguments: &[&str], names: &[&str]) {
    let output = cohold(arguments).output().expect("cohold runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty() && error.trim_end().lines().count() == 1, "{arguments:?}: {error}");
    for name in names {
        assert!(error.contains(name), "{arguments:?}: {name:?} is missing in: {error}");
    }
}

#[test]
fn what_is_wrong_is_one_line() {
    let keys = Keys::new("refused", 1);
    let (server, client) = (keys.file(0), keys.file(1));
    let world = keys.0.join("bad.toml").display().to_string();
    std::fs::write(&world, "[[wall]]\nid = 1\nthickness_m = 0\n").expect("a bad world");
    let serve = |rest: &[&str], names: &[&str]| {
        refused(
            &[&["shared", "world", "serve", "--listen", "127.0.0.1:0", "--key-file", &server], rest].concat(),
            names,
        );
    };
    serve(&["--scene", &world], &["bad.toml:3", "wall 1", "thickness_m = 0", "0.001 to 1000 m"]);
    serve(&["--scene", "/no/such.toml"], &["/no/such.toml"]);
    serve(&["--world", TWO_ROOMS, "--region", "3"], &["--region 3", "1 to 2"]);
    serve(&["--world", TWO_ROOMS, "--region", "0"], &["--region 0"]);
    serve(&["--world", TWO_ROOMS, "--lines", "5000"], &["5000", "4096"]);
    serve(&["--world", TWO_ROOMS, "--seconds", "0"], &["--seconds 0"]);
    let taken = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let address = taken.local_addr().expect("an address").to_string();
    refused(
        &["shared", "world", "serve", "--world", TWO_ROOMS, "--key-file", &server, "--listen", &address],
        &[&address, "listen"],
    );
    let visit = |rest: &[&str], names: &[&str]| {
        refused(&[&["shared", "world", "visit", "--key-file", &client, "--line", "1"], rest].concat(), names);
    };
    visit(&[], &["--server"]);
    visit(&["--server", "127.0.0.1:1"], &["NUMBER=ADDRESS:PORT"]);
    visit(&["--server", "0=127.0.0.1:1"], &["1 to 254"]);
    let one = ["--server", "1=127.0.0.1:1"];
    visit(&[&one[..], &["--radius-m", "0"]].concat(), &["--radius-m 0"]);
    visit(&[&one[..], &["--radius-m", "nan"]].concat(), &["--radius-m nan"]);
    visit(&[&one[..], &["--from-m", "1"]].concat(), &["X,Y"]);
    visit(&[&one[..], &["--to-m", "1,inf"]].concat(), &["X,Y", "1000"]);
    visit(
        &[&one[..], &["--friend", "1=127.0.0.1:1", "--friend-key-file", &client]].concat(),
        &["--friend 1", "own line"],
    );
    visit(&[&one[..], &["--friend", "2=127.0.0.1:1"]].concat(), &["--friend-key-file"]);
    refused(&["key", "generate", "/tmp/x", "--line", "0", "--of", &server], &["0", "from 1 to 4096"]);
    refused(&["key", "generate", &client, "--line", "1", "--of", &server], &[&client, "exists"]);
    refused(&["shared", "world", "crowd", "--clients", "0"], &["0", "from 1 to 4096"]);
    refused(&["shared", "world", "crowd", "--seconds=-1"], &["--seconds"]);
}
