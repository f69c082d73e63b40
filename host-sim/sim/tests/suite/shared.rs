//! Objects shared along two and three axes: where nothing couples the axes, each is a run of one axis, to the bit.

use cohold_columns::Columns;
use cohold_sim::Laws;
use cohold_sim::pair::{HASH_SEED, Pair};
use cohold_sim::peers::Builds;
use cohold_sim::run::{self, AxisOutcome, Options, Outcome};
use cohold_sim::scene::Scene;
use cohold_sim::{Plant, scenes};

const RECORDED: Options = Options { duration_s: 1.5, record_every: 1 };

/// A scene of the law with these keys on top; it may be of several axes.
fn scene(keys: &[&str]) -> Scene {
    let mut scene = Scene::new(Laws::built_in());
    for key in ["object.force_delay_ticks=0", "coordination.decode=implicit", "user.1.push_n=1", "user.2.sine_n=0.5"] {
        scene.apply_override(key).expect("a good key");
    }
    keys.iter().for_each(|key| scene.apply_override(key).unwrap_or_else(|error| panic!("{key}: {error}")));
    scene.check("test").unwrap_or_else(|error| panic!("{error}"));
    scene
}

fn bits(table: &Columns) -> Vec<u64> {
    let columns = run::Account::columns().map(|(name, _)| table.column(&name).expect("recorded").to_vec());
    columns.flatten().map(f64::to_bits).collect()
}

/// The one axis of which the shares of both users' forces are these.
fn alone(of_several: &Scene, axis: usize) -> Outcome {
    let mut scene = of_several.clone();
    (scene.peer.axis.count, scene.peer.axis.shared) = (1, 1);
    for user in &mut scene.users {
        let share = user.direction()[axis];
        let profile = &mut user.settings.user;
        profile.push_n *= share;
        profile.sine_n *= share;
        (profile.direction_rad, profile.elevation_rad) = (0.0, 0.0);
    }
    run::run::<f32>(&scene, RECORDED, &|_| ()).expect("a good scene")
}

#[test]
fn each_axis_is_a_run_of_one_to_the_bit() {
    let angles = ["user.1.direction_rad=0.7", "user.1.elevation_rad=0.4", "user.2.direction_rad=-1.9"];
    for axes in ["2", "3"] {
        for law in ["power", "wave", "passive-wave", "passive-mean", "self-timed"] {
            let mut keys = vec!["coordination.stiffness_n_per_m=300", "network.jitter_s=0.004", "network.loss=0.1"];
            let set = [format!("axis.count={axes}"), format!("axis.shared={axes}"), format!("coordination.comm={law}")];
            keys.extend(set.iter().map(String::as_str));
            keys.extend(angles);
            if law == "self-timed" {
                keys.push("object.integrator=midpoint");
            }
            let scene = scene(&keys);
            let several = run::run::<f32>(&scene, RECORDED, &|_| ()).expect("a good scene");
            assert_eq!(several.axes.len().to_string(), axes);
            for (axis, outcome) in several.axes.iter().enumerate() {
                let alone = alone(&scene, axis);
                assert_eq!(bits(&outcome.table), bits(&alone.axes[0].table), "{law}, axis {axis} of {axes}");
                let peaks = [outcome.figures, alone.whole].map(|figures| figures.peak_coordination_force_n);
                assert!(peaks[0] > 0.0 || axis == 2 && peaks[1] == 0.0);
            }
        }
    }
}

/// What a caller pulls with along each axis is what a user would push with there, to the bit, where joints couple the axes as well.
#[test]
fn pulls_along_every_axis_are_a_users_pushes() {
    fn same<const AXES: usize>(name: &str)
    where
        f32: Builds<AXES, AXES>,
    {
        let mut pushed = scenes::load(Laws::built_in(), name).expect("built in");
        pushed.users[0].settings.user.push_n = 0.75;
        let mut nobody = pushed.clone();
        nobody.users.iter_mut().for_each(|user| user.settings.user.push_n = 0.0);
        let run =
            run::run::<f32>(&pushed, Options { duration_s: 0.5, record_every: 0 }, &|_| ()).expect("a good scene");
        let mut pair = Pair::<f32, Plant<AXES>, AXES, AXES>::build(&nobody).expect("a good scene");
        for ((side, user), toward) in pair.sides_mut().zip(&pushed.users).zip([1.0, -1.0]) {
            let (direction, push_n) = (user.direction(), toward * user.settings.user.push_n);
            side.plant.pull(std::array::from_fn(|axis| direction[axis] * push_n));
        }
        let hash = (0..run.ticks).fold(HASH_SEED, |hash, _| {
            pair.step();
            pair.hash(hash)
        });
        assert_eq!(hash, run.hash, "{name}");
    }
    same::<2>("plane");
    same::<3>("space");
}

/// A leader and a follower that are scaled unlike, pressed on along every axis at once. At rest the chain from hand to hand is springs: the
/// follower's arm, 1/(k₂·s_f₂/s_p₂) in the world, both contacts and the coordination; beside it the leader's own arm. So along each axis
///
/// > x₁ = s_f₁·F/(1/C + k₁·s_f₁/s_p₁),   C = s_p₂/(k₂·s_f₂) + 2/K_LC + 1/K_T,   contact force x₁/C, device of the hand x₁/s_p₁.
#[test]
fn scales_hold_along_every_shared_axis() {
    let (stiffness, [k1, k2]) = (300.0, [40.0, 60.0]);
    let [(p1, f1), (p2, f2)] = [(3.0, 2.0), (0.5, 1.5)];
    let own = [
        ("coordination.stiffness_n_per_m", stiffness),
        ("user.1.arm_stiffness_n_per_m", k1),
        ("user.1.arm_damping_n_s_per_m", 5.0),
        ("user.2.arm_stiffness_n_per_m", k2),
        ("user.2.arm_damping_n_s_per_m", 5.0),
        ("user.2.sine_n", 0.0),
        ("peer.1.scale.position", p1),
        ("peer.1.scale.force", f1),
        ("peer.2.scale.position", p2),
        ("peer.2.scale.force", f2),
        ("user.1.direction_rad", 0.7),
        ("user.1.elevation_rad", 0.4),
    ]
    .map(|(key, value)| format!("{key}={value}"));
    let held = ["coordination.comm=power", "object.integrator=midpoint"];
    for axes in [2, 3] {
        let count = [format!("axis.count={axes}"), format!("axis.shared={axes}")];
        let keys: Vec<&str> = held.into_iter().chain(own.iter().chain(&count).map(String::as_str)).collect();
        let scene = scene(&keys);
        let whole = Options { duration_s: 20.0, record_every: 1000 };
        let run = run::run::<f64>(&scene, whole, &|_| ()).expect("a good scene");
        let compliance = p2 / (k2 * f2) + 2.0 / scene.peer.contact.stiffness_n_per_m + 1.0 / stiffness;
        for (axis, (outcome, share)) in run.axes.iter().zip(scene.users[0].direction()).enumerate() {
            let last = |name: &str| *outcome.table.column(name).expect("recorded").last().expect("rows");
            let (position, force) = (last("device_1_m"), last("contact_1_n"));
            let wanted = f1 * share / (1.0 / compliance + k1 * f1 / p1);
            assert!(run.fault.is_none() && (position / wanted - 1.0).abs() < 1e-6, "{axis}: {position}, not {wanted}");
            let wanted = wanted / compliance;
            assert!((force / wanted - 1.0).abs() < 1e-6, "{axis} of {axes}: {force} N, not {wanted}");
        }
    }
}

/// Down to encoders and motors the axes of a mechanism are coupled by its geometry alone, and hardly where it stays near home.
#[test]
fn mechanisms_with_all_axes_shared_come_near_to_exact_ones() {
    for (axes, mechanism) in [("2", "five-bar"), ("3", "arm")] {
        let (count, share, model) =
            (format!("axis.count={axes}"), format!("axis.shared={axes}"), format!("kinematics.model={mechanism}"));
        let keys = [
            "coordination.comm=passive-mean",
            "coordination.stiffness_n_per_m=1000",
            "object.integrator=midpoint",
            "user.1.direction_rad=0.6",
            "user.1.elevation_rad=0.5",
            "user.2.push_n=1",
            "user.2.direction_rad=0.6",
            "user.2.elevation_rad=0.5",
            "axis.velocity=filtered",
            &count,
            &share,
        ];
        let exact = scene(&keys);
        let device = ["plant.encoder=true", "plant.motor=true", "motor.newton_or_newton_metre_per_a=0.5", &model];
        let real = scene(&[&keys[..], &device].concat());
        let [exact, real] = [&exact, &real].map(|scene| {
            let run = run::run::<f32>(scene, RECORDED, &|_| ()).expect("a good scene");
            assert!(run.fault.is_none(), "{mechanism}: {:?}", run.reason);
            run
        });
        for (axis, (exact, real)) in exact.axes.iter().zip(&real.axes).enumerate() {
            let path = |along: &AxisOutcome| along.table.column("object_1_m").expect("recorded").to_vec();
            let (exact, real) = (path(exact), path(real));
            let most = exact.iter().fold(0.0_f64, |most, at| most.max(at.abs()));
            let off = exact.iter().zip(&real).fold(0.0_f64, |most, (one, two)| most.max((one - two).abs()));
            assert!(most > 1e-4 && off < 0.1 * most, "{mechanism}, axis {axis}: {off} of {most}");
        }
    }
}

#[test]
fn what_cannot_be_shared_is_refused_by_name() {
    let refused = |keys: &[&str]| {
        let mut scene = Scene::new(Laws::built_in());
        keys.iter().for_each(|key| scene.apply_override(key).expect("a good key"));
        scene.check("test").unwrap_err().to_string()
    };
    assert_eq!(
        refused(&["axis.count=3", "axis.shared=2"]),
        "test: axis.count = 3 is not allowed: it must be axis.shared where that is more than 1: a simulated device shares all of \
         its axes"
    );
    assert!(
        refused(&["axis.shared=2"]).contains("axis.shared = 2 is not allowed: it must be a whole number from 1 to 1")
    );
    assert!(refused(&["axis.count=2", "axis.shared=2", "contact.one_sided=true"]).contains("contact.one_sided = true"));
    assert!(
        refused(&["axis.count=3"])
            .contains("axis.count = 3 is not allowed: it must be 1 or 2, or 3 with axis.shared = 3")
    );
    let several = scene(&["axis.count=2", "axis.shared=2"]);
    assert!(Pair::<f32>::new(&several).is_err());
}

/// At rest what user 2 pushes with is all that crosses the line, and user 1's arm alone holds it, so that along each axis
///
/// > F_T = −P·w₂,   x₁ = r·w₁ − P·w₂/k₁,   P = 0.5 N, r = 30 mm, k₁ = 300 N/m, w the direction of a user.
///
/// What a mechanism's mass couples dies away before. Without encoders and motors, which put the copies a count from there.
#[test]
fn the_scenes_of_a_plane_and_of_space_balance_along_every_axis() {
    let (push_n, reach_m, stiffness) = (0.5, 0.03, 300.0);
    for (name, axes) in [("plane", 2), ("space", 3)] {
        let mut scene = scenes::load(Laws::built_in(), name).expect("built in");
        for key in ["plant.encoder=false", "plant.motor=false", "plant.winding=false", "axis.velocity=measured"] {
            scene.apply_override(key).expect("a good key");
        }
        let run = run::run::<f64>(&scene, Options { duration_s: 20.0, record_every: 1000 }, &|_| ());
        let run = run.expect("a good scene");
        assert!(run.is_stable() && run.axes.len() == axes, "{name}");
        let directions = scene.users.each_ref().map(|user| user.direction());
        for (axis, outcome) in run.axes.iter().enumerate() {
            let last = |name: &str| *outcome.table.column(name).expect("recorded").last().expect("rows");
            let wanted = [
                -push_n * directions[1][axis],
                reach_m * directions[0][axis] - push_n * directions[1][axis] / stiffness,
            ];
            let [force, place] = [-last("coordination_2_n"), last("device_1_m")];
            assert!((force / wanted[0] - 1.0).abs() < 1e-4, "{name}, axis {axis}: {force} N, not {}", wanted[0]);
            assert!((place / wanted[1] - 1.0).abs() < 1e-4, "{name}, axis {axis}: {place} m, not {}", wanted[1]);
        }
        assert!(run.energy_made_mj() <= 1e-6, "{name}");
    }
}
