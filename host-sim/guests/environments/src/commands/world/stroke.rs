//! `cohold shared world stroke`: what a hand feels that strokes along an object and pushes it about, and where its work goes.

use clap::Args;
use cohold_cli::flags::{Out, number};
use cohold_cli::{Failure, Ui};
use serde_json::json;

use super::WorldArgs;
use crate::records::{Block, Shape};
use crate::world::picture;
use crate::world::stroke::{Options, stroke};

#[derive(Debug, Args)]
#[command(mut_arg("world", |arg| {
    arg.requires("object").help("World file (TOML) with the object; without it, a block of 80 mm with a corner that points inwards")
}))]
pub(crate) struct Stroke {
    #[command(flatten)]
    world: WorldArgs,
    /// Which object of the world, by its id.
    #[arg(long, value_name = "ID", requires = "world")]
    object: Option<u32>,
    /// Mass with which the object moves, kg.
    #[arg(long, default_value_t = Options::default().mass_kg, value_name = "KG", value_parser = number(0.01..=1e3, "kg"))]
    mass_kg: f64,
    /// Viscous damping of its motion, N·s/m.
    #[arg(long, default_value_t = Options::default().drag_n_s_per_m, value_name = "N_S_PER_M", value_parser = number(0.0..=50.0, "N·s/m"))]
    drag_n_s_per_m: f64,
    /// How far under the surface the arm leads the hand, m.
    #[arg(long, default_value_t = Options::default().below_m, value_name = "M", value_parser = number(1e-4..=1.0, "m"))]
    below_m: f64,
    /// How fast, m/s.
    #[arg(long, default_value_t = Options::default().speed_m_per_s, value_name = "M_PER_S", value_parser = number(1e-3..=1.0, "m/s"))]
    speed_m_per_s: f64,
    #[command(flatten)]
    out: Out,
}

/// The block that is stroked without a world: a dart.
fn dart() -> Shape {
    let (a, b, c, d) = ([-0.03, -0.03], [0.0, -0.02], [0.03, -0.03], [0.0, 0.05]);
    let [[a_x_m, a_y_m], [b_x_m, b_y_m], [c_x_m, c_y_m], [d_x_m, d_y_m]] = [a, b, c, d];
    Shape::Block(Block { a_x_m, a_y_m, b_x_m, b_y_m, c_x_m, c_y_m, d_x_m, d_y_m, ..Block::default() })
}

impl Stroke {
    fn shape(&self) -> Result<Shape, Failure> {
        let (Some((world, place)), Some(id)) = (self.world.load()?, self.object) else { return Ok(dart()) };
        let Some(object) = world.get(id) else {
            let known: Vec<String> = world.objects().iter().map(|object| object.id.to_string()).collect();
            let known = known.join(", ");
            return Err(format!("--object {id} is not in {place}; its objects are {known}").into());
        };
        Ok(object.shape)
    }

    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let Self { mass_kg, drag_n_s_per_m, below_m, speed_m_per_s, .. } = *self;
        let options = Options { mass_kg, drag_n_s_per_m, below_m, speed_m_per_s, ..Options::default() };
        let stroke = stroke(&self.shape()?, &options)?;
        let provenance = ui.provenance().with("mass_kg", mass_kg).with("drag_n_s_per_m", drag_n_s_per_m);
        let provenance = provenance.with("below_m", below_m).with("speed_m_per_s", speed_m_per_s);
        let files = ui.files(&self.out, "shape", "shape", &provenance, |files| {
            files.csv(&stroke.table)?;
            files.figure(None, &picture::figure(&stroke))
        })?;
        // How far the object was pushed at most along either axis.
        let object = ["object_x_m", "object_y_m"].into_iter().filter_map(|name| stroke.table.column(name)).flatten();
        let way_m = object.fold(0.0_f64, |most, at| most.max(at.abs()));
        ui.report_of(
            &provenance,
            "stroke",
            &json!({
                "parts": stroke.parts, "energy": stroke.energy, "remainder_j": stroke.energy.remainder_j(),
                "largest_way_of_the_object_m": way_m, "files": files,
            }),
        )
    }
}
