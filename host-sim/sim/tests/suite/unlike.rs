//! Two ends that are unlike: scales, masses, and keys that one end alone is configured with.

use cohold_core::num::Motion;
use cohold_core::peer::Actuators;
use cohold_sim::peers::Laws;
use cohold_sim::scene::Scene;
use cohold_sim::{pair::Pair, plant::Plant, scenes};

fn with(name: &str, keys: &[&str]) -> Scene {
    let overrides: Vec<String> = keys.iter().map(|key| (*key).to_owned()).collect();
    scenes::find(Laws::built_in(), Some(name.as_ref()), &overrides).unwrap()
}

/// A scaled device is one of m·s_f/s_p and b·s_f/s_p in the world, under its user's force times s_f.
#[test]
fn a_scaled_pair_is_in_the_world_the_pair_of_the_devices_that_it_is_like() {
    let does = ["user.1.push_n=0.6", "user.2.push_n=0.3", "user.2.sine_n=0.2", "user.1.arm_damping_n_s_per_m=2"];
    let scaled = with(
        "any-network",
        &[&does[..], &["peer.1.scale.position=4", "peer.1.scale.force=2", "peer.2.scale.position=0.25"]].concat(),
    );
    let like = with(
        "any-network",
        &[
            "peer.1.device.mass_kg=0.05",
            "peer.1.device.damping_n_s_per_m=0.5",
            "peer.2.device.mass_kg=0.4",
            "peer.2.device.damping_n_s_per_m=4",
            "user.1.push_n=1.2",
            "user.2.push_n=0.3",
            "user.2.sine_n=0.2",
            "user.1.arm_damping_n_s_per_m=1",
        ],
    );
    let [mut scaled, mut like] = [scaled, like].map(|scene| Pair::<f64>::new(&scene).unwrap());
    for tick in 0..3000 {
        scaled.step();
        like.step();
        for (one, other) in scaled.sides().iter().zip(like.sides()) {
            let (one, other) = (one.peer.observed()[0], other.peer.observed()[0]);
            let error = (one.object.position - other.object.position).abs()
                + (one.device.position - other.device.position).abs()
                + 1e-3 * (one.contact_force - other.contact_force).abs();
            assert!(error < 1e-9, "tick {tick}: {one:?} {other:?}");
        }
    }
    let [one, _] = scaled.sides();
    let [like, _] = like.sides();
    let ([here, _], [there, _]) = (one.plant.motions(), like.plant.motions());
    assert!((4.0 * here.position - there.position).abs() < 1e-9 && here.position.abs() > 1e-3);
}

#[test]
fn one_end_alone_is_told_its_own_and_says_so() {
    let scene = with("any-network", &["peer.2.device.mass_kg=5", "peer.1.safety.max_force_n=3", "device.mass_kg=0.2"]);
    assert_eq!(scene.devices().map(|device| device.mass_kg), [0.2, 5.0]);
    assert_eq!(scene.peers().map(|peer| peer.safety.max_force_n), [3.0, 40.0]);
    // What a file of results says is the scene again, whatever the order.
    let configured: Vec<String> = scene.settings().into_iter().map(|(key, value)| format!("{key}={value}")).collect();
    let again = Scene::load(Laws::built_in(), None, &configured).unwrap();
    assert_eq!(again.fingerprint(), scene.fingerprint());
    assert_eq!(again.devices(), scene.devices());
    assert_ne!(scene.fingerprint(), with("any-network", &["device.mass_kg=0.2"]).fingerprint());
    // In a table of its own, too.
    let mut toml = Scene::new(Laws::built_in());
    toml.apply("[peer.2.device]\nmass_kg = 5.0\n", "scene", None).unwrap();
    assert_eq!(toml.devices()[1].mass_kg, 5.0);
}

#[test]
fn what_both_must_be_told_alike_is_refused_of_one() {
    for (key, said) in [
        (
            "peer.2.object.mass_kg=1",
            "there is no key peer.2.object.mass_kg; what one end alone may be told is peer.1. or peer.2.",
        ),
        ("peer.3.device.mass_kg=1", "there is no key peer.3.device.mass_kg"),
        (
            "peer.2.device.mass_kg=-1",
            "peer.2.device.mass_kg = -1 is not allowed: it must be a number from 0.0001 to 1000 kg",
        ),
        ("peer.1.scale.force=11", "peer.1.scale.force = 11 is not allowed: it must be a number from 0.1 to 10"),
    ] {
        let error = Scene::load(Laws::built_in(), None, &[key.to_owned()]).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    let heavy = ["device.mass_kg=900", "scale.force=10"].map(str::to_owned);
    let error = Scene::load(Laws::built_in(), None, &heavy).unwrap_err().to_string();
    assert!(error.contains("in the world it is 9000 kg"), "{error}");
}

/// A device alone in front of a wall 10 mm away: nobody holds it, and its peer renders nothing.
fn walled(keys: &[&str]) -> Plant {
    let alone = ["contact.stiffness_n_per_m=0", "contact.damping_n_s_per_m=0", "user.2.push_n=0", "user.2.wall_m=0.01"];
    Plant::new(&with("any-network", &[&alone[..], keys].concat()), 1)
}

#[test]
fn a_pushed_device_rests_in_the_wall_where_the_spring_balances() {
    // Away from the other peer is toward positive x for user 2.
    let keys = ["user.2.push_n=-3", "user.2.wall_stiffness_n_per_m=2000", "user.2.wall_damping_n_s_per_m=20"];
    for keys in [&keys[..], &[&keys[..], &["plant.motor=true", "plant.winding=true", "plant.drive=current"]].concat()] {
        let mut plant = walled(keys);
        for tick in 0..3000 {
            plant.step(f64::from(tick) * 1e-3, &Actuators::<f64>::default());
        }
        let at = plant.motions()[0].position;
        assert!((at - (0.01 + 3.0 / 2000.0)).abs() < 1e-7 && (plant.wall_n() - 3.0).abs() < 1e-3, "{at} m");
    }
}

/// Thrown against it, it comes back no faster, and of a wall without damping no slower than the steps of 50 µs take.
#[test]
fn a_wall_gives_back_what_it_took() {
    for stiffness in [300.0, 3_000.0, 30_000.0] {
        let stiffness_key = format!("user.2.wall_stiffness_n_per_m={stiffness}");
        let mut plant = walled(&["device.damping_n_s_per_m=0", &stiffness_key]);
        *plant.free_axis().0 = Motion { position: 0.0, velocity: 0.5 };
        for tick in 0..400 {
            plant.step(f64::from(tick) * 1e-3, &Actuators::<f64>::default());
        }
        let speed = -plant.motions()[0].velocity;
        // A crossing makes or takes at most ½K·(v·50 µs)², here of ½m·v² with m = 0.1 kg; two of them.
        let allowed = 2.0 * stiffness / 0.1 * 50e-6_f64.powi(2);
        assert!((speed * speed / 0.25 - 1.0).abs() <= allowed + 1e-9, "{stiffness}: {speed} m/s");
    }
}

/// What the other peer sees of a clutch: no step in what comes from the line.
#[test]
fn a_clutch_is_no_jump_for_either_peer() {
    let push =
        ["user.1.push_n=1", "user.2.push_n=0.9", "user.1.arm_damping_n_s_per_m=4", "user.2.arm_damping_n_s_per_m=4"];
    let clutch = ["user.1.clutch_at_s=1", "user.1.clutch_for_s=0.5", "user.1.clutch_every_s=1.5"];
    let mut jumps = [[0.0_f64; 2]; 2];
    for (keys, jumps) in [&push[..], &[&push[..], &clutch].concat()].iter().zip(&mut jumps) {
        let mut pair = Pair::<f64>::new(&with("any-network", keys)).unwrap();
        let mut last = [0.0; 2];
        for _ in 0..10_000 {
            pair.step();
            for ((side, last), jump) in pair.sides().iter().zip(&mut last).zip(jumps.iter_mut()) {
                let force = side.peer.observed()[0].coordination_force;
                *jump = jump.max((force - *last).abs());
                *last = force;
            }
        }
        assert!(pair.fault().is_none());
    }
    for (plain, clutched) in jumps[0].iter().zip(jumps[1]) {
        assert!(clutched < plain + 0.02, "{jumps:?} N");
    }
}
