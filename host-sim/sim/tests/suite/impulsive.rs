//! Impulsive contact in a scene: a mass that contradicts the device, and what its impacts and its rest come to.

use cohold_sim::pair::Pair;
use cohold_sim::{Error, Laws, Scene};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/impulsive.toml");

fn scene(overrides: &[&str]) -> Result<Scene, Error> {
    let overrides: Vec<_> = overrides.iter().map(|text| (*text).to_owned()).collect();
    Scene::load(Laws::built_in(), Some(FILE.as_ref()), &overrides)
}

/// Thought four times heavier, a device of 0.1 kg has 9.8 times its energy after an elastic impact with 0.3 kg at rest:
/// (2·μ̂/μ − 1)² of the approach's, μ = 75 g, μ̂ = 171 g, and that of the common centre.
#[test]
fn a_mass_that_contradicts_the_device_is_refused() {
    for (overrides, allowed) in [
        (&["contact.device_mass_kg=0.4"][..], false),
        (&["contact.device_mass_kg=0.101"], false),
        (&["contact.device_mass_kg=0.049"], false),
        (&["contact.device_mass_kg=0.05"], true),
        (&["device.mass_kg=0.3"], false),
        (&["device.mass_kg=0.3", "contact.device_mass_kg=0.3"], true),
        // An arm moves with the device; the lighter of two counts.
        (&["contact.device_mass_kg=0.3", "user.1.arm_mass_kg=0.2"], false),
        (&["contact.device_mass_kg=0.3", "user.1.arm_mass_kg=0.2", "user.2.arm_mass_kg=0.4"], true),
        // A spring asks for no mass.
        (&["contact.device_mass_kg=1", "contact.rendering=continuous"], true),
    ] {
        match scene(overrides) {
            Ok(_) => assert!(allowed, "{overrides:?}"),
            Err(said) => {
                let said = said.to_string();
                assert!(!allowed, "{overrides:?}: {said}");
                assert!(said.contains("contact.device_mass_kg = ") && said.contains("device.mass_kg = "), "{said}");
                assert_eq!(said.lines().count(), 1, "{said}");
            }
        }
    }
}

/// Two users who lean on the object with 1 N each, at any restitution: they stand F/K_LC deep, and stay.
#[test]
fn two_who_lean_on_the_object_do_not_sink() {
    for restitution in ["contact.restitution=1", "contact.restitution=0.5", "contact.restitution=0"] {
        let scene = scene(&[
            restitution,
            "contact.damping_n_s_per_m=5",
            "object.integrator=midpoint",
            "user.1.pulse_n=0",
            "user.1.push_n=1",
            "user.2.push_n=1",
            "user.2.arm_stiffness_n_per_m=0",
            "user.2.arm_damping_n_s_per_m=0",
        ])
        .expect("a good scene");
        let mut pair = Pair::<f64>::new(&scene).expect("a good scene");
        for _ in 0..10_000 {
            pair.step();
        }
        for (side, sign) in pair.sides().into_iter().zip([1.0, -1.0]) {
            let seen = side.peer.observed()[0];
            let depth_m = sign * (seen.device.position - seen.object.position);
            assert!((depth_m / 1e-3 - 1.0_f64).abs() < 0.01, "{restitution}: {depth_m}");
        }
    }
}
