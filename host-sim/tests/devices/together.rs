//! Two people, each at an emulated device, over a network that loses packets in bursts: every adapter at either end. As long as
//! `DEVICES_SECONDS` says, 8 s without it.

use std::time::Duration;

use serde_json::Value;

use super::ends::{End, Kind};
use super::{LOSSY, Running, number, peer, relay, sets};
use crate::program::{Keys, cohold, free, report, signal};

/// Both hands as the emulators have them: one reaches, the other holds on; and what a person's hand is limited to at either end.
const HANDS: [&str; 13] = [
    "device.mass_kg=0.3",
    "device.damping_n_s_per_m=0",
    "device.joint_inertia=0",
    "user.1.push_n=0",
    "user.1.reach_m=0.02",
    "user.1.reach_s=1",
    "user.1.arm_stiffness_n_per_m=300",
    "user.1.arm_damping_n_s_per_m=8",
    "user.1.direction_rad=0",
    "user.2.push_n=0",
    "user.2.arm_stiffness_n_per_m=300",
    "user.2.arm_damping_n_s_per_m=8",
    "peer.1.safety.max_force_n=3",
];
/// What a board's workspace makes its peer say.
const WITHIN: [&str; 2] = ["peer.1.safety.workspace_m=0.2", "peer.2.safety.workspace_m=0.2"];
const REACH_M: f64 = 0.02;
/// How far off the true discrepancy may be from what the simulator says, as a share, beside what clocks leave unknown.
const SHARE: f64 = 0.2;

/// Both devices in this scene hold one object: no fault, and the copies as far apart as the simulator says of such a network, or further by what
/// the peers' clocks leave unknown.
fn hold(scene: &str, kinds: [Kind; 2]) {
    let name = format!("{:?}-{:?}", kinds[0], kinds[1]).to_lowercase();
    let seconds = std::env::var("DEVICES_SECONDS").unwrap_or_else(|_| "8".to_owned());
    let set = || {
        let within = WITHIN.iter().filter(|_| kinds.contains(&Kind::Board));
        sets(LOSSY.iter().chain(&HANDS).chain(within))
    };
    let (keys, between) = (Keys::new(&format!("devices-{name}"), 0), [free(), free()]);
    let (one, two, key) = (free(), free(), keys.file(0));
    // It ends where the test does not come to end it, too.
    let relayed_s = seconds.parse::<f64>().expect("seconds") + 60.0;
    let lossy = relay(scene, relayed_s, &between, [&one, &two], set());
    let ends = [1, 2].map(|number| End::start(kinds[usize::from(number) - 1], &key, number));
    let live = |number: &str, listen: &str, connect: &str, end: &End| {
        let mut command = peer(scene, number, listen, connect, &key);
        command.args(end.flags()).args(["--seconds", &seconds]).args(set());
        Running::start(command)
    };
    let mut peers = [live("1", &one, &between[0], &ends[0]), live("2", &two, &between[1], &ends[1])];
    peers.iter_mut().for_each(|peer| peer.until(" s  armed, "));
    ends[0].reach(REACH_M);
    std::thread::sleep(Duration::from_secs(3));
    let [at_first, at_second] = [&ends[0], &ends[1]].map(End::force_n);
    let ended = peers.map(Running::end);
    signal(&lossy, "INT");
    println!("{name}: forces at the hands {at_first:.3} N and {at_second:.3} N; relay {}", report(lossy));
    let held = ended.iter().all(|(ended, live, _)| *ended && live["fault"] == Value::Null);
    // Why one let go says the other end of it.
    assert!(held, "{}", ended.each_ref().map(|(_, live, said)| format!("{said}\n{live}")).join("\n"));
    for (_, live, _) in &ended {
        println!("  {} ticks; {} ; {}", live["ticks"], live["device"], live["punctuality"]);
        assert!(number(live, "datagrams_missing") > 0.1 * number(live, "datagrams_taken"), "{live}");
    }
    assert!(at_first < -0.5 && at_second > 0.5, "{at_first} N and {at_second} N");
    // As long as any run of the simulator that has come to rest.
    let mut simulated = cohold(&["cooperate", "--json", "--scene", scene, "--seconds", "60"]);
    let simulated = report(simulated.args(set()).spawn().expect("cohold runs"));
    let wanted_mm = number(&simulated, "true_discrepancy_mm");
    for (_, live, _) in &ended {
        let [apart_mm, error_mm] = ["true_discrepancy_mm", "true_discrepancy_error_mm"].map(|key| number(live, key));
        println!("  {apart_mm:.4} mm apart, clocks ±{error_mm:.4}; by the simulator {wanted_mm:.4}");
        assert!((apart_mm - wanted_mm).abs() <= SHARE * wanted_mm, "{apart_mm} mm, and not {wanted_mm}");
    }
}

#[test]
fn haply_and_moteus_over_a_lossy_network() {
    hold("plane", [Kind::Haply, Kind::Moteus]);
}

#[test]
fn moteus_and_mit_over_a_lossy_network() {
    hold("plane", [Kind::Moteus, Kind::Mit]);
}

#[test]
fn mit_and_haply_over_a_lossy_network() {
    hold("plane", [Kind::Mit, Kind::Haply]);
}

#[test]
fn board_and_haply_over_a_lossy_network() {
    hold("any-network", [Kind::Board, Kind::Haply]);
}

#[test]
fn haply_and_board_over_a_lossy_network() {
    hold("any-network", [Kind::Haply, Kind::Board]);
}
