//! A peer with emulated motors on a bus that drive a five-bar.

use std::time::{Duration, Instant};

use cohold_devices::emulators::Emulated as _;
use cohold_devices::emulators::motors::{Emulator, Fault};
use serde_json::Value;

use super::emulated::{self, fdcanusb};
use super::{BUSY_S, Running, SILENT_S, armed, fault_of, largest_first_step, number, peer};
use crate::program::{Keys, free, signal};

/// The motors' own watchdog, s.
const WATCHDOG_S: f64 = 0.05;

fn pair(name: &str, seconds: &str, bus: &Emulator, more: &[&str]) -> [Running; 2] {
    let flags = bus.words();
    let flags: Vec<&str> = flags.iter().map(String::as_str).chain(more.iter().copied()).collect();
    armed(name, "plane", seconds, &flags)
}

/// Waits until the force on the hand is at least this, N.
fn until_pushed(emulator: &Emulator, least_n: f64) -> [f64; 2] {
    let by = Instant::now() + Duration::from_secs(10);
    loop {
        let force_n = emulator.world().advance();
        if force_n[0].hypot(force_n[1]) >= least_n {
            return force_n;
        }
        assert!(Instant::now() < by, "{force_n:?} N at the most");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// By both ways to a bus: what the hand feels is what the springs between the two hands give in statics, along both axes; the motors never pull by
/// themselves, and the first force is no jump.
#[test]
fn motors_and_a_five_bar_hold_an_object() {
    const CONTACT_N_PER_M: f64 = 1000.0;
    let reach_m = [0.015, -0.01];
    for (name, emulator) in [
        ("moteus behind an fdcanusb", fdcanusb()),
        ("moteus", emulated::moteus("moteus")),
        ("MIT", emulated::mit("mit", 0.2)),
    ] {
        // As OpenArm sets its motors up; moteus hears nothing else.
        emulator.world().fail(Fault::Flexible);
        let peers = pair(
            &format!("motors-{}", name.len()),
            "7",
            &emulator,
            &["--device-silent-s", "0.2", "--device-lets-go-s", "0.2"],
        );
        emulator.world().hand.reach(reach_m);
        std::thread::sleep(Duration::from_millis(4_500));
        let felt_n = emulator.world().advance();
        let mut apart_m = [0.0; 2];
        for (ended, live, said) in peers.map(Running::end) {
            assert!(ended && live["fault"] == Value::Null, "{said}\n{live}");
            assert_eq!(number(&live, "ticks"), 7_000.0, "{live}");
            apart_m = [0, 1].map(|axis| 1e-3 * number(&live["axes"][axis], "decoded_discrepancy_mm"));
            if live["device"] != Value::Null {
                println!("{name}: {felt_n:?} N, {}", live["device"]);
                let device = &live["device"];
                assert!(number(&device["round_trip"], "samples") > 3_000.0, "{device}");
                let known = (name != "MIT").then_some(24.0);
                assert_eq!(device["supply_v"][1].as_f64(), known, "{device}");
                assert!((30.0..40.0).contains(&number(device, "warmest_c")), "{device}");
            }
        }
        for axis in 0..2 {
            let stretched_m = reach_m[axis] - f64::signum(reach_m[axis]) * apart_m[axis].abs();
            let wanted_n = -stretched_m / (2.0 / super::HAND_N_PER_M + 2.0 / CONTACT_N_PER_M);
            // A step of MIT's torque is 0.05 N at the hand.
            let steps_n = if name == "MIT" { 0.05 } else { 0.0 };
            let off_n = (felt_n[axis] - wanted_n).abs();
            assert!(off_n < 0.05 * wanted_n.abs() + steps_n, "{name}, {axis}: {felt_n:?} N, {wanted_n} N in statics");
        }
        let world = emulator.world();
        assert!(!world.pulled, "a motor was asked to pull by itself");
        // 0.05 N at the hand is at most 0.1 m times that at a motor.
        let step_nm = largest_first_step(&world.asked, 0.1);
        println!("{name}: largest step of a torque in the first 100 ms {:.5} N·m", step_nm);
        // MIT tells places in steps of 0.04 mm, 0.04 N here, and takes torques in steps of 0.005 N·m.
        let step_of_both_nm = if name == "MIT" { 0.005 } else { 0.0 };
        assert!(step_nm <= 0.005 + step_of_both_nm, "{step_nm} N·m");
    }
}

/// Whatever the motors do wrong: no force after the time that is stated, and both ends say why.
#[test]
fn each_fault_of_motors_cuts_the_force_and_is_named() {
    let faults = [
        (Fault::Silent, 23, "of 50 allowed"),
        (Fault::Late, 23, "of 50 allowed"),
        (Fault::NotANumber, 25, "not a number"),
        (Fault::Jump, 25, "moved by"),
        (Fault::Unplugged, 24, ""),
        (Fault::TooWarm, 27, "motor 1, its fault 38: too warm"),
        (Fault::OverVoltage, 28, "motor 1, its fault 34: over-voltage"),
    ];
    let moteus = faults.map(|(fault, numbered, words)| (false, fault, numbered, words));
    // A number that is none has no bits in this frame: it is the end of the range.
    let mit = [
        (true, Fault::Silent, 23, "of 50 allowed"),
        (true, Fault::Jump, 25, "moved by"),
        (true, Fault::Unplugged, 24, ""),
        (true, Fault::TooWarm, 27, "motor 1, its state c: its winding"),
        (true, Fault::OverVoltage, 28, "motor 1, its state 8: over-voltage"),
    ];
    for (is_mit, fault, numbered, words) in moteus.into_iter().chain(mit) {
        let name = format!("motors-{is_mit}-{fault:?}");
        let emulator = match is_mit {
            true => emulated::mit(&name, WATCHDOG_S),
            false => fdcanusb(),
        };
        let [first, second] = pair(&name, "60", &emulator, &[]);
        emulator.world().hand.reach([0.02, 0.0]);
        until_pushed(&emulator, 1.0);
        let failed_s = emulator.world().fail(fault);
        let (ended, live, said) = first.end();
        let cause = live["fault"].as_str().unwrap_or_default().to_owned();
        assert!(
            !ended && cause.starts_with(&format!("fault {numbered}: ")) && cause.contains(words),
            "{fault:?}: {said}\n{live}"
        );
        signal(&second.child, "INT");
        let (_, live, said) = second.end();
        assert_eq!(fault_of(&live["other"]), Some(numbered), "{said}\n{live}");
        let mut world = emulator.world();
        let last_s = world.asked.iter().rev().find(|(_, torques)| *torques != [0.0; 2]).expect("a torque").0;
        println!("{fault:?}: last torque asked for {:.1} ms after it; {cause}", 1e3 * (last_s - failed_s));
        assert!(last_s - failed_s < SILENT_S + BUSY_S, "{fault:?}: a torque {} s later", last_s - failed_s);
        assert_eq!(world.advance(), [0.0; 2], "{fault:?}");
    }
}

/// A process that is killed, or stopped, says nothing more: the motors let go after their own time. One that goes on stays off, without a jump.
#[test]
fn motors_let_go_when_their_peer_is_killed_or_stopped() {
    for (how, is_mit) in [("KILL", false), ("STOP", false), ("KILL", true), ("STOP", true)] {
        let name = format!("motors-{how}-{is_mit}");
        let emulator = match is_mit {
            true => emulated::mit(&name, WATCHDOG_S),
            false => fdcanusb(),
        };
        let [mut first, mut second] = pair(&name, "60", &emulator, &[]);
        emulator.world().hand.reach([0.02, 0.0]);
        until_pushed(&emulator, 1.0);
        let sent_s = emulator.world().hand.time_s();
        signal(&first.child, how);
        let mut let_go_s = None;
        while let_go_s.is_none() {
            let mut world = emulator.world();
            let force_n = world.advance();
            let now_s = world.hand.time_s();
            let_go_s = (force_n == [0.0; 2]).then_some(now_s);
            assert!(now_s - sent_s < 1.0, "{how}: {force_n:?} N still");
            drop(world);
            std::thread::sleep(Duration::from_millis(1));
        }
        let took_s = let_go_s.unwrap_or_default() - sent_s;
        println!("{how}: no force {:.1} ms after it", 1e3 * took_s);
        // What was on its way when the signal came is 1 ms old at the most; a busy machine delivers it late.
        assert!(took_s < WATCHDOG_S + BUSY_S, "{how}: {took_s} s");
        if how == "STOP" {
            let before = emulator.world().asked.len();
            signal(&first.child, "CONT");
            let (ended, live, said) = first.end();
            let cause = live["fault"].as_str().unwrap_or_default();
            assert!(
                !ended && ["fault 23: ", "fault 29: ", "fault 6: "].iter().any(|number| cause.starts_with(number)),
                "{said}\n{live}"
            );
            let world = emulator.world();
            let most_nm = world.asked[before..]
                .iter()
                .flat_map(|(_, torques)| torques)
                .fold(0.0, |most: f64, torque| most.max(torque.abs()));
            assert_eq!(most_nm, 0.0, "{how}: a torque after it went on");
        } else {
            let _ = first.child.wait();
        }
        second.child.kill().expect("a child");
        let _ = second.child.wait();
    }
}

/// Motors that must not be armed are refused before anything is sent to the other peer, and told why.
#[test]
fn motors_that_must_not_be_armed_are_refused_by_name() {
    let keys = Keys::new("motors-refused", 0);
    let refusal = |scene: &str, flags: &[String], more: &[&str]| {
        // A flag that is there twice is refused by itself: the later replaces the first.
        let flags = match more.first().and_then(|flag| flags.iter().position(|own| own == flag)) {
            Some(at) => [&flags[..at], &flags[at + 2..]].concat(),
            None => flags.to_vec(),
        };
        let mut command = peer(scene, "1", &free(), &free(), &keys.file(0));
        let output = command.args(flags).args(more).output().expect("cohold runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success(), "{said}");
        said
    };
    let [moteus, mit] = [fdcanusb(), emulated::mit("motors-refused", WATCHDOG_S)];
    for (emulator, fault, words) in [
        (&moteus, Fault::Holds, "motor 1 does not let go after its watchdog: servo.timeout_mode is 10"),
        (&moteus, Fault::Relative, "is not calibrated"),
        (&moteus, Fault::Silent, "motor 1 does not answer"),
        (&mit, Fault::Never, "nobody knows how long dm4310"),
        (&mit, Fault::OtherRanges, "motor 1 is no dm4310"),
        (&mit, Fault::OtherMode, "motor 1 is in control mode 2, and has to be in 1"),
        (&mit, Fault::Silent, "motor 1 does not answer"),
    ] {
        emulator.world().fail(fault);
        if std::ptr::eq(emulator, &moteus) {
            // Another program has left a part of a line in the adapter, and a viewer has the motors tell of themselves.
            std::fs::write(&emulator.at, "can se").expect("a line");
            emulator.world().streams = true;
        }
        let said = refusal("plane", &emulator.words(), &[]);
        assert!(said.contains(words), "{fault:?}: {said}");
        emulator.world().fail(Fault::None);
    }
    for (emulator, scene, more, words) in [
        (&moteus, "plane", &["--device-max-torque-nm", "0"][..], "--device-max-torque-nm"),
        (&moteus, "plane", &["--device-motors", "1,2,3"], "3 motors are named"),
        (&moteus, "plane", &["--device-motors", "1,3"], "motor 3 does not answer"),
        (&moteus, "plane", &["--device-motors", "1,1"], "--device-motors"),
        (&moteus, "plane", &["--device-max-torque-nm", "0.1"], "peer.1.safety.max_force_n="),
        (&moteus, "any-network", &[], "kinematics.model is \"direct\""),
        (&moteus, "plane", &["--device", "moteus:/no/such/bus"], "/no/such/bus"),
        (&moteus, "plane", &["--device", "moteus"], "its bus is not named"),
        (&mit, "plane", &["--device-model", "dm1"], "it is one of damiao, dm4310"),
    ] {
        let said = refusal(scene, &emulator.words(), more);
        assert!(said.contains(words), "{more:?}: {said}");
    }
    let homed: Vec<_> = mit.words().into_iter().filter(|flag| flag != "--device-homed").collect();
    assert!(refusal("plane", &homed, &[]).contains("is not calibrated"));
    // What the motors say of themselves is taken, whatever it is.
    mit.world().fail(Fault::OtherRanges);
    assert!(refusal("plane", &homed, &["--device-model", "damiao"]).contains("is not calibrated"));
    for emulator in [&moteus, &mit] {
        let world = emulator.world();
        assert!(world.asked.iter().all(|(_, torques)| *torques == [0.0; 2]), "nobody who is refused pushes");
    }
}
