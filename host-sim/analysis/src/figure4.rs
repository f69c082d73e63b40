//! Figure 4 of the cooperation paper: the largest stable coordination stiffness K_T against contact stiffness K_LC, for
//! three ways to communicate and four one-way delays.
//!
//! Both hands on, as in the paper. Parameters: §4.3 of the paper as THEORY §1 and §3 read them: exact object of 0.6 kg, every
//! force one tick late, delayed decode. Axes: the paper's, K_LC 0…2500 N/m, K_T 0…12000 N/m.

use cohold_core::object::IntegratorName;
use cohold_report::Columns;
use cohold_sim::scene::Scene;
use serde::Serialize;

use super::limit::Effort;
use super::map::{Axis, Map, map};
use super::modes::Hands;
use super::sweep::Range;
use crate::error::Error;

/// The panels, in the paper's order (a), (b), (c).
pub const COMMS: [&str; 3] = ["power", "wave", "passive-wave"];

/// The paper's one-way delays, packets.
pub const DELAYS: [u32; 4] = [0, 1, 2, 3];

/// Contact stiffnesses in a curve.
pub const POINTS: usize = 100;

/// Ranges and numbers of points of the paper's axes, both N/m.
pub fn axes() -> [Axis; 2] {
    let axis = |key: &str, to: f64| Axis { range: Range::up_to(key, to), count: POINTS };
    [axis("contact.stiffness_n_per_m", 2500.0), axis("coordination.stiffness_n_per_m", 12_000.0)]
}

/// The scene behind one curve.
pub fn scene(comm: &'static str, one_way_delay_packets: u32) -> Scene {
    let mut scene = Scene::default();
    scene.peer.object.mass_kg = 0.6;
    scene.peer.object.integrator = IntegratorName::Exact;
    scene.peer.coordination.comm = comm;
    scene.world.network.one_way_delay_packets = one_way_delay_packets;
    scene
}

/// One curve of the figure.
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    /// How the peers communicate.
    pub comm: &'static str,
    /// One-way delay n_t, packets.
    pub one_way_delay_packets: u32,
    /// Crossings of K_T for every K_LC.
    pub columns: Vec<super::map::Column>,
}

/// All twelve curves; `done` is called once for every point of a curve.
///
/// # Errors
/// A scene that the analyser cannot judge.
pub fn curves(done: impl Fn() + Sync) -> Result<Vec<(Curve, Map)>, Error> {
    // Steps of 150 N/m find every pocket of this figure; 0.1 % is ten times finer than it is drawn.
    let effort = Effort { steps: 80, tolerance: 1e-3, hands: Some(Hands::Both) };
    let mut curves = Vec::new();
    for comm in COMMS {
        for delay in DELAYS {
            let map = map(&scene(comm, delay), axes(), effort, &done)?;
            let curve = Curve { comm, one_way_delay_packets: delay, columns: map.columns.clone() };
            curves.push((curve, map));
        }
    }
    Ok(curves)
}

/// One row for every crossing: comm (0, 1, 2 for panels a, b, c), n_t, K_LC, K_T, and whether it is stable just below.
pub fn table(curves: &[(Curve, Map)]) -> Columns {
    let mut rows = Vec::new();
    for (at, (curve, map)) in curves.iter().enumerate() {
        for column in &map.columns {
            for (crossing, y) in column.limit.crossings.iter().enumerate() {
                let below = column.limit.stable_at_start == (crossing % 2 == 0);
                rows.push((at / DELAYS.len(), curve.one_way_delay_packets, column.x, *y, below));
            }
        }
    }
    Columns::of(&rows)
        .value("panel", |row| row.0)
        .means("how the peers communicate: 0 power, 1 wave, 2 passive wave")
        .value("one_way_delay_packets", |row| row.1)
        .means("one-way delay n_t, in packet periods")
        .value("contact_n_per_m", |row| row.2)
        .means("contact stiffness K_LC")
        .value("coordination_n_per_m", |row| row.3)
        .means("coordination stiffness K_T at which stability ends or begins")
        .value("stable_below", |row| row.4)
        .means("whether K_T just below is stable")
        .done()
}
