//! Dry friction that the motors take over: how much less a hand feels, and that nothing is ever pushed.

use cohold_sim::Laws;
use cohold_sim::pair::Pair;
use cohold_sim::scene::Scene;

/// A current loop.
pub(crate) const WOUND: [&str; 2] = ["plant.winding=true", "plant.drive=current"];

/// A device with a motor and encoders of 5 µm, which its user pulls away from the object. `own` keys come last.
pub(crate) fn pulled(pull_n: f64, more: &[&str], own: &[String]) -> Scene {
    let keys = [
        "plant.encoder=true",
        "plant.motor=true",
        "axis.velocity=filtered",
        "encoder.counts_per_m=200000",
        "contact.one_sided=true",
        "user.1.sine_n=0",
        "user.2.sine_n=0",
    ];
    let pull = [format!("user.1.push_n={}", -pull_n)];
    let keys = keys.iter().chain(more).map(|key| (*key).to_owned());
    let keys: Vec<String> = keys.chain(pull).chain(own.iter().cloned()).collect();
    Scene::load(Laws::built_in(), None, &keys).unwrap_or_else(|why| panic!("{why}"))
}

/// One with 0.5 N of dry friction, 5 N·s/m and a current loop.
fn scene(taken_n: f64, pull_n: f64, more: &[&str]) -> Scene {
    let device = ["plant.coulomb_n=0.5", "device.damping_n_s_per_m=5"];
    pulled(pull_n, &[&WOUND, &device, more].concat(), &[format!("motor.friction_n={taken_n}")])
}

/// Speed of device 1 after a second, m/s, and how far it has come, m.
fn moved(scene: &Scene) -> (f64, f64) {
    let mut pair = Pair::<f32>::new(scene).expect("a good scene");
    let place = |pair: &Pair<f32>| pair.sides()[0].plant.motions()[0];
    let start = place(&pair).position;
    let ticks = (1.0 / scene.peer.timing.control_period_s).round() as u32;
    (0..ticks).for_each(|_| pair.step());
    let end = place(&pair);
    (end.velocity, end.position - start)
}

/// In the end a pull goes into damping and what is left of friction: v = (pull − 0.5 N + taken)/(5 N·s/m), whatever the tick.
#[test]
fn a_hand_feels_what_is_left_of_friction() {
    for period in ["timing.control_period_s=0.001", "timing.control_period_s=0.00025"] {
        for taken_n in [0.0, 0.2, 0.4] {
            let (speed, _) = moved(&scene(taken_n, 1.0, &[period]));
            let exact = -(1.0 - 0.5 + taken_n) / 5.0;
            assert!((speed - exact).abs() < 0.01 * exact.abs(), "{period}, {taken_n} N: {speed} of {exact} m/s");
        }
    }
}

/// A pull that friction holds moves nothing, and without any a device stays where it is, with a late force and a coarse encoder, too.
#[test]
fn what_is_taken_over_pushes_nobody() {
    for pull_n in [0.0, 0.45] {
        for more in [&[][..], &["encoder.counts_per_m=20000"], &["timing.control_period_s=0.0005"]] {
            let (_, moved) = moved(&scene(0.4, pull_n, more));
            assert!(moved.abs() < 1e-4, "{pull_n} N, {more:?}: {moved} m");
        }
    }
}

#[test]
fn more_than_there_is_is_refused() {
    let said = |taken: &str, there: &str| {
        let keys = [format!("motor.friction_n={taken}"), format!("plant.coulomb_n={there}")];
        Scene::load(Laws::built_in(), None, &keys).and_then(|scene| scene.check("here")).map_err(|why| why.to_string())
    };
    assert_eq!(said("0.4", "0.5"), Ok(()));
    let why = said("0.41", "0.5").expect_err("too much");
    assert!(why.contains("motor.friction_n = 0.41") && why.contains("at most 0.8 of that, 0.4000 N"), "{why}");
    assert!(said("0.1", "0").is_err());
}
