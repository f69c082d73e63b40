//! Devices that live in their joints: a hand of mass alone moves as without a mechanism, joints that weigh keep their energy, and what the
//! links do not reach is refused, or is a stop.

use cohold_core::num::Motion;
use cohold_core::peer::Actuators;
use cohold_sim::run::{self, Options, Outcome};
use cohold_sim::scene::Scene;
use cohold_sim::{Laws, Plant, scenes};

fn scene(keys: &[&str]) -> Scene {
    let mut scene = Scene::new(Laws::built_in());
    keys.iter().for_each(|key| scene.apply_override(key).unwrap_or_else(|error| panic!("{key}: {error}")));
    scene.check("test").unwrap_or_else(|error| panic!("{error}"));
    scene
}

const PLANE: [&str; 4] = ["axis.count=2", "axis.shared=2", "kinematics.distal_m=0.14", "kinematics.left_home_rad=2.4"];
const SPACE: [&str; 2] = ["axis.count=3", "axis.shared=3"];
const HELD: [&str; 4] =
    ["user.1.arm_stiffness_n_per_m=200", "user.1.arm_damping_n_s_per_m=3", "user.1.reach_m=0.02", "user.1.push_n=0.4"];

/// Where the hand goes in so many ticks, under its user's forces and those of motors, as strong as this (N), that come and go.
fn path<const N: usize>(scene: &Scene, ticks: u32, motor_n: f64) -> Vec<[Motion<f64>; N]> {
    let mut plant = Plant::<N>::build(scene, 0);
    let step = |tick: u32| {
        let time_s = 1e-3 * f64::from(tick);
        let forces = std::array::from_fn(|axis| motor_n * (7.0 * time_s + axis as f64).sin());
        plant.step(time_s, &Actuators::<f64, N> { forces, ..Actuators::default() });
        plant.motions()
    };
    (0..ticks).map(step).collect()
}

/// What weighs at the hand alone knows nothing of the links that hold it: the exact linear plant is the oracle. Motors are torques through a
/// tick, and their forces turn with the pose.
#[test]
fn a_mass_at_the_hand_moves_as_without_a_mechanism() {
    fn compare<const N: usize>(axes: &[&str], model: &str) {
        let model = format!("kinematics.model={model}");
        let directions = ["user.1.direction_rad=0.7", "user.1.elevation_rad=0.3"];
        let common = [axes, &HELD, &directions, &["device.force_delay_ticks=0.4"]].concat();
        let (direct, turning) = (scene(&common), scene(&[&common[..], &[&model]].concat()));
        for (motor_n, within) in [(0.0, 1e-7), (0.5, 1e-4)] {
            let [direct, turning] = [&direct, &turning].map(|scene| path::<N>(scene, 2000, motor_n));
            let most = direct.iter().flatten().map(|axis| axis.position.abs()).fold(0.0, f64::max);
            let off = direct.iter().flatten().zip(turning.iter().flatten());
            let off = off.map(|(one, other)| (one.position - other.position).abs()).fold(0.0, f64::max);
            assert!(most > 0.01 && off < within * most, "{model}, {motor_n} N: {off} m of {most} m");
        }
    }
    compare::<2>(&PLANE, "five-bar");
    compare::<3>(&SPACE, "arm");
}

/// Joint angles of the arm by two triangles, not by Newton's method.
fn angles([x, y, z]: [f64; 3], [upper, fore]: [f64; 2]) -> [f64; 3] {
    let (level, up) = (x.hypot(z + upper), y - fore);
    let cosine = (level * level + up * up - upper * upper - fore * fore) / (2.0 * upper * fore);
    let bend = -cosine.acos();
    let lift = up.atan2(level) - (fore * bend.sin()).atan2(upper + fore * bend.cos());
    [x.atan2(z + upper), lift, lift + bend + core::f64::consts::FRAC_PI_2]
}

/// Pushed and let go, without damping: ½m·ẋ² + ½J_m·q̇² stays to the end, although the hand's way is no straight line.
#[test]
fn joints_that_weigh_keep_their_energy() {
    let inertia = 5e-4;
    let joints = format!("device.joint_inertia={inertia}");
    let free = ["kinematics.model=arm", "device.damping_n_s_per_m=0", &joints];
    let mut plant = Plant::<3>::build(&scene(&[&SPACE[..], &free].concat()), 0);
    let off = Actuators::<f64, 3>::default();
    plant.pull([0.4, 0.25, -0.3]);
    (0..60).for_each(|_| plant.step(0.0, &off));
    plant.pull([0.0; 3]);
    let (mut energies, mut turned) = (Vec::new(), Vec::new());
    for _ in 0..400 {
        plant.step(0.0, &off);
        let hand = plant.motions();
        turned.push(angles(hand.map(|axis| axis.position), [0.1, 0.12]));
        energies.push(hand.iter().map(|axis| 0.05 * axis.velocity.powi(2)).sum::<f64>());
    }
    // Speeds of the joints from where they were a tick before and after, by two differences against the error of one.
    let total = |at: usize| {
        let speed = |joint: usize| {
            let apart = |ticks: usize| turned[at + ticks][joint] - turned[at - ticks][joint];
            (8.0 * apart(1) - apart(2)) / 12e-3
        };
        energies[at] + (0..3).map(|joint| 0.5 * inertia * speed(joint).powi(2)).sum::<f64>()
    };
    let first = total(2);
    let worst = (2..398).map(|at| (total(at) / first - 1.0).abs()).fold(0.0, f64::max);
    let at_hand = (energies[397] / energies[2] - 1.0).abs();
    assert!(worst < 1e-6 && at_hand > 1e-3, "{worst}, at the hand alone {at_hand}");
}

/// Pulled out for a second with 5 N the hand stops where both links are in line, and comes back when it is pushed.
#[test]
fn links_that_are_stretched_are_a_stop() {
    let scene = scene(&[&PLANE[..], &["kinematics.model=five-bar", "device.joint_inertia=2e-4"]].concat());
    let mut plant = Plant::<2>::build(&scene, 0);
    let off = Actuators::<f64, 2>::default();
    let mut go = |force_n: f64| {
        plant.pull([0.0, force_n]);
        (0..1000).for_each(|_| plant.step(0.0, &off));
        plant.motions()[1]
    };
    let out = go(5.0);
    // Home is 182 mm from the left motor, and 240 mm are both links.
    assert!(out.velocity == 0.0 && (0.03..0.06).contains(&out.position), "{out:?}");
    assert!(go(-1.0).position < out.position - 0.02);
}

/// The scene `plane` as it was: its hand was sent where its links do not meet, and it was called stable.
#[test]
fn where_links_do_not_reach_a_scene_is_refused_by_name() {
    let refused = |name: &str, keys: &[&str]| {
        let mut scene = scenes::load(Laws::built_in(), name).expect("built in");
        keys.iter().for_each(|key| scene.apply_override(key).expect("a good key"));
        scene.check("test").expect_err("beyond").to_string()
    };
    let said = refused("plane", &["kinematics.distal_m=0.12", "kinematics.left_home_rad=1.5708"]);
    for part in [
        "user.1.reach_m = 0.03 is not allowed with kinematics.model = \"five-bar\"",
        "at (22.9, 19.3) mm from home the left leg would have to span 236",
        "mm and is 220.0 mm long, stretched; in this direction it must be at most 0.0",
    ] {
        assert!(said.contains(part), "{said}");
    }
    let said = refused("space", &["user.1.reach_m=0.2"]);
    assert!(said.contains("user.1.reach_m = 0.2 ") && said.contains("the arm would have to span"), "{said}");
    let said = refused("space", &["safety.workspace_m=0.02"]);
    assert!(said.contains("with safety.workspace_m = 0.02: it leads 20.1 mm from home along an axis"), "{said}");
    // What it says is allowed, is.
    let most = said.rsplit("at most ").next().and_then(|most| most.split(' ').next()).expect("a length").to_owned();
    let mut scene = scenes::load(Laws::built_in(), "space").expect("built in");
    for key in ["safety.workspace_m=0.02".to_owned(), format!("user.1.reach_m={most}")] {
        scene.apply_override(&key).expect("a good key");
    }
    scene.check("test").expect("within");
}

const EXACT: [&str; 4] = ["plant.encoder=false", "plant.motor=false", "plant.winding=false", "axis.velocity=measured"];

fn ran(name: &str, keys: &[&str], duration_s: f64) -> Outcome {
    let mut scene = scenes::load(Laws::built_in(), name).expect("built in");
    keys.iter().for_each(|key| scene.apply_override(key).expect("a good key"));
    scene.check(name).expect("a good scene");
    run::run::<f32>(&scene, Options { duration_s, record_every: 0 }, &|_| ()).expect("a good scene")
}

/// With encoders, motors, windings and current loops, for 20 s: what that adds to how far the copies are apart.
#[test]
fn a_plane_and_space_run_through_encoders_and_motors() {
    // A tenth of 2/K_T + T/b a newton: the rest is taken back.
    for (name, exact_mm, real_mm) in [("plane", 0.0234, 0.0234), ("space", 0.0234, 0.0234)] {
        let [exact, real] = [&EXACT[..], &[]].map(|keys| ran(name, keys, 20.0));
        let figures = [&exact, &real].map(|run| {
            assert!(run.is_stable() && run.fault.is_none(), "{name}: {:?}", run.reason);
            run.whole.true_discrepancy_mm
        });
        println!(
            "{name}: {figures:?} mm, at most {:?} mm",
            [&exact, &real].map(|run| run.whole.largest_true_discrepancy_mm)
        );
        let near = |found: f64, wanted: f64| (found / wanted - 1.0).abs() < 0.1;
        assert!(near(figures[0], exact_mm) && near(figures[1], real_mm), "{name}: {figures:?} mm");
    }
}
