//! `cohold devices emulate`: emulators as a user starts them, and peers that are given the words that these print.

use std::path::Path;
use std::time::{Duration, Instant};

use cohold_devices::emulators::asked::{Asked, KEPT};

use super::steps::steps;
use super::{BUSY_S, Running, fault_of, number, peer};
use crate::program::{Keys, cohold, free, signal};

/// The program, once it serves; the words by which it is attached.
fn emulator(arguments: &[&str]) -> (Running, Vec<String>) {
    // It ends where the test does not come to end it, too.
    let whole = [&["devices", "emulate", "--json", "--seconds", "120"], arguments].concat();
    let mut running = Running::start(cohold(&whole));
    running.until("orders since");
    let said = running.said();
    let words = said.lines().find(|line| line.trim_start().starts_with("--device ")).expect("the words");
    let words = words.split_whitespace().map(str::to_owned).collect();
    (running, words)
}

/// A hand that the scene describes moves by itself; a peer at the device feels the other one, until the fault that was asked for is planted, and the
/// peer lets go and says why.
#[test]
fn a_peer_holds_an_emulated_device_until_it_falls_silent() {
    let (keys, one, two) = (Keys::new("devices-emulate", 0), free(), free());
    let reaches = ["--set", "user.1.reach_m=0.02", "--rest-s", "4", "--fault", "silent@14", "--lets-go-s", "0.2"];
    let (device, words) = emulator(&[&["inverse3", "--at", "127.0.0.1:0"][..], &reaches].concat());
    let mut first = peer("any-network", "1", &one, &two, &keys.file(0));
    first.args(&words).args(["--device-silent-s", "0.2", "--seconds", "60"]);
    let mut second = peer("any-network", "2", &two, &one, &keys.file(0));
    second.args(["--seconds", "60", "--set", "user.2.push_n=0"]);
    let [first, mut second] = [first, second].map(Running::start);
    second.until(" s  armed, ");
    let (ended, live, said) = first.end();
    let cause = live["fault"].as_str().unwrap_or_default();
    assert!(!ended && cause.starts_with("fault 23: "), "{said}\n{live}");
    signal(&second.child, "INT");
    let (_, other, said) = second.end();
    assert_eq!(fault_of(&other["other"]), Some(23), "{said}\n{other}");
    let seen = device.asked_to_end();
    // Two hands of 300 N/m and two contacts of 1000 N/m in a row, stretched by 20 mm.
    let wanted_n = 0.02 / (2.0 / 300.0 + 2.0 / 1000.0);
    let felt_n = number(&live["other"], "coordination_force_n").abs();
    assert!(felt_n > 0.8 * wanted_n && felt_n < 1.1 * wanted_n, "{felt_n} N of {wanted_n}: {live}");
    let after_s = number(&seen["faults"][0], "last_push_after_s");
    assert!(seen["faults"][0]["fault"] == "silent" && after_s < 0.2 + BUSY_S, "{seen}");
    assert!(number(&seen, "orders") > 5_000.0 && seen["force_n"] == serde_json::json!([0.0, 0.0, 0.0]), "{seen}");
    assert!(
        (seen["place_mm"][0].as_f64().unwrap_or_default() - 20.0).abs() < 0.5,
        "let go, the hand is where it wants to be: {seen}"
    );
}

/// Motors are found at the place that they were given, and the place is free again when they have gone; whatever else is there is left alone.
#[test]
fn motors_serve_at_a_place_and_leave_it() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("emulate-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = |name: &str| folder.join(name).display().to_string();
    let (link, bus) = (file("moteus"), file("moteus.can"));
    for (at, opens) in [(format!("serial:{link}"), link), (bus.clone(), bus)] {
        // The second one finds what a program leaves that is killed.
        for how in ["KILL", "INT"] {
            let (running, words) = emulator(&["moteus", "--at", &at]);
            assert_eq!(words[..2], ["--device".to_owned(), format!("moteus:{opens}")]);
            let taken = cohold(&["devices", "emulate", "mit", "--at", &opens]).output().expect("cohold runs");
            let said = String::from_utf8_lossy(&taken.stderr).into_owned();
            let wanted = format!("cohold: --at {opens} is not allowed: something is there already");
            assert!(taken.status.code() == Some(2) && said.contains(&wanted), "{said}");
            let found = cohold(&["devices", "--json", "--look-at", &opens]).output().expect("cohold runs");
            let found = String::from_utf8_lossy(&found.stdout).into_owned();
            assert!(found.contains("moteus 1 (24.0 V, 31 °C), moteus 2"), "{found}");
            signal(&running.child, how);
            let (ended, _, said) = running.end();
            assert_eq!((ended, Path::new(&opens).symlink_metadata().is_ok()), (how == "INT", how == "KILL"), "{said}");
        }
    }
    let own = file("own");
    std::fs::write(&own, "kept").expect("a file");
    for at in [own.clone(), format!("serial:{own}")] {
        let refused = cohold(&["devices", "emulate", "moteus", "--at", &at]).output().expect("cohold runs");
        assert_eq!(refused.status.code(), Some(2));
    }
    assert_eq!(std::fs::read_to_string(&own).expect("it is there"), "kept");
}

/// A slip gets one sentence, and nothing serves.
#[test]
fn a_slip_is_told_in_one_sentence() {
    for (arguments, words) in [
        (&["inverse3", "--fault", "unplugged@3"][..], "--fault unplugged is not allowed: it is one of none, silent,"),
        (&["moteus", "--fault", "silent"], "--fault silent is not allowed: a fault's name, @ and seconds"),
        (&["inverse3", "--at", "here"], "--at here is not allowed: "),
        (&["mit", "--at", "can99"], "--at can99 is not allowed: "),
        (&["moteus", "--lets-go-s", "0.1"], "--lets-go-s is not allowed for moteus"),
        (&["inverse3", "--set", "user.1.wall_stiffness_n_per_m=100"], "a hand meets no wall here"),
        (&["inverse4"], "inverse4"),
    ] {
        let run = cohold(&["devices", "emulate"]).args(arguments).args(["--seconds", "1"]).output();
        let run = run.expect("cohold runs");
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        assert!(
            run.status.code() == Some(2) && said.contains(words) && said.lines().count() == 1,
            "{arguments:?}: {said}"
        );
    }
}

/// MIT motors disable themselves after the time that they were started with.
#[test]
fn motors_let_go_after_their_own_time() {
    let (device, words) = emulator(&["mit", "--lets-go-s", "0.1"]);
    let mut asks = cohold(&["devices", "--json", "--scene", "plane", "--distance-m", "0.02"]);
    let asked = asks.args(&words).args(["--device-silent-s", "0.2"]).stdin(std::process::Stdio::null()).output();
    let asked = asked.expect("cohold runs");
    let said = String::from_utf8_lossy(&asked.stderr).into_owned();
    assert!(said.contains("lets go within 100 ms"), "{said}");
    assert_eq!(number(&device.asked_to_end(), "orders"), 0.0, "nobody was there to move the hand");
}

/// The page's way to try the ten steps without a device: its hand moves by itself, and whoever presses Enter waits for that.
#[test]
fn a_hand_that_moves_by_itself_passes_the_ten_steps() {
    let (device, words) = emulator(&["moteus", "--set", "user.1.reach_m=0.02", "--rest-s", "8"]);
    let by = Instant::now() + Duration::from_secs(30);
    let (passed, told, said) = steps(&words, &["--scene", "plane"], |_| {
        while !device.said().contains("hand at 20.00, 0.00 mm") {
            assert!(Instant::now() < by, "it has not moved: {}", device.said());
            std::thread::sleep(Duration::from_millis(50));
        }
    });
    println!("{said}");
    assert!(passed && told["passed"].as_array().map(Vec::len) == Some(10), "{said}\n{told}");
    assert!(number(&device.asked_to_end(), "orders") > 1_000.0);
}

/// An emulator that runs for days does not grow with them.
#[test]
fn the_newest_orders_are_kept_and_all_are_counted() {
    let mut asked = Asked::<1>::default();
    let count = 5 * KEPT as u64 + 3;
    (0..count).for_each(|at| asked.push(at as f64, [if at % 1000 == 7 { 1.0 } else { 0.0 }]));
    assert!((KEPT..=2 * KEPT).contains(&asked.len()), "{}", asked.len());
    let all = asked.windows(2).all(|two| two[1].0 == two[0].0 + 1.0);
    assert!(all && asked.last().map(|last| last.0) == Some(count as f64 - 1.0));
    let last_push_s = (0..count).rev().find(|at| at % 1000 == 7).map(|at| at as f64);
    assert_eq!((asked.count(), asked.last_push_s()), (count, last_push_s));
}
