//! `host-sim architectures`: the same task in every architecture, side by side.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::flags::Out;
use super::{Failure, Ui};
use crate::studies::architectures::together::unbounded_radius;
use crate::studies::architectures::{Architecture, DELAYS_MS, Row, TASK, across, columns, picture, rows};
use haptic_core::num::Scalar;
use haptic_sim::report::{Columns, significant};

/// Arguments of `architectures`.
#[derive(Debug, Args)]
pub(super) struct Architectures {
    #[command(flatten)]
    out: Out,
}

/// Largest |eigenvalue| of one engine without bounder and delay, with packets every so many milliseconds.
#[derive(Serialize)]
struct Packets {
    packet_ms: u32,
    spectral_radius: f64,
}

#[derive(Serialize)]
struct Report {
    rows: Columns,
    unbounded: Vec<Packets>,
    wall_s: f64,
    files: Vec<PathBuf>,
}

impl Architectures {
    /// Runs every architecture at every delay.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        ui.only_built_in("architectures compares");
        let start = Instant::now();
        let bar = ui.progress((Architecture::ALL.len() * DELAYS_MS.len()) as u64, "architectures");
        let rows = rows(&|| bar.inc(1))?;
        bar.finish_and_clear();
        let made = ui.made().with("number_type", f64::NAME).with("seconds", TASK.duration_s);
        let table = columns(&rows);
        let folder = ui.folder(self.out.folder(), "out/architectures");
        let files = ui.files(folder.as_deref(), "architectures", &made, |files| {
            files.csv(&table)?;
            files.figure(None, &picture::figure(&rows))
        })?;
        let packets =
            |packet_ms| unbounded_radius(packet_ms).map(|spectral_radius| Packets { packet_ms, spectral_radius });
        let unbounded = (1..=8).map(packets).collect::<Result<_, _>>()?;
        let report = Report { rows: table, unbounded, wall_s: start.elapsed().as_secs_f64(), files };
        ui.document_of(&made, &report)?;
        report.print(ui, &rows);
        ui.wrote(&report.files);
        Ok(())
    }
}

impl Report {
    fn print(&self, ui: &Ui, rows: &[Row]) {
        writeln!(
            ui,
            "Two users carry and place a body; delay from user to user, one way, ms; NO: unstable, or not done in time\n"
        );
        let told = |title: &str, architectures: &[Architecture], cell: &dyn Fn(&Row) -> String| {
            writeln!(ui, "{title}\n\n{}", across(rows, architectures, cell));
        };
        let if_stable = |row: &Row, cell: String| if row.stable { cell } else { "NO".to_owned() };
        let title = "True discrepancy, mean / largest (mm); NO with the spectral radius of a packet period";
        told(title, &Architecture::ALL, &|row| {
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
        writeln!(ui, "{}\n", self.slowest_packets());
        let bounded = [Architecture::CooperativeServer, Architecture::CooperativeClient];
        told("What the bounder has left of 1000 N/m of contact, either user's (N/m)", &bounded, &|row| {
            let [one, two] = row.contact_n_per_m.map(|stiffness| significant(stiffness, 3));
            format!("{one} {two}")
        });
        told("Mean / largest force felt (N)", &Architecture::ALL, &|row| {
            if_stable(row, format!("{:.2} / {:.1}", row.felt_n, row.peak_n))
        });
        told("Placed after (s), and where (mm, both users)", &Architecture::ALL, &|row| {
            if_stable(row, format!("{:.1}: {:.0} {:.0}", row.placed_s, row.rests_mm[0], row.rests_mm[1]))
        });
        told("Bytes a second: one user / server (kB/s, sealed)", &Architecture::ALL, &|row| {
            if_stable(row, format!("{:.1} / {:.1}", 1e-3 * row.user_bytes_per_s, 1e-3 * row.server_bytes_per_s))
        });
        writeln!(ui, "{:.1} s", self.wall_s);
    }

    /// Why the engine is unstable without the bounder even where there is no delay.
    fn slowest_packets(&self) -> String {
        let stable = self.unbounded.iter().take_while(|at| at.spectral_radius <= 1.0).count();
        let edge = &self.unbounded[stable.saturating_sub(1)..];
        let radii: Vec<_> = edge.iter().map(|at| format!("{:.3} at {} ms", at.spectral_radius, at.packet_ms)).collect();
        format!(
            "Packets go every 8 ms, which counts as delay: without the bounder a contact of 1000 N/m does not bear that even at 0 ms.\n\
             It needs packets every {stable} ms or faster: spectral radius {}. host-sim cooperative sends them every tick.",
            radii.join(", ")
        )
    }
}
