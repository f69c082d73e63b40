//! The midpoint peer (THEORY §7): its limits of contact, and random scenes in contact and let go, none of which is unstable.

use cohold_analysis::{Effort, Range, limit, verdict};
use cohold_sim::scene::Scene;

use crate::kinds::midpoint;
use crate::random::Random;

/// K_T = 10⁴, m_O = 0.3, M = 8, n_t = 1, by the device's own delay.
#[test]
fn limits_of_contact_as_in_theory() {
    for (delay_ticks, wanted) in [(0.0, 7295.0), (0.1, 6086.0), (0.5, 3511.0), (1.0, 2318.0)] {
        let mut scene = midpoint("passive-mean", 1);
        scene.peer.coordination.stiffness_n_per_m = 1e4;
        scene.world.device.force_delay_ticks = delay_ticks;
        let range = Range { key: "contact.stiffness_n_per_m".to_owned(), from: 100.0, to: 12_000.0 };
        let found = limit(&scene, range, Effort::default()).expect("a good scene");
        let got = found.crossings[0];
        assert!((got / wanted - 1.0).abs() < 5e-3, "delay of {delay_ticks} ticks: {got} N/m, {wanted} in THEORY");
    }
}

/// In contact as THEORY draws them: K_LC 200, 1000, 1800, a device a tick late.
#[test]
fn no_scene_in_contact_is_unstable() {
    let mut random = Random::new(7);
    for number in 0..300 {
        let mut scene = midpoint("passive-mean", random.whole(0, 20));
        scene.peer.timing.ticks_per_packet = random.whole(1, 8);
        scene.peer.contact.stiffness_n_per_m = [200.0, 1000.0, 1800.0][random.whole(0, 2) as usize];
        scene.peer.coordination.stiffness_n_per_m = random.spread(1e2, 1e6);
        scene.peer.coordination.wave_impedance_n_s_per_m = random.spread(5.0, 70.0);
        scene.peer.object.mass_kg = if random.whole(0, 1) == 0 { 0.02 } else { 0.3 };
        let radius = verdict(&scene).expect("a good scene").spectral_radius;
        assert!(radius <= 1.0 + 1e-6, "scene {number}: {radius} of {:?}", scene.peer);
    }
}

/// This scene with rates, gains and a mass of their own, and a coordination spring up to so stiff, N/m.
pub(crate) fn drawn(mut scene: Scene, random: &mut Random, stiffest_n_per_m: f64) -> Scene {
    scene.peer.timing.ticks_per_packet = random.whole(1, 16);
    scene.peer.timing.control_period_s = random.spread(1e-4, 5e-3);
    scene.peer.coordination.stiffness_n_per_m = random.spread(10.0, stiffest_n_per_m);
    scene.peer.coordination.damping_n_s_per_m = 20.0 * random.unit();
    scene.peer.coordination.wave_impedance_n_s_per_m = random.spread(1.0, 200.0);
    scene.peer.object.mass_kg = random.spread(1e-3, 10.0);
    scene
}

/// Radius of the pair that nobody holds, at any delay that `safety.max_delay_s` may allow. A self-timed line that holds still now and then may
/// carry on at the expense of a tank, which small signals never empty: as a wall it is passive without one.
pub(crate) fn released(scene: &Scene) -> f64 {
    let mut scene = scene.hands_off();
    scene.peer.safety.max_delay_s = 1.0;
    let mut judged = verdict(&scene).expect("a good scene");
    if judged.states == 0 && judged.not_judged_because.is_none() {
        scene.set_number("coordination.carry_damping_n_s_per_m", 0.0).expect("it is allowed");
        judged = verdict(&scene).expect("a good scene");
    }
    if judged.not_judged_because.is_some() { 0.0 } else { judged.spectral_radius }
}

/// Nobody's hand on the object, drawn as in THEORY: there the orders of the papers make energy, one solve makes none.
#[test]
fn no_scene_that_is_let_go_of_is_unstable() {
    let mut random = Random::new(11);
    for number in 0..3000 {
        let scene = drawn(midpoint("passive-mean", random.whole(0, 20)), &mut random, 1e6);
        let radius = released(&scene);
        assert!(radius <= 1.0 + 1e-6, "scene {number}: {radius} of {:?}", scene.peer);
    }
}

/// The one-pole filter is passive in its band only: the counter-example.
#[test]
fn the_filter_before_the_rate_drop_is_not_passive() {
    let mut scene = midpoint("passive-wave", 0);
    scene.peer.coordination.stiffness_n_per_m = 1e4;
    scene.peer.coordination.wave_impedance_n_s_per_m = 40.0;
    scene.peer.object.mass_kg = 0.02;
    let radius = released(&scene);
    assert!((radius - 1.048).abs() < 1e-3, "{radius}");
}
