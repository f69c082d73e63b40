//! What goes wrong with a device, through the whole simulator: which fault latches, and how soon.

use cohold_core::device::{AXES, motor::Duty};
use cohold_core::num::Motion;
use cohold_core::peer::Actuators;
use cohold_core::safety::{Fault, Mode};
use cohold_sim::Laws;
use cohold_sim::pair::Pair;
use cohold_sim::plant::Plant;
use cohold_sim::scene::{PlantFault, Scene};
use cohold_sim::scenes;

/// Two devices with encoders and motors in current loops; the first one's user pushes with 3 N at 3 Hz, which is 0.22 m/s at the most.
const DEVICE: [&str; 7] = [
    "plant.encoder=true",
    "plant.motor=true",
    "plant.winding=true",
    "plant.drive=current",
    "axis.velocity=adaptive",
    "user.1.sine_n=3",
    "user.1.sine_rad_per_s=19",
];
/// What a board with its default settings has.
const GENTLE: [&str; 2] = ["safety.max_force_n=3", "safety.max_slew_n_per_s=60"];

fn scene(keys: &[&str]) -> Scene {
    let keys: Vec<String> = DEVICE.iter().chain(keys).map(|key| key.to_string()).collect();
    Scene::load(Laws::built_in(), None, &keys).expect("a good scene")
}

/// The tick at which device 1 faults, and why.
fn faults(scene: &Scene, ticks: u64) -> Option<(u64, Fault)> {
    let mut pair = Pair::<f32>::new(scene).expect("a good scene");
    (0..ticks).find_map(|tick| {
        pair.step();
        match pair.sides()[0].peer.mode() {
            Mode::Faulted(fault) => Some((tick, fault)),
            _ => None,
        }
    })
}

/// Ticks from the fault of the plant, at half a second and 0.15 m/s, until device 1 faults, and why; none in another second.
fn first_fault(fault: &str, keys: &[&str]) -> Option<(u64, Fault)> {
    let fault = format!("plant.fault={fault}");
    let found = faults(&scene(&[&["plant.fault_at_s=0.5", fault.as_str()], keys].concat()), 1500);
    found.map(|(tick, fault)| (tick.checked_sub(500).expect("not before it began"), fault))
}

#[test]
fn what_goes_wrong_is_told_by_name_and_soon() {
    for limits in [&[][..], &GENTLE] {
        assert_eq!(first_fault("none", limits), None);
        for (what, fault, within_ms) in [
            ("open-motor", Fault::CurrentNotFollowed, 6),
            ("dead-sense", Fault::CurrentNotFollowed, 6),
            ("sense-at-end", Fault::CurrentSensor, 4),
            ("low-supply", Fault::SupplyOutOfRange, 12),
            ("high-supply", Fault::SupplyOutOfRange, 12),
            ("encoder-stuck", Fault::EncoderImplausible, 12),
            ("encoder-dithers", Fault::EncoderImplausible, 12),
            ("encoder-reversed", Fault::EncoderImplausible, 6),
            ("encoder-without-a", Fault::EncoderWire, 6),
            ("encoder-without-b", Fault::EncoderWire, 6),
            // Half of 0.22 m/s is 0.88 V, where 0.73 V are tolerated: not before the motion is at its fastest, of which gentle limits hold less up.
            ("encoder-halved", Fault::EncoderImplausible, 600),
        ] {
            let (ticks, found) = first_fault(what, limits).unwrap_or_else(|| panic!("{what} is not told"));
            assert!(found == fault && ticks <= within_ms, "{what}: {found:?} after {ticks} ms, {limits:?}");
        }
    }
}

/// The device comes back through its index within a third of a second: 40 counts are not to be found there.
#[test]
fn lost_counts_are_told_by_the_index() {
    assert_eq!(first_fault("encoder-loses", &[]), None, "no index, and a step of 40 counts in a tick is 0.2 m/s");
    let index = ["encoder.index=true", "encoder.index_at_m_or_rad=0.002", "user.1.arm_stiffness_n_per_m=100"];
    assert_eq!(first_fault("none", &index), None);
    let (ticks, fault) = first_fault("encoder-loses", &index).expect("told");
    assert!(fault == Fault::LostCounts && ticks < 350, "{ticks} {fault:?}");
    // A joint that turns has an index in every turn.
    let turning = [
        "kinematics.model=capstan",
        "encoder.index=true",
        "kinematics.capstan_ratio=40",
        "motor.newton_or_newton_metre_per_a=0.016",
    ];
    assert_eq!(first_fault("none", &turning), None);
    let (ticks, fault) = first_fault("encoder-loses", &turning).expect("told");
    assert!(fault == Fault::LostCounts && ticks < 300, "{ticks} {fault:?}");
}

/// A device that is held against a partner's push of 5 N, which sets the object swinging: 5 N·(1 − cos), a mean square of 37.5 N² and
/// 0.586 A², six times what a motor of 0.3125 A bears. It gives way, and nothing ends.
#[test]
fn a_motor_that_is_held_gives_way() {
    let keys = [
        "plant.fault_at_s=0",
        "user.1.sine_n=0",
        "user.2.push_n=5",
        "motor.continuous_a=0.3125",
        "motor.thermal_s=2",
        "safety.stuck_duty=0.5",
    ];
    let scene = scene(&[&["plant.fault=held"], &keys[..]].concat());
    let mut pair = Pair::<f32>::new(&scene).expect("a good scene");
    let (mut mean, mut most) = (0.0_f64, 0.0_f64);
    for _ in 0..30_000 {
        pair.step();
        let peer = &pair.sides()[0].peer;
        assert_eq!(peer.mode(), Mode::Armed);
        let amperes = f64::from(peer.observed()[0].contact_force) / scene.peer.motor.newton_or_newton_metre_per_a;
        mean += (amperes.powi(2) - mean) * 1e-3 / scene.peer.motor.thermal_s;
        most = most.max(mean);
    }
    let borne = scene.peer.motor.continuous_a.powi(2);
    assert!((0.8 * borne..borne).contains(&mean) && most < borne, "{mean} A², at most {most}, of {borne}");
}

/// With the motors off.
#[test]
fn a_bridge_that_conducts_although_it_is_off() {
    let scene = scene(&["user.1.sine_n=0"]);
    let (mut plant, mut peer) =
        (Plant::new(&scene, 0), scene.peer_from::<f32, 1, AXES>(0, [Motion::REST; AXES]).expect("good"));
    let mut ticks = |plant: &mut Plant, most: u32| {
        (1..=most).find(|_| {
            let actuators: Actuators<f32> = peer.tick(&plant.sensors());
            assert!(!actuators.enable && actuators.duties == [Duty::OFF; AXES]);
            plant.step(0.0, &actuators);
            peer.mode() == Mode::Faulted(Fault::CurrentSensor)
        })
    };
    assert_eq!(ticks(&mut plant, 100), None);
    plant.fail(PlantFault::ConductingBridge);
    assert!(ticks(&mut plant, 100).is_some_and(|ticks| ticks <= 13));
}

/// Every bundled scene with such devices, and with duties that are forces and no power stage; at a hand's limits and at its own, soft
/// and in hard contact; with dead time, copper that is 60 K warmer or cold, and a network of another seed each.
#[test]
fn no_good_device_is_doubted() {
    let [encoder, motor, winding, current, velocity, ..] = DEVICE;
    let [force, slew] = GENTLE;
    let mut runs = 0;
    for (name, _) in scenes::known() {
        for (seed, keys) in [
            (1, &[winding, current, "plant.resistance_ratio=1.24"][..]),
            (2, &[winding, current, force, slew]),
            (3, &[winding, current, "plant.resistance_ratio=0.85", "contact.stiffness_n_per_m=4000"]),
            (4, &["plant.winding=false", "plant.drive=voltage"]),
            (5, &["plant.winding=false", "plant.drive=voltage", force, slew]),
            // Stiffer, it chatters between these limits within a count.
            (6, &["plant.winding=false", "plant.drive=voltage", force, "contact.stiffness_n_per_m=1500"]),
        ] {
            let mut scene = scenes::load(Laws::built_in(), name).expect("built in");
            let seed = format!("network.seed={seed}");
            let spoilt = ["plant.dead_time_s=5e-7", "plant.coulomb_n=0.05", "safety.saturated_ticks=10000"];
            let common = [encoder, motor, velocity, spoilt[0], spoilt[1], spoilt[2], seed.as_str()];
            for key in common.iter().chain(keys) {
                scene.apply_override(key).expect("a good key");
            }
            if scene.check(name).is_err() {
                continue;
            }
            runs += 1;
            if let Some((tick, fault)) = faults(&scene, 3000) {
                let doubted = [8, 16, 17, 18, 19, 20, 21, 22].contains(&fault.number());
                assert!(!doubted, "{name}, {seed}, {keys:?}: {fault:?} after {tick} ms");
            }
        }
    }
    assert!(runs > 60, "{runs}");
}

/// Without a power stage, at a hand's limits: 1.5 N of change, 25 ms at 60 N/s, and up to 8 ms more; the force begins to rise soon.
#[test]
fn a_stuck_encoder_without_a_power_stage() {
    let keys = [&GENTLE[..], &["plant.winding=false", "plant.drive=voltage", "safety.saturated_ticks=10000"]].concat();
    assert_eq!(first_fault("none", &keys), None);
    for what in ["encoder-stuck", "encoder-dithers"] {
        let (ticks, fault) = first_fault(what, &keys).expect("told");
        assert!(fault == Fault::EncoderStuck && ticks <= 40, "{what}: {fault:?} after {ticks} ms");
    }
}
