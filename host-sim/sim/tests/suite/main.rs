//! Runs against an independent oracle, and the parts that runs are made of.

mod carrying_on;
mod cogging;
mod double_double;
mod engine;
mod faults;
mod fitted;
mod friction;
mod hands;
mod impedance;
mod impulsive;
mod irtt;
mod lanes;
mod leader_follower;
mod limits;
mod link;
mod linkage;
mod measure;
mod midpoint;
mod oracle;
mod outcome;
mod precision;
mod self_timed;
mod shared;
mod stiff;
mod tanks;
mod unlike;
mod winding;

/// What the self-timed line of a scene begins with at either end, J.
fn capital_j(scene: &cohold_sim::Scene) -> f64 {
    match scene.get("coordination.carry_energy_j") {
        Some(cohold_core::settings::Value::Number(capital_j)) => capital_j,
        other => panic!("{other:?}"),
    }
}
