//! Cost per scene: what each model that a scene asks for adds to the tick.
//!
//! A scene carries only the models it needs, so cost is a sum that a user can read off: every row is a scene, the row it
//! is compared with, and the instructions between them. Counted like everything here ([`super::counts`]): one whole peer,
//! tick and an eighth of an exchange. The list of scenes is [`haptic_cases::scenes`].

use serde::Serialize;

use super::counts::{Processor, SCALARS};
pub use haptic_cases::scenes::{NAMED, SCENES, Scene};
use haptic_sim::report::Columns;

/// What a scene costs, in the order of [`SCALARS`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// The scene.
    pub scene: &'static str,
    /// What it adds.
    pub adds: &'static str,
    /// To which scene.
    pub over: Option<&'static str>,
    /// Instructions of one tick.
    pub instructions: [u64; 3],
    /// More than the scene it is compared with; for the first, all.
    pub added: [i64; 3],
}

/// The table, in instructions of this processor; scenes that nobody has counted are not in it.
pub fn table(processor: Processor) -> Vec<Cost> {
    let of = |name: &str| -> Option<[u64; 3]> {
        let case = format!("tick/{name}");
        let [a, b, c] = SCALARS.map(|scalar| processor.count(&case, scalar));
        Some([a?, b?, c?])
    };
    let row = |scene: &Scene| {
        let instructions = of(scene.name)?;
        let base = scene.over.map_or(Some([0; 3]), of)?;
        let added = [0, 1, 2].map(|column: usize| instructions[column] as i64 - base[column] as i64);
        Some(Cost { scene: scene.name, adds: scene.adds, over: scene.over, instructions, added })
    };
    SCENES.iter().chain([&NAMED]).filter_map(row).collect()
}

/// The table for people.
pub fn columns(costs: &[Cost]) -> Columns {
    let mut columns = Columns::of(costs).value("scene", |cost| cost.scene).value("adds", |cost| cost.adds);
    columns = columns.value("over", |cost| cost.over).head("to");
    for (at, scalar) in SCALARS.into_iter().enumerate() {
        columns = columns.value(scalar, move |cost| cost.instructions[at]);
    }
    for (at, scalar) in SCALARS.into_iter().enumerate() {
        columns = columns.signed(format!("added.{at}"), move |cost| cost.added[at]).head(&format!("+{scalar}"));
    }
    columns.done()
}
