//! The analyser's lag of a current loop against the loop itself: core's whole numbers around an exact winding, simulated.

use cohold_analysis::{Effort, Range, limit};
use cohold_core::num::Motion;
use cohold_sim::pair::Pair;
use cohold_sim::scene::Scene;
use cohold_sim::scenes;

/// The cooperation paper's §5.2, nobody pushing, with a fine converter: what decides is the loop and not its steps.
fn scene(keys: &[&str]) -> Scene {
    let base = ["plant.motor=true", "plant.winding=true", "plant.current_bits=16", "plant.current_noise_a=0"];
    let none = ["user.1.push_n=0", "user.2.push_n=0", "user.2.sine_n=0"];
    // What limits take of a contact is passive, and would settle.
    let unbound = ["safety.max_force_n=200", "safety.max_slew_n_per_s=1000000"];
    let keys: Vec<String> = base.iter().chain(&none).chain(&unbound).chain(keys).map(|key| key.to_string()).collect();
    scenes::find(cohold_guest_laws::laws(), Some(std::path::Path::new("paper-5.2-passive-wave-16ms")), &keys).unwrap()
}

/// The stiffest contact that the analyser calls stable, N/m.
fn analysed(scene: &Scene) -> f64 {
    let range = Range { key: "contact.stiffness_n_per_m".to_owned(), from: 300.0, to: 9000.0 };
    let found = limit(scene, range, Effort { steps: 100, ..Effort::default() }).unwrap();
    assert!(found.stable_at_start);
    found.crossings[0]
}

/// Whether what a knock on both devices leaves dies away.
pub(crate) fn settles(scene: &Scene, stiffness: f64) -> bool {
    let mut scene = scene.clone();
    scene.set_number("contact.stiffness_n_per_m", stiffness).unwrap();
    let mut pair = Pair::<f64>::new(&scene).unwrap();
    for (side, velocity) in pair.sides_mut().zip([0.02, 0.0]) {
        *side.plant.free_axis().0 = Motion { position: 0.0, velocity };
    }
    let mut energy = |ticks: u32| {
        (0..ticks).fold(0.0, |sum, _| {
            pair.step();
            let side = pair.sides()[0];
            sum + (side.plant.motions()[0].velocity - side.peer.observed()[0].object.velocity).powi(2)
        })
    };
    energy(400);
    let early = energy(400);
    energy(4000);
    let late = energy(400);
    pair.fault().is_none() && late < early
}

/// The stiffest contact that a run settles with, to 4 N/m.
fn simulated(scene: &Scene) -> f64 {
    let [mut low, mut high] = [300.0, 9000.0];
    assert!(settles(scene, low) && !settles(scene, high));
    while high - low > 4.0 {
        let middle = 0.5 * (low + high);
        if settles(scene, middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// To 2.5 %; the first is a control without windings, for the way of looking.
#[test]
fn the_limit_of_a_contact_is_the_simulators() {
    for keys in [
        &["plant.winding=false", "plant.motor=false", "device.force_delay_ticks=0.2"][..],
        &["plant.drive=current"],
        &["plant.drive=current", "motor.current_loop_hz=500"],
        &["plant.drive=current", "motor.current_loop_hz=2000"],
        &["plant.drive=current", "motor.resistance_ohm=1.5", "motor.newton_or_newton_metre_per_a=6.25"],
        &["plant.drive=current", "motor.back_emf_forward=true"],
        &["plant.drive=current", "plant.resistance_ratio=1.3"],
    ] {
        let scene = scene(keys);
        let (analysed, simulated) = (analysed(&scene), simulated(&scene));
        assert!((analysed - simulated).abs() < 0.025 * simulated, "{keys:?}: {analysed} {simulated}");
    }
}
