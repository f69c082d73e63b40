//! `host-sim keys`: every key of a scene file.

use clap::Args;
use haptic_core::settings::Value;
use serde::Serialize;

use super::{Failure, Ui};
use haptic_sim::report::text::TextTable;
use haptic_sim::scene::Scene;

/// Arguments of `keys`.
#[derive(Debug, Args)]
pub(super) struct Keys {}

#[derive(Serialize)]
struct Row {
    key: String,
    default: String,
    unit: &'static str,
    allowed: String,
    meaning: &'static str,
}

impl Keys {
    /// Prints the list.
    ///
    /// # Errors
    /// None but of writing.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let defaults = Scene::default();
        let rows: Vec<Row> = Scene::keys()
            .into_iter()
            .map(|(key, about)| Row {
                default: defaults.get(&key).as_ref().map(Value::to_string).unwrap_or_default(),
                key,
                unit: about.unit,
                allowed: about.allowed.to_string(),
                meaning: about.doc,
            })
            .chain((1..=2).map(|user| Row {
                key: format!("user.{user}.trace"),
                default: String::new(),
                unit: "",
                allowed: "name of a CSV file with columns time_s,force_n".to_owned(),
                meaning: "Recorded force, added to the others.",
            }))
            .chain([Row {
                key: "network.trace".to_owned(),
                default: String::new(),
                unit: "",
                allowed: "name of a CSV file with columns direction,packet,delay_s,fate".to_owned(),
                meaning: "Recorded network, instead of what its table would draw.",
            }])
            .collect();
        ui.document(&rows)?;
        let mut table = TextTable::new(["key", "default", "unit", "allowed", "meaning"]);
        for row in rows {
            table.push([row.key, row.default, row.unit.to_owned(), row.allowed, row.meaning.to_owned()]);
        }
        ui.table(&table);
        Ok(())
    }
}
