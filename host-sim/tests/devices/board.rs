//! A board as the device of a PC's peer. The board is emulated by what flies on it: core's own peer behind the sealed line, ticking in a thread of this
//! process, with a hand at its device that this test moves and whose force it sees.

use std::net::UdpSocket;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use cohold_core::device::{AXES, Reading};
use cohold_core::num::Motion;
use cohold_core::peer::{Actuators, Sensors};
use cohold_devices::emulators::hand::{HAND_N_PER_M, Hand};
use cohold_live::endpoint::realtime_beneath;
use cohold_live::key_file;
use cohold_live::node::Node;
use cohold_protocol::key::Role;
use cohold_sim::Scene;
use cohold_sim::device::Device;
use serde_json::Value;

use super::steps::steps;
use super::{BUSY_S, LOSSY, Running, SILENT_S, fault_of, largest_first_step, number, peer, relay, sets};
use crate::program::{Keys, cohold, free, report, signal};

const TICK: Duration = Duration::from_millis(1);
/// The board's own ladder: no force after so long without a packet, s.
const LADDER_S: f64 = 0.05;

/// What can go wrong at a board or on the way to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Fault {
    #[default]
    None,
    /// It says nothing any more, and goes on.
    Silent,
    /// It tells a speed that its limits do not allow.
    Impossible,
    /// Its hand is 50 mm further from one tick to the next.
    Jump,
    /// Its hand is out of its workspace, by its own guard.
    OutOfWorkspace,
    /// Somebody turns its motors off.
    Disarmed,
}

/// The hand at the board's device, and what the board did to it.
pub(super) struct World {
    pub(super) hand: Hand<1>,
    fault: Fault,
    /// Time, s, and force, N, of each tick.
    asked: Vec<(f64, [f64; 1])>,
}

/// The device of the board, as its node drives it.
#[derive(Clone)]
struct Handle(Arc<Mutex<World>>);

impl Handle {
    fn world(&self) -> MutexGuard<'_, World> {
        self.0.lock().expect("the board goes on")
    }

    /// To now, under this force.
    fn give(&self, force_n: f64) {
        let mut world = self.world();
        let now_s = world.hand.time_s();
        while world.hand.now_s < now_s {
            world.hand.step([force_n]);
        }
        world.asked.push((now_s, [force_n]));
    }
}

impl Device<f32, AXES> for Handle {
    fn sensors(&self) -> Sensors<f32, AXES> {
        let world = self.world();
        let (mut place_m, mut speed) = (world.hand.position_m[0], world.hand.velocity_m_per_s[0]);
        match world.fault {
            Fault::Impossible => speed = 8.0,
            Fault::Jump => place_m += 0.05,
            Fault::OutOfWorkspace => place_m += 0.3,
            _ => {}
        }
        let along = Motion { position: place_m as f32, velocity: speed as f32 };
        Sensors::of(Reading::Exact([along, Motion::REST]))
    }

    fn step(&mut self, _: f64, actuators: &Actuators<f32, AXES>) {
        self.give(if actuators.enable { f64::from(actuators.forces[0]) } else { 0.0 });
    }

    fn idle(&mut self) {
        self.give(0.0);
    }
}

/// A board that is armed by whoever speaks to it, as its operator would have armed it before, until this is dropped.
pub(super) struct Lab {
    handle: Handle,
    /// Its address, and where its flow goes.
    ends: [String; 2],
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

fn scene(set: &[&str]) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/board-device.toml");
    let set: Vec<String> = set.iter().map(|&setting| setting.to_owned()).collect();
    Scene::load(cohold_guest_laws::laws(), Some(&file), &set).expect("a scene")
}

impl Lab {
    /// Board `number` of this key, whose settings differ so from the scene's, with a hand that trembles.
    pub(super) fn start(key: &str, number: u8, set: &[&str], tremor_m: f64) -> Self {
        // A port that was free a moment ago may be another program's by now.
        let mut bound = std::iter::repeat_with(free).filter_map(|at| Some((UdpSocket::bind(&at).ok()?, at)));
        let (socket, own) = bound.next().expect("a free port");
        let ends = [own, free()];
        let key = key_file::read(Path::new(key), Role::Peers).expect("a key");
        let hand = Hand::new(tremor_m);
        let handle = Handle(Arc::new(Mutex::new(World { hand, fault: Fault::None, asked: Vec::new() })));
        let scene = scene(set);
        let entropy = key_file::entropy().expect("random bytes");
        let mut node = Node::<1, AXES, _>::with_device(&scene, number, key, entropy, Box::new(handle.clone()))
            .expect("a board")
            .telling_every(0.02);
        socket.set_nonblocking(true).expect("a socket");
        let (stop, held, to) = (Arc::new(AtomicBool::new(false)), handle.clone(), ends[1].clone());
        let until = stop.clone();
        let run = move || {
            realtime_beneath();
            let (begun, mut due, mut datagram) = (Instant::now(), Instant::now(), [0; 2048]);
            while !until.load(Ordering::Relaxed) {
                let now_us = begun.elapsed().as_micros() as u64;
                while let Ok((length, _)) = socket.recv_from(&mut datagram) {
                    let _ = node.receive(now_us, &mut datagram[..length]);
                }
                let fault = held.world().fault;
                node.halt(fault == Fault::Disarmed);
                let send = |bytes: &[u8]| {
                    if fault != Fault::Silent {
                        let _ = socket.send_to(bytes, &to);
                    }
                };
                node.tick(now_us, send);
                due += TICK;
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
            }
        };
        Self { handle, ends, stop, thread: Some(std::thread::spawn(run)) }
    }

    pub(super) fn world(&self) -> MutexGuard<'_, World> {
        self.handle.world()
    }

    /// What is said of it on a command line.
    pub(super) fn flags(&self, key: &str) -> Vec<String> {
        let device = format!("board:{}", self.ends[0]);
        let all = ["--device", &device, "--device-listen", &self.ends[1], "--device-key-file", key];
        all.map(str::to_owned).to_vec()
    }

    /// Mean force of the last so many seconds, N.
    pub(super) fn mean_n(&self, for_s: f64) -> f64 {
        let world = self.world();
        let now_s = world.hand.time_s();
        let last: Vec<f64> = world.asked.iter().filter(|(at, _)| *at > now_s - for_s).map(|(_, [n])| *n).collect();
        last.iter().sum::<f64>() / last.len() as f64
    }

    /// When a force acted last, s.
    fn last_force_s(&self) -> f64 {
        self.world().asked.iter().rev().find(|(_, force)| *force != [0.0]).expect("a force").0
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What a board's workspace makes the peer say.
const WITHIN: [&str; 2] = ["--set", "peer.1.safety.workspace_m=0.2"];
/// The other hand holds on; both are as the emulated one is.
const HANDS: [&str; 6] = [
    "user.2.push_n=0",
    "user.2.arm_stiffness_n_per_m=300",
    "user.2.arm_damping_n_s_per_m=8",
    "device.mass_kg=0.3",
    "device.damping_n_s_per_m=0",
    "user.1.arm_damping_n_s_per_m=8",
];

/// A peer at this board and another one, armed.
fn pair(lab: &Lab, key: &str, seconds: &str, more: &[&str]) -> [Running; 2] {
    let [one, two] = [free(), free()];
    let live = |number, listen: &str, connect: &str| {
        let mut command = cohold(&["peer", "--json", "--scene", "any-network", "--number", number, "--key-file", key]);
        command.args(["--listen", listen, "--connect", connect, "--seconds", seconds]).args(sets(&HANDS));
        command
    };
    let mut first = live("1", &one, &two);
    first.args(lab.flags(key)).args(WITHIN).args(more);
    let mut peers = [first, live("2", &two, &one)].map(Running::start);
    peers.iter_mut().for_each(|peer| peer.until(" s  armed, "));
    peers
}

/// Reaches, and waits until a force is felt.
fn reach(lab: &Lab) {
    lab.world().hand.reach([0.02]);
    std::thread::sleep(Duration::from_millis(1_500));
    let felt_n = lab.mean_n(0.1);
    assert!(felt_n < -1.0, "{felt_n} N");
}

/// Either board passes, by what it tells of the force that acts.
#[test]
fn a_board_passes_ten_steps() {
    let keys = Keys::new("board-steps", 0);
    for number in [1, 2] {
        let lab = Lab::start(&keys.file(0), number, &[], 0.0);
        let (passed, told, said) = steps(&lab.flags(&keys.file(0)), &[], |by_m| lab.world().hand.reach([by_m]));
        println!("{said}");
        assert!(passed && told["passed"].as_array().map(Vec::len) == Some(10), "{said}\n{told}");
        assert!(told["device"].as_str().is_some_and(|name| name.starts_with(&format!("board {number} at "))), "{told}");
    }
    // A board that does not let go in the time that its scene says is found.
    let lab = Lab::start(&keys.file(0), 1, &["safety.disengage_s=2"], 0.0);
    let (passed, _, said) = steps(&lab.flags(&keys.file(0)), &[], |by_m| lab.world().hand.reach([by_m]));
    assert!(!passed && said.contains("step 6, watchdog: "), "{said}");
}

/// The simulated hand that reaches as the one at the board does.
const REACHES: [&str; 4] =
    ["user.1.push_n=0", "user.1.arm_stiffness_n_per_m=300", "user.1.reach_m=0.02", "user.1.reach_s=1"];

/// How far apart the copies of two live peers were in the last half of 8 s over a lossy relay, mm, and by how much that may be wrong: the first has
/// these flags beside; `meanwhile` is done once both are armed.
fn apart_mm(key: &str, first: &[String], meanwhile: impl FnOnce()) -> [f64; 2] {
    let (one, two, between) = (free(), free(), [free(), free()]);
    let lossy = relay("any-network", 68.0, &between, [&one, &two], sets(&LOSSY));
    let live = |number, listen: &str, connect: &str| {
        let mut command = cohold(&["peer", "--json", "--scene", "any-network", "--number", number, "--key-file", key]);
        command
            .args(["--listen", listen, "--connect", connect, "--seconds", "8"])
            .args(sets(&LOSSY))
            .args(sets(&HANDS));
        command
    };
    let mut near = live("1", &one, &between[0]);
    near.args(first);
    let mut peers = [near, live("2", &two, &between[1])].map(Running::start);
    peers.iter_mut().for_each(|peer| peer.until(" s  armed, "));
    meanwhile();
    let found = peers.map(|peer| {
        let (ended, live, said) = peer.end();
        assert!(ended && live["fault"] == Value::Null, "{said}\n{live}");
        println!("{} ; {}", live["device"], live["punctuality"]);
        ["true_discrepancy_mm", "true_discrepancy_error_mm"].map(|key| number(&live, key))
    });
    signal(&lossy, "INT");
    println!("{}", report(lossy));
    found[0]
}

/// The hand at a board and a simulated one hold an object over a network that loses packets in bursts: no fault, no jump, what is felt is what the
/// springs between them give in statics, and the copies are as far apart as those of two simulated devices.
#[test]
fn a_board_and_a_simulated_device_hold_one_object() {
    let keys = Keys::new("board-pair", 0);
    let key = keys.file(0);
    let simulated: Vec<String> = sets(&REACHES).map(str::to_owned).collect();
    let [simulated_mm, _] = apart_mm(&key, &simulated, || {});
    let lab = Lab::start(&key, 1, &[], 0.0);
    let more = [&WITHIN[..], &["--device-silent-s", "0.2"]].concat().into_iter().map(str::to_owned);
    let flags: Vec<String> = lab.flags(&key).into_iter().chain(more).collect();
    let mut felt_n = 0.0;
    let [board_mm, error_mm] = apart_mm(&key, &flags, || {
        lab.world().hand.reach([0.02]);
        std::thread::sleep(Duration::from_secs(5));
        felt_n = lab.mean_n(1.0);
    });
    println!("{board_mm:.4} mm apart, with two simulated devices {simulated_mm:.4}; clocks ±{error_mm:.4}");
    assert!((board_mm / simulated_mm - 1.0).abs() <= 0.2, "{board_mm} mm, and not {simulated_mm}");
    // What the copies are apart, the springs are not stretched by.
    let wanted_n = -(0.02 - 1e-3 * board_mm) / (2.0 / HAND_N_PER_M + 2.0 / 1000.0);
    println!("{felt_n:.3} N at the board, {wanted_n:.3} N in statics");
    assert!((felt_n / wanted_n - 1.0).abs() < 0.05, "{felt_n} N, {wanted_n} N in statics");
    let step_n = largest_first_step(&lab.world().asked, 0.1);
    println!("largest step of the force in its first 100 ms {step_n:.4} N");
    assert!(step_n <= 0.05, "{step_n} N");
}

/// Through contacts so stiff, N/m, at a hand of 300 N/m, 8 N·s/m and 0.3 kg, what is felt comes to rest at what the springs give in statics; through
/// others as `BOARD_STIFFNESS` says.
#[test]
fn a_contact_through_a_board_comes_to_rest() {
    let keys = Keys::new("board-stiffness", 0);
    let all = std::env::var("BOARD_STIFFNESS").unwrap_or_else(|_| "1000".to_owned());
    for stiffness in all.split(',') {
        let lab = Lab::start(&keys.file(0), 1, &[], 0.0);
        let set = format!("peer.1.contact.stiffness_n_per_m={stiffness}");
        let [first, second] = pair(&lab, &keys.file(0), "10", &["--set", &set, "--anyway"]);
        lab.world().hand.reach([0.02]);
        // What a taut line takes back it takes slowly.
        std::thread::sleep(Duration::from_secs(8));
        let (mean_n, forces) = (lab.mean_n(1.0), lab.world().asked.clone());
        let last = &forces[forces.len() - 1_000..];
        let sway_n = (last.iter().map(|(_, [n])| (n - mean_n).powi(2)).sum::<f64>() / last.len() as f64).sqrt();
        let ((_, live, said), _) = (first.end(), second.end());
        let contact: f64 = stiffness.parse().expect("N/m");
        let wanted_n =
            -(0.02 - 1e-3 * number(&live, "true_discrepancy_mm")) / (2.0 / HAND_N_PER_M + 1.0 / contact + 1.0 / 1000.0);
        let trip = &live["device"]["round_trip"];
        println!("{stiffness} N/m: {mean_n:.3} N, {wanted_n:.3} N in statics, sways by {sway_n:.4} N (rms); {trip}");
        let rests = sway_n < 0.02 && (mean_n / wanted_n - 1.0).abs() < 0.05;
        assert!(live["fault"] == Value::Null && rests, "{stiffness} N/m: {mean_n} N, {sway_n} N\n{said}\n{live}");
    }
}

/// Whatever goes wrong at the board or on the way: no force there after the time that is stated, and both ends of the pair say why.
#[test]
fn each_fault_of_a_board_cuts_the_force_and_is_named() {
    let keys = Keys::new("board-faults", 0);
    let faults = [
        (Fault::Silent, 23, "ms old, of 50 allowed"),
        (Fault::Impossible, 25, "the board told a velocity that cannot be"),
        (Fault::Jump, 25, "moved by"),
        (Fault::OutOfWorkspace, 26, "the board's fault 13: "),
        (Fault::Disarmed, 24, "turned off at the board"),
    ];
    for (fault, numbered, words) in faults {
        // A speed that its peer does not believe is none that the board's own guard stops.
        let set: &[&str] = if fault == Fault::Impossible { &["safety.max_speed_m_per_s=10"] } else { &[] };
        let lab = Lab::start(&keys.file(0), 1, set, 1e-3);
        let [first, second] = pair(&lab, &keys.file(0), "60", &[]);
        reach(&lab);
        let failed_s = {
            let mut world = lab.world();
            world.fault = fault;
            world.hand.time_s()
        };
        let (ended, live, said) = first.end();
        let cause = live["fault"].as_str().unwrap_or_default().to_owned();
        assert!(!ended && cause.starts_with(&format!("fault {numbered}: ")) && cause.contains(words), "{said}\n{live}");
        signal(&second.child, "INT");
        let (_, live, said) = second.end();
        assert_eq!(fault_of(&live["other"]), Some(numbered), "{said}\n{live}");
        let after_s = lab.last_force_s() - failed_s;
        println!("{fault:?}: last force {:.1} ms after it; {cause}", 1e3 * after_s);
        assert!(after_s < SILENT_S + LADDER_S + BUSY_S, "{fault:?}: a force {after_s} s later");
    }
}

/// A process that is killed, or stopped, says nothing more: the board's own ladder lets go. One that goes on stays off.
#[test]
fn a_board_lets_go_when_its_peer_is_killed_or_stopped() {
    let keys = Keys::new("board-killed", 0);
    for name in ["KILL", "STOP"] {
        let lab = Lab::start(&keys.file(0), 1, &[], 1e-3);
        let [mut first, mut second] = pair(&lab, &keys.file(0), "60", &[]);
        reach(&lab);
        signal(&first.child, name);
        let stopped_s = lab.world().hand.time_s();
        std::thread::sleep(Duration::from_millis(300));
        let after_s = lab.last_force_s() - stopped_s;
        println!("SIG{name}: last force {:.1} ms after it", 1e3 * after_s);
        assert!(after_s < LADDER_S + BUSY_S, "SIG{name}: a force {after_s} s later");
        if name == "STOP" {
            signal(&first.child, "CONT");
            let (ended, live, said) = first.end();
            assert!(
                !ended && live["fault"].as_str().is_some_and(|why| why.starts_with("fault 29: ")),
                "{said}\n{live}"
            );
            assert_eq!(lab.last_force_s() - stopped_s, after_s, "no force on return");
        } else {
            let _ = first.child.wait();
        }
        second.child.kill().expect("a child");
        let _ = second.child.wait();
    }
}

/// Who may not be armed is refused by name, and told what to do.
#[test]
fn a_board_that_must_not_be_driven_is_refused_by_name() {
    let keys = Keys::new("board-refused", 0);
    let key = keys.file(0);
    let refusal = |flags: &[String], more: &[&str]| {
        let mut command = peer("any-network", "1", &free(), &free(), &key);
        let output = command.args(flags).args(more).output().expect("cohold runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success(), "{said}");
        said
    };
    let nobody = [format!("board:{}", free()), free()];
    let flags = ["--device", &nobody[0], "--device-listen", &nobody[1], "--device-key-file", &key].map(str::to_owned);
    let said = refusal(&flags, &[]);
    assert!(said.contains("does not answer, or holds another key"), "{said}");
    let said = refusal(&flags[..4], &[]);
    assert!(said.contains("it needs --device-key-file"), "{said}");
    let said = refusal(&flags, &["--device-scene", "any-network"]);
    assert!(said.contains("is not that of a device"), "{said}");
    let lab = Lab::start(&key, 1, &["four_channel.remote_force=0.5"], 0.0);
    let said = refusal(&lab.flags(&key), &[]);
    assert!(said.contains("was told other parameters: table ["), "{said}");
    let lab = Lab::start(&key, 1, &[], 0.0);
    lab.world().fault = Fault::Disarmed;
    let said = refusal(&lab.flags(&key), &[]);
    assert!(said.contains("has its motors off: arm it"), "{said}");
}
