//! `cohold devices`: what is attached, and the ten steps, with what they have to find.

use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpListener};
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use cohold_devices::emulators::hand::{Hand, STEP_S};
use cohold_devices::emulators::{Emulated as _, inverse3, motors};
use serde_json::Value;

use super::emulated::{self, fdcanusb, haply};
use crate::program::built::built;
use crate::program::{Keys, cohold, free, report};

const DISTANCE_M: f64 = 0.02;

/// Goes through the steps; the hand does what it is asked to. Whether all passed, the report, and what was said.
pub(crate) fn steps(flags: &[String], more: &[&str], reach: impl Fn(f64)) -> (bool, Value, String) {
    steps_of(cohold(&[]), flags, more, reach)
}

/// As [`steps`], of this program.
fn steps_of(mut command: Command, flags: &[String], more: &[&str], reach: impl Fn(f64)) -> (bool, Value, String) {
    command.args(["devices", "--json", "--distance-m", &DISTANCE_M.to_string(), "--device-silent-s", "0.2"]);
    let mut child = command.args(flags).args(more).stdin(Stdio::piped()).spawn().expect("cohold runs");
    let (mut answers, asked) = (child.stdin.take().expect("kept"), child.stderr.take().expect("kept"));
    let mut said = String::new();
    for line in BufReader::new(asked).lines().map_while(Result::ok) {
        if line.contains("then press Enter") {
            if line.contains("move the hand") {
                reach(DISTANCE_M);
                // It takes a second, and then comes to rest.
                std::thread::sleep(Duration::from_millis(1_500));
            }
            let _ = answers.write_all(b"\n");
        }
        said += &(line + "\n");
    }
    let output = child.wait_with_output().expect("it ends");
    (output.status.success(), serde_json::from_slice(&output.stdout).unwrap_or_default(), said)
}

/// Every device passes, and leaves settings that a scene takes.
#[test]
fn a_good_device_passes_ten_steps() {
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("steps.toml");
    let named = file.display().to_string();
    for bus in [fdcanusb(), emulated::mit("steps-mit", 0.1)] {
        let _ = std::fs::remove_file(&file);
        let flags = bus.words();
        let (passed, told, said) =
            steps(&flags, &["--scene", "plane", "--settings", &named], |by_m| bus.world().hand.reach([by_m, 0.0]));
        println!("{said}");
        assert!(passed && told["passed"].as_array().map(Vec::len) == Some(10), "{said}\n{told}");
        // With the answers of a busy machine it may be unstable, which its exit status says; it runs all the same.
        let ran = cohold(&["cooperate", "--json", "--scene", &named, "--seconds", "0.1"]).output();
        let ran: Value = serde_json::from_slice(&ran.expect("cohold runs").stdout).expect("one JSON document");
        assert!(ran["ticks"].as_f64() == Some(100.0), "{ran}");
    }
    let haply = haply(0.0);
    let flags = ["--device".to_owned(), format!("haply:{}", haply.at)];
    let more = ["--device-lets-go-s", "0.02", "--scene", "space"];
    let (passed, _, said) = steps(&flags, &more, |by_m| haply.world().reach([by_m, 0.0, 0.0]));
    println!("{said}");
    assert!(passed, "{said}");
}

/// What is wrong is found by the step that is to find it, and none comes after it.
#[test]
fn what_is_wrong_with_a_device_is_found_by_its_step() {
    for (fault, words) in [
        (motors::Fault::NoWatchdog, "step 6, watchdog: "),
        (motors::Fault::WrongSign, "step 7, sign: pushed toward +x it went toward −x"),
    ] {
        let bus = fdcanusb();
        bus.world().fail(fault);
        let (passed, _, said) = steps(&bus.words(), &["--scene", "plane"], |by_m| bus.world().hand.reach([by_m, 0.0]));
        assert!(!passed && said.contains(words), "{fault:?}: {said}");
        assert!(!said.contains("hold: passed"), "{fault:?}: {said}");
        bus.world().fail(motors::Fault::None);
    }
    for (fault, words) in [
        (inverse3::Fault::NoWatchdog, "step 6, watchdog: "),
        (inverse3::Fault::WrongSign, "step 7, sign: pushed toward +x it went toward −x"),
    ] {
        let haply = haply(0.0);
        haply.world().fail(fault);
        let flags = ["--device".to_owned(), format!("haply:{}", haply.at)];
        let more = ["--device-lets-go-s", "0.02", "--scene", "space"];
        let (passed, _, said) = steps(&flags, &more, |by_m| haply.world().reach([by_m, 0.0, 0.0]));
        assert!(!passed && said.contains(words), "{fault:?}: {said}");
    }
    // Moved the other way, its x is turned.
    let bus = fdcanusb();
    let (passed, _, said) = steps(&bus.words(), &["--scene", "plane"], |by_m| bus.world().hand.reach([-by_m, 0.0]));
    assert!(!passed && said.contains("step 4, scale: ") && said.contains("points the other way"), "{said}");
    assert!(bus.world().asked.iter().all(|(_, torques)| *torques == [0.0; 2]), "no force before the watchdog's step");
}

/// What is attached is listed by what it says of itself.
#[test]
fn what_is_attached_is_listed() {
    let (bus, haply) = (fdcanusb(), haply(0.0));
    let (at, service) = (bus.at.display().to_string(), haply.at.to_string());
    let told = cohold(&["devices", "--json", "--look-at", &at, "--look-at", &service]).output().expect("cohold runs");
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    for words in [
        format!("moteus:{at}"),
        "moteus 1 (24.0 V, 31 °C), moteus 2".to_owned(),
        format!("haply:{service}"),
        "Inverse3 049D".to_owned(),
    ] {
        assert!(told.contains(&words), "{words}: {told}");
    }
}

/// For so long a force of the example's handle stands without a line, s.
const HANDLE_HOLDS_S: f64 = 0.02;

/// The handle that `examples/device` is for, and a hand on it, until the test ends.
fn handle() -> (SocketAddr, Arc<Mutex<Hand<1>>>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a socket on loopback");
    let at = listener.local_addr().expect("its address");
    let hand = Arc::new(Mutex::new(Hand::new(0.0)));
    let held = hand.clone();
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let _ = stream.set_nodelay(true);
            let mut answers = stream.try_clone().expect("the line");
            let (mut force_n, mut until_s) = (0.0, 0.0);
            for line in BufReader::new(stream).lines().map_while(Result::ok) {
                let mut hand = held.lock().expect("the test goes on");
                let now_s = hand.time_s();
                while hand.now_s < now_s {
                    force_n = if hand.now_s + STEP_S < until_s { force_n } else { 0.0 };
                    hand.step([force_n]);
                }
                if let Ok(force) = line.parse() {
                    (force_n, until_s) = (force, now_s + HANDLE_HOLDS_S);
                }
                let _ = writeln!(answers, "{} {} {force_n}", hand.position_m[0], hand.velocity_m_per_s[0]);
            }
        }
    });
    (at, hand)
}

/// A device from a crate outside passes the ten steps, and a peer holds an object with it.
#[test]
fn a_device_from_outside_is_tried_and_driven() {
    let (program, (at, hand)) = (built().join("device"), handle());
    let outside = || {
        let mut command = Command::new(&program);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    };
    let flags = ["--device".to_owned(), format!("handle:{at}")];
    let reach = |to_m| hand.lock().expect("the handle goes on").reach([to_m]);
    let (passed, told, said) = steps_of(outside(), &flags, &[], reach);
    println!("{said}");
    assert!(passed && told["passed"].as_array().map(Vec::len) == Some(10), "{said}");

    let (keys, one, two) = (Keys::new("devices-outside", 0), free(), free());
    let key = keys.file(0);
    let args = |number, listen, connect| {
        let ends = ["--number", number, "--listen", listen, "--connect", connect];
        let all = [&["peer", "--json", "--key-file", &key, "--seconds", "4"][..], &ends].concat();
        all.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let first = outside().args(args("1", &one, &two)).args(&flags).args(["--device-silent-s", "0.2"]).spawn();
    let second = cohold(&[]).args(args("2", &two, &one)).args(["--set", "user.2.push_n=0"]).spawn();
    let [first, second] = [first, second].map(|child| report(child.expect("it runs")));
    for live in [&first, &second] {
        assert_eq!((live["fault"].clone(), live["ticks"].as_f64()), (Value::Null, Some(4_000.0)), "{live}");
    }
    assert!(first["device"]["round_trip"]["samples"].as_f64().is_some_and(|samples| samples > 1_000.0), "{first}");
    // Nobody else knows it.
    let unknown = cohold(&["devices"]).args(&flags).output().expect("cohold runs");
    assert!(
        !unknown.status.success() && String::from_utf8_lossy(&unknown.stderr).contains("--device handle"),
        "refused"
    );
}
