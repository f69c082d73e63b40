//! A device at a hub: the end that has it does not know that its partner is a hub, and the hub does not know what is behind its line.

use std::process::Command;
use std::time::Duration;

use cohold_devices::emulators::inverse3::{Emulator, Fault};
use serde_json::Value;

use super::emulated::haply;
use super::{BUSY_S, HAND_N_PER_M, Running, SILENT_S, fault_of, mean, number, relay, sets};
use crate::program::{Keys, cohold, free, report, signal};

const REACH_M: f64 = 0.015;
const CONTACT_N_PER_M: f64 = 1000.0;
/// The path between the device's peer and the hub: 4 ms each way, a fifth of the packets lost, five in a row.
const PATH: [&str; 3] = ["network.one_way_delay_packets=4", "network.loss=0.2", "network.loss_burst_packets=5"];
/// The two simulated hands hold on, with what an Inverse3 has in the place of the simulated device.
const HOLD_ON: [&str; 7] = [
    "device.mass_kg=0.3",
    "user.1.push_n=0",
    "user.1.arm_stiffness_n_per_m=300",
    "user.1.arm_damping_n_s_per_m=8",
    "user.2.push_n=0",
    "user.2.arm_stiffness_n_per_m=300",
    "user.2.arm_damping_n_s_per_m=8",
];

/// A hub for three, and where it listens.
fn hub(keys: &Keys) -> (Running, String) {
    let address = free();
    let mut command =
        cohold(&["shared", "hub", "--json", "--scene", "any-network", "--users", "3", "--listen", &address]);
    command.args(["--seconds", "60", "--key-file", &keys.file(0)]);
    (Running::start(command), address)
}

/// The peer on this line.
fn on(keys: &Keys, line: u32, listen: &str, connect: &str) -> Command {
    let number = if line % 2 == 1 { "1" } else { "2" };
    let mut command = cohold(&["peer", "--json", "--scene", "any-network", "--number", number, "--listen", listen]);
    command.args(["--connect", connect, "--key-file", &keys.file(line), "--seconds", "60"]).args(sets(&HOLD_ON));
    command
}

/// The two at simulated devices.
fn simulated(keys: &Keys, hub: &str) -> [Running; 2] {
    [2, 3].map(|line| Running::start(on(keys, line, "127.0.0.1:0", hub)))
}

/// The device of an end, as its flags have it.
fn device(emulator: &Emulator) -> [String; 4] {
    ["--device".into(), format!("haply:{}", emulator.at), "--device-lets-go-s".into(), "0.02".into()]
}

/// How far apart the copies of two users were at most in the last second of which the hub has told, m.
fn apart_m(hub: &Running) -> f64 {
    let said = hub.said();
    let newest = said.rsplit("true discrepancy ").next().and_then(|words| words.split(' ').next());
    newest.and_then(|mm| mm.parse::<f64>().ok()).map(|mm| 1e-3 * mm).unwrap_or_else(|| panic!("no distance: {said}"))
}

/// The hand at the device reaches. What it feels in the end, N, is what the springs give in statics: its own and its contact's, against those of
/// two others, all equal, less what the copies are apart, by which no spring is stretched.
fn reach(emulator: &Emulator, hub: &Running) {
    emulator.world().reach([REACH_M, 0.0, 0.0]);
    std::thread::sleep(Duration::from_secs(5));
    let felt_n = {
        let world = emulator.world();
        mean(&world.asked, world.time_s(), 1.0)[0]
    };
    let apart_m = apart_m(hub);
    let wanted_n = -(REACH_M - apart_m) * 2.0 / 3.0 / (1.0 / HAND_N_PER_M + 1.0 / CONTACT_N_PER_M);
    println!("felt {felt_n:.3} N, {wanted_n:.3} N in statics; copies {:.3} mm apart", 1e3 * apart_m);
    assert!((felt_n / wanted_n - 1.0).abs() < 0.05, "{felt_n} N, {wanted_n} N in statics");
}

/// The hub and the two others went on without a fault, and what the hub saw.
fn ended(hub: Running, others: [Running; 2]) -> Value {
    for peer in &others {
        signal(&peer.child, "INT");
    }
    for (ended, live, said) in others.map(Running::end) {
        assert!(ended && live["fault"] == Value::Null, "{said}\n{live}");
    }
    hub.asked_to_end()
}

/// One at an Inverse3 behind a path that loses packets, two at simulated devices. When the device's service falls silent that peer lets go in time,
/// the hub hears why, and the others go on.
#[test]
fn three_hold_one_object_and_one_is_at_a_device() {
    let (keys, between, own) = (Keys::new("devices-hub", 3), [free(), free()], free());
    let (hub, address) = hub(&keys);
    let lossy = relay("any-network", 72.0, &between, [&own, &address], sets(&PATH));
    let emulator = haply(0.0);
    let mut first = on(&keys, 1, &own, &between[0]);
    first.args(device(&emulator));
    let mut first = Running::start(first);
    let mut others = simulated(&keys, &address);
    first.until(" s  armed, ");
    others.iter_mut().for_each(|peer| peer.until(" s  armed, "));
    reach(&emulator, &hub);
    let failed_s = emulator.world().fail(Fault::Silent);
    let (ended_well, live, said) = first.end();
    let why = live["fault"].as_str().unwrap_or_default();
    assert!(!ended_well && why.starts_with("fault 23: "), "{said}\n{live}");
    assert!(number(&live, "datagrams_missing") > 0.1 * number(&live, "datagrams_taken"), "{live}");
    let last = emulator.world().asked.iter().rev().find(|(_, force)| *force != [0.0; 3]).expect("a force").0;
    println!("last force {:.1} ms after the fault; {}", 1e3 * (last - failed_s), live["device"]);
    assert!(last - failed_s < SILENT_S + BUSY_S, "a force {} s later", last - failed_s);
    // The others go on.
    std::thread::sleep(Duration::from_secs(1));
    let seen = ended(hub, others);
    assert_eq!(fault_of(&seen["lines"][0]["said"]), Some(23), "{seen}");
    signal(&lossy, "INT");
    println!("{}", report(lossy));
}

/// The page is an end like any: with its hand at the device it holds with the two others around a hub.
#[test]
fn a_page_at_a_hub_has_a_device() {
    let keys = Keys::new("devices-hub-page", 3);
    let (hub, address) = hub(&keys);
    let emulator = haply(0.0);
    let mut page = cohold(&["play", "--scene", "any-network", "--join", &address, "--number", "1"]);
    page.args(["--key-file", &keys.file(1), "--seconds", "60"]).args(device(&emulator)).args(sets(&HOLD_ON));
    let mut page = Running::start(page);
    page.until("operator:");
    let mut others = simulated(&keys, &address);
    others.iter_mut().for_each(|peer| peer.until(" s  armed, "));
    reach(&emulator, &hub);
    page.asked_to_end();
    ended(hub, others);
}
