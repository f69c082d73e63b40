//! `cohold paper architectures`: the same task in every architecture, side by side.

use clap::Args;
use cohold_cli::flags::Out;
use cohold_cli::{Failure, Ui};
use cohold_core::{names::Choice, num::Scalar};
use cohold_report::significant;
use serde_json::json;

use crate::studies::architectures::together::unbounded_radius;
use crate::studies::architectures::{Architecture, DELAYS_MS, Row, TASK, across, columns, picture, rows};

#[derive(Debug, Args)]
pub(super) struct Architectures {
    #[command(flatten)]
    out: Out,
}

impl Architectures {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        ui.only_built_in("architectures compares");
        let steps = Architecture::ALL.len() * DELAYS_MS.len();
        let (rows, wall_s) = ui.work(steps, "architectures", |step| rows(&step))?;
        let provenance = ui.provenance().with("number_type", f64::NAME).with("seconds", TASK.duration_s);
        let table = columns(&rows);
        let files = ui.files(&self.out, "architectures", "architectures", &provenance, |files| {
            files.csv(&table)?;
            files.figure(None, &picture::figure(&rows))
        })?;
        let radius = |packet_ms| unbounded_radius(packet_ms).map(|radius| (packet_ms, radius));
        let unbounded = (1..=8).map(radius).collect::<Result<Vec<_>, _>>()?;
        let packets: Vec<_> =
            unbounded.iter().map(|(ms, radius)| json!({ "packet_ms": ms, "spectral_radius": radius })).collect();
        ui.document_of(&provenance, &json!({ "rows": table, "unbounded": packets, "wall_s": wall_s, "files": files }))?;
        writeln!(
            ui,
            "Two users carry and place a body; delay from user to user, one way, ms; NO: unstable, or not done in time\n"
        );
        let print_table = |title: &str, architectures: &[Architecture], cell: &dyn Fn(&Row) -> String| {
            writeln!(ui, "{title}\n\n{}", across(&rows, architectures, cell));
        };
        let if_stable = |row: &Row, cell: String| if row.stable { cell } else { "NO".to_owned() };
        let title = "True discrepancy, mean / largest (mm); NO with the spectral radius of a packet period";
        print_table(title, Architecture::ALL, &|row| {
            let [mean, largest] = [row.true_discrepancy_mm, row.peak_discrepancy_mm].map(|mm| significant(mm, 3));
            if row.stable { format!("{mean} / {largest}") } else { format!("NO {:.3}", row.spectral_radius) }
        });
        writeln!(
            ui,
            "Lock and ring: only who carries feels the body; the other is shown where it was released last. So the two are apart by\n\
             the way of a turn until its release has come, and together at rest. Their mean is about that way x (time carried +\n\
             delay) / {} s: it says how long this task is. Compare them by when and where the body is placed.\n\
             Engine at the server: both are shown the same, equally old. What delay costs there is stiffness.\n",
            TASK.duration_s
        );
        writeln!(ui, "{}\n", slowest_packets(&unbounded));
        let bounded = [Architecture::CooperativeServer, Architecture::CooperativeClient];
        print_table("What the bounder has left of 1000 N/m of contact, either user's (N/m)", &bounded, &|row| {
            let [one, two] = row.contact_n_per_m.map(|stiffness| significant(stiffness, 3));
            format!("{one} {two}")
        });
        print_table("Mean / largest force felt (N)", Architecture::ALL, &|row| {
            if_stable(row, format!("{:.2} / {:.1}", row.felt_n, row.peak_n))
        });
        print_table("Placed after (s), and where (mm, both users)", Architecture::ALL, &|row| {
            if_stable(row, format!("{:.1}: {:.0} {:.0}", row.placed_s, row.rests_mm[0], row.rests_mm[1]))
        });
        print_table("Bytes a second: one user / server (kB/s, sealed)", Architecture::ALL, &|row| {
            if_stable(row, format!("{:.1} / {:.1}", 1e-3 * row.user_bytes_per_s, 1e-3 * row.server_bytes_per_s))
        });
        writeln!(ui, "{:.1} s", wall_s);
        ui.wrote(&files);
        Ok(())
    }
}

/// Why the engine is unstable without the bounder even where there is no delay: the largest |eigenvalue| with packets every so
/// many ms.
fn slowest_packets(unbounded: &[(u32, f64)]) -> String {
    let stable = unbounded.iter().take_while(|(_, radius)| *radius <= 1.0).count();
    let edge = &unbounded[stable.saturating_sub(1)..];
    let radii: Vec<_> = edge.iter().map(|(packet_ms, radius)| format!("{radius:.3} at {packet_ms} ms")).collect();
    format!(
        "Packets go every 8 ms, which counts as delay: without the bounder a contact of 1000 N/m does not bear that even at 0 ms.\n\
         It needs packets every {stable} ms or faster: spectral radius {}. cohold shared cooperative sends them every tick.",
        radii.join(", ")
    )
}
