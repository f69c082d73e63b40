//! Two people, each at a device of another kind, over a network that loses packets in bursts.

use std::time::Duration;

use serde_json::Value;

use super::bus::Bus;
use super::emulator::Emulator;
use super::{Running, alone, moteus, number, peer};
use crate::program::{Keys, free, host_sim, report, signal};

/// The network: 8 ms each way, 20 % of the packets lost, five in a row.
const NETWORK: [&str; 3] = ["network.one_way_delay_packets=8", "network.loss=0.2", "network.loss_burst_packets=5"];
/// Both hands as the emulators have them: one reaches, the other holds on.
const HANDS: [&str; 9] = [
    "device.mass_kg=0.3",
    "device.damping_n_s_per_m=0",
    "device.joint_inertia=0",
    "user.2.push_n=0",
    "user.2.arm_stiffness_n_per_m=300",
    "user.2.arm_damping_n_s_per_m=8",
    "user.1.direction_rad=0",
    "user.1.reach_m=0.02",
    "user.1.arm_damping_n_s_per_m=8",
];
const REACH_M: f64 = 0.02;
/// How far off the true discrepancy may be from what the simulator says, as a share, and what clocks and a busy machine add, mm.
const SHARE: f64 = 0.2;

fn settings() -> impl Iterator<Item = &'static str> {
    NETWORK.iter().chain(&HANDS).flat_map(|setting| ["--set", setting])
}

/// An Inverse3 and two moteus with a five-bar hold one object: no fault, and the copies as far apart as the simulator says of such a network. As
/// long as `DEVICES_SECONDS` says, 8 s without it.
#[test]
fn an_inverse3_and_motors_hold_one_object_over_a_lossy_network() {
    let _alone = alone();
    let seconds = std::env::var("DEVICES_SECONDS").unwrap_or_else(|_| "8".to_owned());
    let simulated = {
        let mut command = host_sim(&["cooperate", "--json", "--scene", "plane", "--seconds", &seconds]);
        let told = report(command.args(settings()).spawn().expect("host-sim runs"));
        number(&told, "true_discrepancy_mm")
    };
    let (keys, relay) = (Keys::new("devices-together", 0), [free(), free()]);
    let (one, two, key) = (free(), free(), keys.file(0));
    // Longer than the peers and no longer: it ends where the test does not come to end it.
    let relayed_s = (seconds.parse::<f64>().expect("seconds") + 60.0).to_string();
    let mut lossy = host_sim(&["network", "relay", "--json", "--scene", "plane", "--seconds", &relayed_s]);
    lossy.args(["--listen-1", &relay[0], "--listen-2", &relay[1], "--peer-1", &one, "--peer-2", &two]).args(settings());
    let lossy = lossy.spawn().expect("host-sim runs");
    let (haply, motors) = (Emulator::start(0.0), Bus::Moteus(moteus::Emulator::serial(0.0)));
    let patient = ["--device-silent-s", "0.2", "--device-lets-go-s", "0.2", "--seconds", &seconds];
    let mut first = peer("plane", "1", &one, &relay[0], &key);
    first.args(["--device", &format!("haply:{}", haply.at)]).args(patient).args(settings());
    let mut second = peer("plane", "2", &two, &relay[1], &key);
    second.args(motors.flags()).args(patient).args(settings());
    let mut peers = [first, second].map(Running::start);
    peers.iter_mut().for_each(|peer| peer.until(" s  armed, "));
    haply.world().reach([REACH_M, 0.0, 0.0]);
    std::thread::sleep(Duration::from_secs(2));
    let [at_first, at_second] = [haply.world().advance()[0], motors.world().advance()[0]];
    for (ended, live, said) in peers.map(Running::end) {
        assert!(ended && live["fault"] == Value::Null, "{said}\n{live}");
        let [apart_mm, error_mm] = ["true_discrepancy_mm", "true_discrepancy_error_mm"].map(|key| number(&live, key));
        println!(
            "{} ticks: {apart_mm:.4} mm apart, by the simulator {simulated:.4}; clocks ±{error_mm:.4}",
            live["ticks"]
        );
        println!("  {} ; {} ; lost {}", live["device"], live["punctuality"], live["datagrams_missing"]);
        assert!((apart_mm - simulated).abs() <= SHARE * simulated + error_mm, "{apart_mm} mm, and not {simulated}");
        assert!(number(&live, "datagrams_missing") > 0.1 * number(&live, "datagrams_taken"), "{live}");
    }
    println!("forces at the hands {at_first:.3} N and {at_second:.3} N");
    assert!(at_first < -0.5 && at_second > 0.5, "{at_first} N and {at_second} N");
    signal(&lossy, "INT");
    let relayed = report(lossy);
    println!("{relayed}");
}
