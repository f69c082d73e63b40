//! `cohold stability rendering`: the architectures paper's Figure 4, for any device.

use std::time::Instant;

use clap::Args;
use cohold_analysis::rendering::identify::{STIFFNESS_N_PER_M, identify, needs};
use cohold_analysis::rendering::maps::{self, Curve, POINTS, Sweep};
use cohold_analysis::rendering::{Body, Rendering as Setup, picture};
use cohold_core::names::Choice;
use cohold_core::num::Scalar;
use cohold_report::{Columns, significant};
use serde_json::json;

use crate::flags::Out;
use crate::{Failure, Ui};

/// Masses for which the paper's device is found, kg.
const MASSES_KG: [f64; 5] = [0.02, 0.05, 0.1, 0.3, 1.0];

#[derive(Debug, Args)]
pub(crate) struct Rendering {
    /// Mass of the haptic device, kg.
    #[arg(long, default_value_t = 0.1, value_name = "KG")]
    device_mass_kg: f64,
    /// Its damping, N·s/m; without it, that of the device behind the paper's statement.
    #[arg(long, value_name = "B")]
    device_damping_n_s_per_m: Option<f64>,
    /// Mass of the virtual object, kg; a wall is always shown beside it.
    #[arg(long, default_value_t = 0.3, value_name = "KG")]
    object_mass_kg: f64,
    /// Damping of the virtual object, N·s/m.
    #[arg(long, default_value_t = 0.0, value_name = "B")]
    object_damping_n_s_per_m: f64,
    /// Damping of the contact, N·s/m.
    #[arg(long, default_value_t = 0.0, value_name = "B")]
    contact_damping_n_s_per_m: f64,
    /// Time from sampling to the new force, in periods; without it, that of the device behind the paper's statement.
    #[arg(long, value_name = "C")]
    computing_ticks: Option<f64>,
    /// Sampling period while the delay is swept, s; without it, a fortieth of the delay, so that only the delay counts.
    #[arg(long, value_name = "S")]
    sampling_period_s: Option<f64>,
    #[command(flatten)]
    out: Out,
}

impl Rendering {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let start = Instant::now();
        let mut setup = Setup {
            device: Body {
                mass_kg: self.device_mass_kg,
                damping_n_s_per_m: self.device_damping_n_s_per_m.unwrap_or(1.0),
            },
            object: Some(Body { mass_kg: self.object_mass_kg, damping_n_s_per_m: self.object_damping_n_s_per_m }),
            contact_damping_n_s_per_m: self.contact_damping_n_s_per_m,
            period_s: self.sampling_period_s.unwrap_or(1e-3),
            computing_ticks: self.computing_ticks.unwrap_or(0.5),
            delays_s: [0.0; 4],
        };
        maps::check(&setup, self.sampling_period_s)?;
        if self.device_damping_n_s_per_m.is_none() || self.computing_ticks.is_none() {
            let papers = identify(self.device_mass_kg)?;
            setup.device.damping_n_s_per_m = self.device_damping_n_s_per_m.unwrap_or(papers.damping_n_s_per_m);
            setup.computing_ticks = self.computing_ticks.unwrap_or(papers.computing_ticks);
        }
        let identified = MASSES_KG.into_iter().map(identify).collect::<Result<Vec<_>, _>>()?;
        let sweeps = maps::sweeps(&setup);
        let (curves, _) = ui.work(sweeps.len() * POINTS, "maps", |step| {
            let curve = |(base, sweep)| maps::curve(&base, sweep, self.sampling_period_s, step);
            sweeps.into_iter().map(curve).collect::<Result<Vec<_>, _>>()
        })?;
        let provenance = ui.provenance().with("number_type", f64::NAME).with("device_mass_kg", setup.device.mass_kg);
        let provenance = provenance.with("device_damping_n_s_per_m", setup.device.damping_n_s_per_m);
        let provenance = provenance.with("object_mass_kg", self.object_mass_kg);
        let provenance = provenance.with("object_damping_n_s_per_m", self.object_damping_n_s_per_m);
        let provenance = provenance.with("contact_damping_n_s_per_m", setup.contact_damping_n_s_per_m);
        let provenance =
            provenance.with("computing_ticks", setup.computing_ticks).with("sampling_period_s", self.sampling_period_s);
        let files = ui.files(&self.out, "stability", "rendering", &provenance, |files| {
            files.csv(&maps::table(&curves))?;
            files.figure(None, &picture::figure(&setup, &curves))
        })?;
        let (contact_damping, computing_ticks) = (setup.contact_damping_n_s_per_m, setup.computing_ticks);
        let wall_s = start.elapsed().as_secs_f64();
        // What the stiffness of the paper's statement asks of this device; devices for which its two statements hold at once.
        let asked = needs(&setup)?;
        ui.document_of(&provenance, &json!({
            "device": setup.device, "object": setup.object.unwrap_or(setup.device),
            "contact_damping_n_s_per_m": contact_damping, "computing_ticks": computing_ticks,
            "needs_for_1000_n_per_m": asked, "identified": identified, "curves": curves, "wall_s": wall_s, "files": files,
        }))?;
        let Body { mass_kg, damping_n_s_per_m } = setup.device;
        writeln!(
            ui,
            "Device {mass_kg} kg, {damping_n_s_per_m:.3} N·s/m; object {} kg, {} N·s/m; contact damping {contact_damping} N·s/m; \
             computing {computing_ticks:.3} of a period\n\n\
             Largest stable stiffness (N/m), where it is stable again and ends behind it, at these delays or periods (ms)\n",
            self.object_mass_kg, self.object_damping_n_s_per_m
        );
        ui.table(&curve_table(&curves));
        let or_none = |number: Option<f64>| number.map_or_else(|| "none".to_owned(), |number| significant(number, 3));
        writeln!(
            ui,
            "\nA wall of {STIFFNESS_N_PER_M} N/m needs at least {} Hz without delay, and a delay below {} ms.\n\n\
             Devices for which the paper's two statements (200 Hz, 5 ms) hold at once:\n",
            or_none(asked.sampling_hz),
            or_none(asked.delay_s.map(|delay_s| 1e3 * delay_s))
        );
        ui.text("", &identified)?;
        writeln!(ui, "{wall_s:.1} s");
        ui.wrote(&files);
        Ok(())
    }
}

/// Every fifth point of the curves: largest stiffness, and further crossings if there are any.
fn curve_table(curves: &[Curve]) -> Columns {
    let name = |curve: &Curve| {
        let against = if curve.wall { "wall" } else { "object" };
        match curve.sweep {
            Sweep::Delay(place) => format!("delay {}, {against}", place.name()),
            Sweep::Period => format!("period, {against}"),
        }
    };
    let crossings = |curve: &Curve, at: usize| match curve.points.get(at) {
        Some(point) if point.largest_stiffness_n_per_m.is_none() => Some("all".to_owned()),
        Some(point) => Some(point.edges().iter().map(|edge| significant(*edge, 3)).collect::<Vec<_>>().join(", ")),
        None => None,
    };
    let points = curves.first().map_or(&[][..], |curve| &curve.points);
    let every_fifth = points.iter().enumerate().step_by(5);
    let table = every_fifth.fold(Columns::of(curves).value("", name), |table, (at, point)| {
        let head = significant(1e3 * point.time_s, 3);
        table.value(head.clone(), |curve| crossings(curve, at)).head(&head)
    });
    table.done()
}
