//! The midpoint peer in runs (THEORY §7): true discrepancies under the pushes of §5.2 over constant delays, within 1 %.

use cohold_sim::run::{Options, run};
use cohold_sim::{Laws, Scene, scenes};

/// §5.2 with means of waves and one solve a tick.
fn scene(ticks: u32, delay_packets: u32, mass_kg: f64, impedance: f64) -> Scene {
    let mut scene = scenes::load(Laws::built_in(), "paper-5.2-passive-wave-16ms").expect("built in");
    for setting in [
        "object.integrator=midpoint",
        "object.force_delay_ticks=0",
        "coordination.decode=implicit",
        "coordination.comm=passive-mean",
        "coordination.stiffness_n_per_m=1e5",
        &format!("coordination.wave_impedance_n_s_per_m={impedance}"),
        &format!("object.mass_kg={mass_kg}"),
        &format!("timing.ticks_per_packet={ticks}"),
        &format!("network.one_way_delay_packets={delay_packets}"),
    ] {
        scene.apply_override(setting).expect("a good override");
    }
    scene.check("test").expect("a good scene");
    scene
}

fn true_mm(scene: &Scene) -> f64 {
    let outcome = run::<f64>(scene, Options { duration_s: 20.0, record_every: 0 }, &|_| {}).expect("a good scene");
    assert!(outcome.fault.is_none() && outcome.bounded);
    outcome.whole.true_discrepancy_mm
}

fn near(scene: &Scene, wanted: f64, tolerance: f64) {
    let got = true_mm(scene);
    assert!((got / wanted - 1.0).abs() < tolerance, "{got} mm, {wanted} in THEORY");
}

/// One way 8 ms, b = 10, m_O = 0.3: the more often packets leave, the closer the copies.
#[test]
fn a_packet_per_tick_halves_the_discrepancy() {
    for (ticks, wanted) in [(8, 1.627), (4, 1.226), (2, 1.025), (1, 0.924)] {
        near(&scene(ticks, 8 / ticks, 0.3, 10.0), wanted, 0.01);
    }
    near(&scene(1, 1, 0.3, 10.0), 0.221, 0.01);
}

/// At one apparent mass of 0.65 kg, with next to all of it in the line.
#[test]
fn at_one_apparent_mass_a_stiff_line_is_closest() {
    for (ticks, impedance, wanted) in [(8, 38.0, 0.442), (4, 51.0, 0.257), (2, 61.0, 0.185), (1, 68.0, 0.154)] {
        near(&scene(ticks, 8 / ticks, 0.02, impedance), wanted, 0.01);
    }
    // THEORY gives two digits.
    near(&scene(1, 1, 0.02, 305.0), 0.027, 0.02);
}
