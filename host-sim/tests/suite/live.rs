//! Two peers as two processes over loopback, for real: what they hold is what the same scene holds in memory.

use std::net::UdpSocket;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

use serde_json::Value;

/// Both users push toward each other and hold: what is measured does not hang on when each peer began.
const SCENE: [&str; 8] = [
    "coordination.comm=passive-mean",
    "coordination.ledger=true",
    "coordination.drift_correction=true",
    "coordination.decode=implicit",
    "object.integrator=semi-implicit",
    "coordination.stiffness_n_per_m=1000",
    "user.1.push_n=1",
    "user.2.push_n=1",
];
const SECONDS: &str = "4";

fn host_sim(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.args(arguments);
    command
}

fn scene() -> Vec<&'static str> {
    SCENE.iter().flat_map(|setting| ["--set", setting]).collect()
}

fn json(command: &mut Command) -> Value {
    let output = command.output().expect("host-sim runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else")
}

/// Addresses that were free a moment ago.
fn addresses<const N: usize>() -> [String; N] {
    let sockets = [(); N].map(|()| UdpSocket::bind("127.0.0.1:0").expect("a socket on loopback"));
    sockets.map(|socket| socket.local_addr().expect("its address").to_string())
}

/// A folder of the test's own, with a key in it.
fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    assert!(
        host_sim(&["key", "generate"]).arg(folder.join("key")).stdout(Stdio::null()).status().expect("runs").success()
    );
    folder
}

fn peer(folder: &std::path::Path, number: &str, listen: &str, connect: &str) -> Child {
    host_sim(&["peer", "--json", "--number", number, "--listen", listen, "--connect", connect])
        .args(["--seconds", SECONDS, "--key-file"])
        .arg(folder.join("key"))
        .args(scene())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("host-sim runs")
}

fn report(peer: Child) -> Value {
    let output = peer.wait_with_output().expect("it ends");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else")
}

/// The report of a live peer beside that of the run in memory.
fn compare(live: &Value, memory: &Value) {
    let number = |document: &Value, key: &str| document[key].as_f64().unwrap_or_else(|| panic!("{key} in {document}"));
    assert_eq!(live["fault"], Value::Null, "{live}");
    assert_eq!(number(live, "ticks"), 4000.0, "{live}");
    let (real, wanted) = (number(live, "decoded_discrepancy_mm"), number(memory, "decoded_discrepancy_mm"));
    assert!((real / wanted - 1.0).abs() < 0.05, "{real} mm, {wanted} mm in memory");
    // F_T balances the push of 1 N.
    assert!((number(live, "coordination_force_n").abs() - 1.0).abs() < 0.05, "{live}");
    // A reply waits for a beat at either end. Beats that are never late make every round trip the same; a busy machine does not.
    assert!(number(live, "round_trip_us") > 0.0 && number(live, "jitter_us") < 1e5, "{live}");
    // Both read the same machine's clock, from when each began: within the seconds that this takes.
    assert!(number(live, "clock_offset_us").abs() < 60e6 && number(live, "clock_drift_ppm").is_finite(), "{live}");
    // The other one armed, and feels the same force the other way round.
    let other = &live["other"];
    assert_eq!((number(other, "mode"), number(other, "fault")), (1.0, 0.0), "{live}");
    let pull = number(other, "coordination_force_n") * number(live, "coordination_force_n").signum();
    assert!((pull + 1.0).abs() < 0.1 && number(other, "ticks") >= 3000.0, "{live}");
    // One tick a millisecond since it was started, none skipped and none too many; the latest is as late as the missed ones say.
    let kept = &live["punctuality"];
    let last_s = live["notices"].as_array().and_then(|notices| notices.last()?[0].as_f64()).expect("notices");
    assert!((4000.0..1000.0 * (last_s + 4.0) + 2000.0).contains(&number(kept, "beats")), "{live}");
    assert_eq!(number(kept, "missed") > 0.0, number(kept, "worst_us") > 1000.0, "{live}");
    assert_eq!(kept["realtime_priority"].as_bool(), Some(may_run_in_real_time()), "{live}");
    let told: Vec<&str> =
        live["notices"].as_array().expect("a list").iter().filter_map(|one| one[1].as_str()).collect();
    assert!(told.contains(&"Joined") && told.contains(&"Engaged"), "{told:?}");
}

/// Whether this user's threads get a real-time priority.
fn may_run_in_real_time() -> bool {
    use thread_priority::{RealtimeThreadSchedulePolicy::Fifo, ThreadSchedulePolicy::Realtime};
    let priority = thread_priority::ThreadPriority::Crossplatform(50.try_into().expect("a priority"));
    let ask = move || {
        thread_priority::set_thread_priority_and_policy(thread_priority::thread_native_id(), priority, Realtime(Fifo))
    };
    std::thread::spawn(move || ask().is_ok()).join().expect("a thread")
}

#[test]
fn two_processes_hold_what_the_run_in_memory_holds() {
    let folder = folder("two-processes");
    let [one, two] = addresses();
    let peers = [peer(&folder, "1", &one, &two), peer(&folder, "2", &two, &one)];
    // Loopback takes no time, and what came is taken at the end of a packet period.
    let mut memory = host_sim(&["cooperate", "--json", "--seconds", SECONDS]);
    let memory = json(memory.args(scene()).args(["--set", "network.one_way_delay_packets=0"]));
    for live in peers.map(report) {
        compare(&live, &memory);
        // Nothing is lost on loopback but what a late start misses.
        let number = |key: &str| live[key].as_f64().unwrap_or(f64::NAN);
        assert_eq!(number("datagrams_refused"), 0.0, "{live}");
        assert!(number("datagrams_taken") > 400.0 && number("datagrams_missing") <= 8.0, "{live}");
    }
}

/// An end of version 1 of the wire says hello all the time: why it is nobody is told, with both versions.
#[test]
fn an_end_of_another_version_is_named() {
    let folder = folder("another-version");
    let old = UdpSocket::bind("127.0.0.1:0").expect("a socket on loopback");
    let [own] = addresses();
    let mut waiting = host_sim(&["peer", "--number", "1", "--listen", &own, "--patience-s", "1", "--connect"])
        .arg(old.local_addr().expect("its address").to_string())
        .arg("--key-file")
        .arg(folder.join("key"))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("host-sim runs");
    let mut hello = [0; 200];
    hello[..4].copy_from_slice(&[1, 1, 2, 1]);
    while waiting.try_wait().expect("a process").is_none() {
        // Until it listens, nobody is there.
        let _ = old.send_to(&hello, &own);
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let said = waiting.wait_with_output().expect("it has ended");
    let said = String::from_utf8_lossy(&said.stderr).into_owned();
    assert!(
        said.contains(&format!(
            "{} is not understood: version 1 is spoken here, this end speaks 2",
            old.local_addr().expect("its address")
        )),
        "{said}"
    );
}

#[test]
fn a_recorded_network_between_two_processes_is_the_one_in_memory() {
    let folder = folder("relay");
    let trace = folder.join("trace.csv").display().to_string();
    let network = ["network.loss=0.1", "network.jitter=uniform", "network.jitter_s=0.006", "network.seed=3"];
    let network = network.iter().flat_map(|setting| ["--set", setting]);
    let recorded =
        host_sim(&["network", "trace", "--seconds", "5"]).args(network).arg(&trace).stdout(Stdio::null()).status();
    assert!(recorded.expect("host-sim runs").success());

    let [one, two, for_one, for_two] = addresses();
    let relay =
        host_sim(&["network", "relay", "--json", "--seconds", "6", "--listen-1", &for_one, "--listen-2", &for_two])
            .args(["--peer-1", &one, "--peer-2", &two, "--trace", &trace])
            .stdout(Stdio::piped())
            .spawn()
            .expect("host-sim runs");
    let peers = [peer(&folder, "1", &one, &for_one), peer(&folder, "2", &two, &for_two)];
    let setting = format!("network.trace={trace}");
    let mut memory = host_sim(&["cooperate", "--json", "--seconds", SECONDS]);
    let memory = json(memory.args(scene()).args(["--set", &setting]));
    let lives = peers.map(report);
    let relayed = report(relay);
    for live in &lives {
        compare(live, &memory);
        // The round trip varies by as much as the two ways do together: 2 ms on average.
        assert!(live["jitter_us"].as_f64().is_some_and(|us| (300.0..8_000.0).contains(&us)), "{live}");
        // A packet of delay each way.
        assert!(live["round_trip_us"].as_f64().is_some_and(|us| us >= 16_000.0), "{live}");
        assert!(live["datagrams_missing"].as_f64().is_some_and(|missing| missing > 20.0), "{live}");
    }
    assert_eq!(relayed["strangers"], 0, "{relayed}");
    for way in relayed["ways"].as_array().expect("two ways") {
        let count = |key: &str| way[key].as_f64().unwrap_or(f64::NAN);
        assert!(count("taken") > 500.0 && count("lost") > 0.05 * count("taken"), "{relayed}");
        assert!(count("sent") + count("lost") <= count("taken") + count("corrupt"), "{relayed}");
    }
}

/// Told other parameters, whoever begins: both say so, and which table.
#[test]
fn a_mismatch_of_settings_is_told_at_both_ends() {
    let folder = folder("mismatch");
    for wait_ms in [0, 400] {
        let [one, two] = addresses();
        let peer = |number: &str, listen: &str, connect: &str, more: &[&str]| {
            host_sim(&["peer", "--number", number, "--listen", listen, "--connect", connect, "--patience-s", "10"])
                .arg("--key-file")
                .arg(folder.join("key"))
                .args(more)
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .expect("host-sim runs")
        };
        let first = peer("1", &one, &two, &[]);
        std::thread::sleep(std::time::Duration::from_millis(wait_ms));
        let second = peer("2", &two, &one, &["--set", "object.mass_kg=0.5"]);
        for (peer, other) in [(first, &two), (second, &one)] {
            let output = peer.wait_with_output().expect("it ends");
            let error = String::from_utf8_lossy(&output.stderr);
            let wanted = format!("{other} was told other parameters: table [object] of the scene differs");
            assert!(output.status.code() == Some(2) && error.contains(&wanted), "{error}");
        }
    }
}

/// Two that both take themselves for peer 1, and two with a key each: neither says that nobody answered.
#[test]
fn two_of_one_number_and_two_with_different_keys_are_told_apart() {
    let (folder, other) = (folder("one-number"), folder("another-key"));
    for (numbers, keys, wanted) in [
        (["1", "1"], [&folder, &folder], "has the number of this end, or is this end"),
        (["1", "2"], [&folder, &other], "holds another key: give both ends of a line the same one"),
    ] {
        let [one, two] = addresses();
        let peer = |at: usize, listen: &str, connect: &str| {
            host_sim(&[
                "peer",
                "--number",
                numbers[at],
                "--listen",
                listen,
                "--connect",
                connect,
                "--patience-s",
                "2",
                "--quiet",
            ])
            .arg("--key-file")
            .arg(keys[at].join("key"))
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("host-sim runs")
        };
        for (peer, other) in [(peer(0, &one, &two), &two), (peer(1, &two, &one), &one)] {
            let output = peer.wait_with_output().expect("it ends");
            let error = String::from_utf8_lossy(&output.stderr);
            let said = error.contains(&format!("{other} {wanted}")) && error.trim_end().lines().count() == 1;
            assert!(output.status.code() == Some(2) && said, "{error}");
        }
    }
}
