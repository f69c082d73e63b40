//! `host-sim accuracy`: speed against error, for every numerical choice; and what each model adds to a scene.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::{Failure, Ui};
use crate::studies::accuracy::counts::{Processor, SCALARS};
use crate::studies::accuracy::{self, Comparison, Family, Point, cost, picture};
use haptic_sim::report::text::{TextTable, significant};

/// Arguments of `accuracy`.
#[derive(Debug, Args)]
pub(super) struct Accuracy {
    /// Whose instructions.
    #[arg(long, value_enum, default_value_t, value_name = "NAME")]
    processor: Processor,
    /// Folder for the pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Document {
    /// What instructions are instructions of.
    processor: Processor,
    families: Vec<Family>,
    /// Number types of the columns of `cost_per_scene`.
    scalars: [&'static str; 3],
    cost_per_scene: Vec<cost::Cost>,
    pictures: Vec<PathBuf>,
}

impl Accuracy {
    /// Measures, prints and draws.
    ///
    /// # Errors
    /// A picture that cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let bar = ui.progress(2, "errors, pictures");
        let (families, cost_per_scene) = (accuracy::families(self.processor)?, cost::table(self.processor));
        bar.inc(1);
        let folder = ui.folder(self.out.as_deref(), "out/accuracy");
        let pictures = folder
            .map_or(Ok(Vec::new()), |folder| picture::write(&families, &cost_per_scene, self.processor, &folder))?;
        bar.finish_and_clear();
        let document = Document { processor: self.processor, families, scalars: SCALARS, cost_per_scene, pictures };
        ui.document(&document)?;
        document.print(ui);
        Ok(())
    }
}

impl Document {
    fn print(&self, ui: &Ui) {
        writeln!(ui, "Speed against error; instructions of {}\n", self.processor.label());
        for family in &self.families {
            print_family(ui, family);
        }
        writeln!(
            ui,
            "Cost per scene: instructions of one tick, and what the scene adds to the one it is compared with\n"
        );
        let mut table = TextTable::new(["scene", "adds", "to", "f32", "f64", "i32f32", "+f32", "+f64", "+i32f32"]);
        for row in &self.cost_per_scene {
            let mut cells = vec![row.scene.to_owned(), row.adds.to_owned(), row.over.unwrap_or("-").to_owned()];
            cells.extend(row.instructions.map(|count| count.to_string()));
            cells.extend(row.added.map(|count| format!("{count:+}")));
            table.push(cells);
        }
        ui.table(&table);
        writeln!(ui, "Pictures (SVG, and PNG beside each):");
        for picture in self.pictures.iter().filter(|path| path.extension().is_some_and(|e| e == "svg")) {
            writeln!(ui, "  {}", picture.display());
        }
    }
}

fn print_family(ui: &Ui, family: &Family) {
    writeln!(ui, "{}\n\n  {}\n  Against {}.\n", family.title, family.motion, family.reference);
    let instructions = format!("instructions per {}", family.instructions_per.split(':').next().unwrap_or_default());
    let mut table = TextTable::new(["", "choice", "error", "unit", &instructions, "on Pareto front"]);
    for comparison in &family.comparisons {
        let told = comparison.points.iter().filter(|point| point.on_front || leads(comparison, point));
        for (at, point) in told.enumerate() {
            let title = format!("{}: {}", comparison.title, comparison.error);
            table.push([
                if at == 0 { title } else { String::new() },
                point.choice.clone(),
                significant(point.error, 3),
                comparison.unit.to_owned(),
                point.instructions.map_or_else(|| "not counted".to_owned(), |count| count.to_string()),
                if point.on_front { "yes" } else { "no" }.to_owned(),
            ]);
        }
    }
    writeln!(ui, "{table}\n{}\n", family.insight);
}

/// The first of its series, or in none: the others of a series are told only when they are on the front.
fn leads(comparison: &Comparison, point: &Point) -> bool {
    let first = comparison.points.iter().find(|other| other.series == point.series);
    point.series.is_empty() || first == Some(point)
}
