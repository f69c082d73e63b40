//! Advice names one gain, and following it mends the scene with the margin that is promised.

use cohold_analysis::verdict;
use cohold_analysis::{MARGIN, advice, change};
use cohold_core::object::IntegratorName;
use cohold_sim::scene::Scene;
use rayon::prelude::*;

use super::random;

#[test]
fn a_stable_scene_is_told_so() {
    assert!(advice(&Scene::default()).unwrap().starts_with("inside its stability region"));
    assert_eq!(advice(&Scene::default()).unwrap().lines().count(), 1);
}

#[test]
fn coordination_comes_before_contact() {
    let mut scene = Scene::default();
    scene.peer.coordination.comm = "power";
    let text = advice(&scene).unwrap();
    assert!(text.contains("lower coordination.stiffness_n_per_m from 10620 to 226 N/m"), "{text}");
    // Stiffer than the contact alone bears: no K_T helps.
    let mut scene = Scene::default();
    scene.peer.contact.stiffness_n_per_m = 6000.0;
    assert!(advice(&scene).unwrap().contains("lower contact.stiffness_n_per_m from 6000 to "));
}

/// A line of little impedance on a light copy: no stiffness helps while forces are a tick late.
#[test]
fn where_no_gain_helps_other_settings_are_named() {
    let mut scene = Scene::default();
    scene.peer.object.mass_kg = 0.01;
    scene.peer.object.integrator = IntegratorName::SemiImplicit;
    scene.peer.coordination.damping_n_s_per_m = 40.0;
    let text = advice(&scene).unwrap();
    assert!(text.contains("no single stiffness mends it"), "{text}");
}

#[test]
fn following_the_advice_mends_the_scene() {
    let followed: Vec<bool> = (0..80_u64)
        .into_par_iter()
        .filter_map(|seed| {
            let mut scene = random::scene(seed);
            if verdict(&scene).unwrap().stable {
                return None;
            }
            let Some(change) = change(&scene).unwrap() else { return Some(false) };
            scene.set_number(change.key, change.to).unwrap();
            assert!(verdict(&scene).unwrap().stable, "scene {seed}: {change:?}");
            // Between the edge and the value lies the margin, or the middle of a narrow interval.
            assert!((change.to / change.limit - 1.0).abs() <= MARGIN + 5e-3, "scene {seed}: {change:?}");
            Some(true)
        })
        .collect();
    let mended = followed.iter().filter(|mended| **mended).count();
    assert!(followed.len() > 25 && mended > followed.len() / 3, "{mended} of {}", followed.len());
}
