//! Live peers with a device that is not simulated by them: an Inverse3, of which here the service is emulated, and emulated motors on a bus.
//! Programs on loopback, as a user runs them.
//!
//! A device lets go when its peer is late, and a peer when its device is: who shares two cores with a browser is. So these are a program of their own,
//! and what is in time has a real-time priority: a pair at its devices takes half of a core, so that as many tests run at once as there are cores.

mod another_language;
mod board;
mod bus;
mod emulate;
mod emulated;
mod ends;
mod hub;
mod lines;
mod page;
#[path = "../suite/program/mod.rs"]
mod program;
mod steps;
mod together;

use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStderr, Command};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use cohold_devices::emulators::hand::HAND_N_PER_M;
use cohold_devices::emulators::inverse3::{Emulator, Fault, HOLDS_S};
use serde_json::Value;

use emulated::haply;
use program::{Keys, cohold, free, signal};

/// What the device has, in the place of the simulated one, the hand at it, for the verdict, and what the other hand does: it holds on.
const SETTINGS: [&str; 8] = [
    "peer.1.safety.max_force_n=8",
    "peer.1.safety.max_speed_m_per_s=2",
    "user.1.arm_stiffness_n_per_m=300",
    "user.1.arm_damping_n_s_per_m=8",
    "user.2.push_n=0",
    "user.2.arm_stiffness_n_per_m=300",
    "user.2.arm_damping_n_s_per_m=8",
    "device.force_delay_ticks=1",
];
/// A network that loses packets: 8 ms each way, a fifth lost, five in a row.
const LOSSY: [&str; 3] = ["network.one_way_delay_packets=8", "network.loss=0.2", "network.loss_burst_packets=5"];
/// A reading may be this old, s: `--device-silent-s` by default.
const SILENT_S: f64 = 0.05;
/// What a busy machine may take until a thread runs, s.
const BUSY_S: f64 = 0.1;

/// The program of a peer, and what it says while it runs.
struct Running {
    child: Child,
    said: Arc<Mutex<Vec<String>>>,
    reader: JoinHandle<()>,
}

/// Peers and emulated devices of a machine with nothing else to do stand still for less.
const TOO_BUSY_MS: f64 = 10.0;

impl Running {
    fn start(mut command: Command) -> Self {
        let mut child = command.spawn().expect("cohold runs");
        let said = Arc::new(Mutex::new(Vec::new()));
        let (stderr, lines): (ChildStderr, _) = (child.stderr.take().expect("kept"), said.clone());
        let reader = std::thread::spawn(move || {
            for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                lines.lock().expect("lines").push(line);
            }
        });
        Self { child, said, reader }
    }

    fn said(&self) -> String {
        self.said.lock().expect("lines").join("\n")
    }

    /// Waits until it says so.
    fn until(&mut self, words: &str) {
        let by = Instant::now() + Duration::from_secs(40);
        while !self.said().contains(words) {
            if self.child.try_wait().expect("a child").is_some() {
                // What it said last is on its way.
                std::thread::sleep(Duration::from_millis(200));
                panic!("it has ended: {}", self.said());
            }
            assert!(Instant::now() < by, "never {words}: {}", self.said());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Whether it ended well, its report, and what it said.
    fn end(self) -> (bool, Value, String) {
        let output = self.child.wait_with_output().expect("it ends");
        let _ = self.reader.join();
        let said = self.said.lock().expect("lines").join("\n");
        let live: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        let stopped_us = [&live["punctuality"]["worst_us"], &live["device"]["round_trip"]["largest_us"]];
        let stopped_ms = 1e-3 * stopped_us.into_iter().filter_map(Value::as_f64).fold(0.0, f64::max);
        if stopped_ms > TOO_BUSY_MS {
            // If its test fails, `cargo xtask test` reads this and runs it again, alone.
            println!("this machine was too busy: a peer or its device stood still for {stopped_ms:.0} ms");
        }
        (output.status.success(), live, said)
    }

    /// Its report, once it was asked to end, and did so well.
    fn asked_to_end(self) -> Value {
        signal(&self.child, "INT");
        let (ended, report, said) = self.end();
        assert!(ended, "{said}");
        report
    }
}

fn peer(scene: &str, number: &str, listen: &str, connect: &str, key: &str) -> Command {
    let mut command = cohold(&["peer", "--json", "--scene", scene, "--number", number, "--key-file", key]);
    command.args(["--listen", listen, "--connect", connect]);
    command.args(sets(&SETTINGS));
    command
}

/// What a command is given for these settings.
fn sets(settings: impl IntoIterator<Item = &'static &'static str>) -> impl Iterator<Item = &'static str> {
    settings.into_iter().flat_map(|setting| ["--set", *setting])
}

/// A network between these two peers that listens here for either; for longer than they run, and no longer.
fn relay(
    scene: &str,
    seconds: f64,
    listen: &[String; 2],
    [one, two]: [&str; 2],
    network: impl Iterator<Item = &'static str>,
) -> Child {
    let mut command = cohold(&["network", "relay", "--json", "--scene", scene, "--seconds", &seconds.to_string()]);
    command.args(["--listen-1", &listen[0], "--listen-2", &listen[1], "--peer-1", one, "--peer-2", two]).args(network);
    command.spawn().expect("cohold runs")
}

/// Two peers, the first one at the emulated device, armed.
fn pair(name: &str, scene: &str, seconds: &str, emulator: &Emulator, more: &[&str]) -> [Running; 2] {
    let device = format!("haply:{}", emulator.at);
    armed(name, scene, seconds, &[&["--device", &device, "--device-lets-go-s", "0.02"], more].concat())
}

/// Two peers, the first one with these flags beside, armed.
fn armed(name: &str, scene: &str, seconds: &str, more: &[&str]) -> [Running; 2] {
    let (keys, one, two) = (Keys::new(name, 0), free(), free());
    let mut first = peer(scene, "1", &one, &two, &keys.file(0));
    first.args(["--seconds", seconds]).args(more);
    let mut second = peer(scene, "2", &two, &one, &keys.file(0));
    second.args(["--seconds", seconds]);
    let mut peers = [first, second].map(Running::start);
    peers.iter_mut().for_each(|peer| peer.until(" s  armed, "));
    peers
}

/// Number of the fault that a peer says the other one has.
fn fault_of(other: &Value) -> Option<u8> {
    other["state"].as_str()?.strip_prefix("fault ")?.split(':').next()?.parse().ok()
}

fn number(of: &Value, key: &str) -> f64 {
    of[key].as_f64().unwrap_or_else(|| panic!("{key} in {of}"))
}

/// Largest step of an asked force along any axis within `for_s` from the first one that is not zero on, N.
fn largest_first_step<const N: usize>(asked: &[(f64, [f64; N])], for_s: f64) -> f64 {
    let first = asked.iter().position(|(_, force)| *force != [0.0; N]).expect("a force");
    let soon = asked[first.saturating_sub(1)..].iter().take_while(|(at, _)| *at <= asked[first].0 + for_s);
    let forces: Vec<[f64; N]> = soon.map(|(_, force)| *force).collect();
    let steps = forces.windows(2).flat_map(|two| (0..N).map(|axis| (two[1][axis] - two[0][axis]).abs()));
    steps.fold(0.0, f64::max)
}

/// Mean of the asked forces of the last `for_s`, N.
fn mean(asked: &[(f64, [f64; 3])], until_s: f64, for_s: f64) -> [f64; 3] {
    let last: Vec<_> = asked.iter().filter(|(at, _)| (until_s - for_s..until_s).contains(at)).collect();
    [0, 1, 2].map(|axis| last.iter().map(|(_, force)| force[axis]).sum::<f64>() / last.len() as f64)
}

/// A hand on the emulated device reaches 20 mm (and of three axes, 10 and 15 aside), and the simulated one holds on at the other end: what
/// both feel is what the springs between them give in statics, hand, contact, contact, hand, less what the copies are apart.
#[test]
fn a_device_and_a_simulated_one_hold_one_object() {
    const CONTACT_N_PER_M: f64 = 1000.0;
    // Of least jerk, 1.875 times 21 mm in a second: whom the machine stops for a while leaves its copy behind by as much.
    const FASTEST_M_PER_S: f64 = 0.04;
    let reach_m = [0.02, -0.01, 0.015];
    // The scene's first axis is that of the device. By how far the hand trembles when the peers meet, their copies stay apart; of three axes
    // reports have that along the first so there it does not tremble.
    for (scene, mapped, first, axes, tremor_m) in [("any-network", "x,y,z", 0, 1, 1e-3), ("space", "y,-x,z", 1, 3, 0.0)]
    {
        let emulator = haply(tremor_m);
        let more = ["--device-axes", mapped, "--device-origin-m", "0,0,0", "--device-silent-s", "0.2"];
        let peers = pair(&format!("devices-{scene}"), scene, "8", &emulator, &more);
        emulator.world().reach(reach_m);
        std::thread::sleep(Duration::from_millis(4_500));
        let (asked, now_s) = {
            let world = emulator.world();
            (world.asked.to_vec(), world.time_s())
        };
        let felt_n = mean(&asked, now_s, 1.0);
        let mut apart_m = 0.0;
        let ends = peers.map(Running::end);
        let stopped_ms = ends.iter().map(|(_, live, _)| 1e-3 * number(&live["punctuality"], "worst_us"));
        let allowed_mm = 2.0 + FASTEST_M_PER_S * stopped_ms.fold(0.0, f64::max);
        for (ended, live, said) in ends {
            assert!(ended && live["fault"] == Value::Null, "{said}\n{live}");
            let most_mm = number(&live, "largest_true_discrepancy_mm");
            println!("{scene}: {most_mm:.3} mm apart at most, {felt_n:?} N, round trip {}", live["round_trip_us"]);
            apart_m = 1e-3 * number(&live, "true_discrepancy_mm");
            assert!(most_mm < allowed_mm && number(&live, "ticks") == 8_000.0, "{allowed_mm} mm: {live}");
            // The verdict before arming is about the device that is there, as late as it was read; of the simulated one it is the scene's.
            let late = &live["verdict"]["device_delay_ticks"];
            assert_eq!(late.as_u64().is_some_and(|ticks| ticks >= 1), live["device"] != Value::Null, "{live}");
        }
        for axis in 0..axes {
            // What the copies are apart, the springs are not stretched by; along every axis in proportion.
            let stretched_m = reach_m[axis] * (1.0 - apart_m / f64::abs(reach_m[first]));
            let wanted_n = -stretched_m / (2.0 / HAND_N_PER_M + 2.0 / CONTACT_N_PER_M);
            let felt_n = felt_n[axis];
            assert!(
                (felt_n / wanted_n - 1.0).abs() < 0.05,
                "{scene}, axis {axis}: {felt_n} N, {wanted_n} N in statics"
            );
        }
        let step_n = largest_first_step(&asked, 0.1);
        println!("{scene}: largest step of the force in its first 100 ms {step_n:.4} N");
        assert!(step_n <= 0.05, "{step_n} N");
    }
}

/// Whatever the service does wrong: no force after the time that is stated, and both ends say why.
#[test]
fn each_fault_of_a_device_cuts_the_force_and_is_named() {
    let faults = [
        (Fault::Silent, 23, "ms old, of 50 allowed"),
        (Fault::Late, 23, "ms old, of 50 allowed"),
        (Fault::NotANumber, 25, "not a number"),
        (Fault::Jump, 25, "moved by"),
        (Fault::Closes, 24, "clos"),
        (Fault::Uncalibrated, 24, "is not calibrated"),
        // Readings had become 0.9 s old within 4 s, and were believed.
        (Fault::Unasked, 24, "nobody asked for"),
    ];
    for (fault, numbered, words) in faults {
        let emulator = haply(1e-3);
        let peers = pair(&format!("devices-{fault:?}"), "any-network", "60", &emulator, &[]);
        emulator.world().reach([0.02, 0.0, 0.0]);
        std::thread::sleep(Duration::from_millis(1_500));
        let before_n = emulator.world().advance()[0];
        assert!(before_n < -1.0, "{fault:?}: {before_n} N before");
        let failed_s = emulator.world().fail(fault);
        let [first, second] = peers;
        let (ended, live, said) = first.end();
        let cause = live["fault"].as_str().unwrap_or_default().to_owned();
        assert!(!ended && cause.starts_with(&format!("fault {numbered}: ")) && cause.contains(words), "{said}\n{live}");
        assert!(said.contains("the motors are off: fault"), "{said}");
        // It would go on alone.
        signal(&second.child, "INT");
        let (_, live, said) = second.end();
        assert_eq!(fault_of(&live["other"]), Some(numbered), "{said}\n{live}");
        let mut world = emulator.world();
        let last = world.asked.iter().rev().find(|(_, force)| *force != [0.0; 3]).expect("a force").0;
        println!("{fault:?}: last force {:.1} ms after it; {cause}", 1e3 * (last - failed_s));
        assert!(last - failed_s < SILENT_S + BUSY_S, "{fault:?}: a force {} s later", last - failed_s);
        let most_n = world.asked.iter().filter(|(at, _)| *at >= failed_s).map(|(_, force)| force[0].abs());
        assert!(most_n.fold(0.0, f64::max) < before_n.abs() + 0.2, "{fault:?}: more than before");
        assert_eq!(world.advance(), [0.0; 3]);
    }
}

/// A process that is killed says nothing more: the device lets go after its own time.
#[test]
fn a_device_lets_go_when_its_peer_is_killed() {
    let emulator = haply(1e-3);
    let [mut first, mut second] = pair("devices-killed", "any-network", "60", &emulator, &[]);
    emulator.world().reach([0.02, 0.0, 0.0]);
    std::thread::sleep(Duration::from_millis(1_500));
    assert!(emulator.world().advance()[0] < -1.0);
    first.child.kill().expect("a child");
    let _ = first.child.wait();
    let killed_s = emulator.world().time_s();
    std::thread::sleep(Duration::from_secs_f64(HOLDS_S));
    {
        let mut world = emulator.world();
        let last = world.asked.last().expect("asked").0;
        assert!(last <= killed_s, "nobody asks after {killed_s} s");
        assert_eq!(world.advance(), [0.0; 3], "{} s after the last force", world.time_s() - last);
    }
    second.child.kill().expect("a child");
    let _ = second.child.wait();
}

/// Who may not be armed is refused before anything is sent to the other peer, and told why.
#[test]
fn a_device_that_must_not_be_armed_is_refused_by_name() {
    let keys = Keys::new("devices-refused", 0);
    let refusal = |device: &str, more: &[&str]| {
        let mut command = peer("any-network", "1", &free(), &free(), &keys.file(0));
        let output = command.args(["--device", device]).args(more).output().expect("cohold runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success(), "{said}");
        said
    };
    let known = ["--device-lets-go-s", "0.02"];
    let emulator = haply(1e-3);
    let haply = format!("haply:{}", emulator.at);
    let said = refusal(&haply, &[]);
    assert!(said.contains("how long Inverse3 049D holds a force"), "{said}");
    let cases = [
        (Fault::Older, "older than 3.5"),
        (Fault::Preset, "the preset arm_front_centered"),
        (Fault::Uncalibrated, "Inverse3 049D is not calibrated"),
    ];
    for (fault, words) in cases {
        emulator.world().fail(fault);
        let said = refusal(&haply, &known);
        assert!(said.contains(words), "{fault:?}: {said}");
    }
    emulator.world().fail(Fault::None);
    let said = refusal(&haply, &["--device-id", "ABCD", "--device-lets-go-s", "0.02"]);
    assert!(said.contains("no Inverse3 ABCD"), "{said}");
    let nobody = refusal(&format!("haply:{}", free()), &known);
    assert!(nobody.contains("Haply's service at"), "{nobody}");
    for (device, more) in [("phantom", &[][..]), ("haply", &["--device-axes", "x,x,y"]), ("haply:there", &known)] {
        let said = refusal(device, more);
        assert!(said.contains("--device"), "{device}: {said}");
    }
}
