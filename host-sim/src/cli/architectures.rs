//! `host-sim architectures`: the same task in every architecture, side by side.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::ui::save;
use super::{Failure, Ui};
use crate::studies::architectures::together::unbounded_radius;
use crate::studies::architectures::{Architecture, DELAYS_MS, Row, TASK, picture, rows};
use haptic_plot::draw;
use haptic_sim::report::table::Table;
use haptic_sim::report::text::{TextTable, significant};

/// Arguments of `architectures`.
#[derive(Debug, Args)]
pub(super) struct Architectures {
    /// Folder for CSV and pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Largest |eigenvalue| of one engine without bounder and delay, with packets every so many milliseconds.
#[derive(Serialize)]
struct Packets {
    packet_ms: u32,
    spectral_radius: f64,
}

#[derive(Serialize)]
struct Report {
    rows: Vec<Row>,
    unbounded: Vec<Packets>,
    wall_s: f64,
    files: Vec<PathBuf>,
}

impl Architectures {
    /// Runs every architecture at every delay.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let start = Instant::now();
        let bar = ui.progress((Architecture::ALL.len() * DELAYS_MS.len()) as u64, "architectures");
        let rows = rows(&|| bar.inc(1))?;
        bar.finish_and_clear();
        let mut written = Vec::new();
        if let Some(folder) = ui.folder(self.out.as_deref(), "out/architectures") {
            let base = folder.join("architectures");
            let figure = picture::figure(&rows);
            written = save(&base, &table(&rows)?, || draw(&figure, &base))?;
        }
        let packets =
            |packet_ms| unbounded_radius(packet_ms).map(|spectral_radius| Packets { packet_ms, spectral_radius });
        let unbounded = (1..=8).map(packets).collect::<Result<_, _>>()?;
        let report = Report { rows, unbounded, wall_s: start.elapsed().as_secs_f64(), files: written };
        ui.document(&report)?;
        report.print(ui);
        ui.wrote(&report.files);
        Ok(())
    }
}

/// All numbers, one row for each; architectures by their place in the list, from 1.
fn table(rows: &[Row]) -> Result<Table, Failure> {
    let mut table = Table::with_names(&[
        "architecture",
        "delay_ms",
        "stable",
        "spectral_radius",
        "contact_1_n_per_m",
        "contact_2_n_per_m",
        "true_discrepancy_mm",
        "peak_discrepancy_mm",
        "felt_n",
        "peak_n",
        "rests_1_mm",
        "rests_2_mm",
        "placed_s",
        "user_bytes_per_s",
        "server_bytes_per_s",
    ])?;
    for row in rows {
        let number = Architecture::ALL.iter().position(|known| *known == row.architecture).map_or(0, |at| at + 1);
        table.push_row(&[
            number as f64,
            row.delay_ms,
            f64::from(u8::from(row.stable)),
            row.spectral_radius,
            row.contact_n_per_m[0],
            row.contact_n_per_m[1],
            row.true_discrepancy_mm,
            row.peak_discrepancy_mm,
            row.felt_n,
            row.peak_n,
            row.rests_mm[0],
            row.rests_mm[1],
            row.placed_s,
            row.user_bytes_per_s,
            row.server_bytes_per_s,
        ])?;
    }
    Ok(table)
}

impl Report {
    fn print(&self, ui: &Ui) {
        writeln!(
            ui,
            "Two users carry and place a body; delay from user to user, one way, ms; NO: unstable, or not done in time\n"
        );
        let all = &Architecture::ALL;
        across(
            ui,
            &self.rows,
            all,
            "True discrepancy, mean / largest (mm); NO with the spectral radius of a packet period",
            |row| {
                let [mean, largest] = [row.true_discrepancy_mm, row.peak_discrepancy_mm].map(|mm| significant(mm, 3));
                if row.stable { format!("{mean} / {largest}") } else { format!("NO {:.3}", row.spectral_radius) }
            },
        );
        writeln!(
            ui,
            "Lock and ring: only who carries feels the body; the other is shown where it was released last. So the two are apart by\n\
             the way of a turn until its release has come, and together at rest. Their mean is about that way x (time carried +\n\
             delay) / {} s: it says how long this task is. Compare them by when and where the body is placed.\n\
             Engine at the server: both are shown the same, equally old. What delay costs there is stiffness.\n",
            TASK.duration_s
        );
        writeln!(ui, "{}\n", self.slowest_packets());
        let bounded = &[Architecture::CooperativeServer, Architecture::CooperativeClient];
        across(
            ui,
            &self.rows,
            bounded,
            "What the bounder has left of 1000 N/m of contact, either user's (N/m)",
            |row| {
                let [one, two] = row.contact_n_per_m.map(|stiffness| significant(stiffness, 3));
                format!("{one} {two}")
            },
        );
        let if_stable = |row: &Row, cell: String| if row.stable { cell } else { "NO".to_owned() };
        across(ui, &self.rows, all, "Mean / largest force felt (N)", |row| {
            if_stable(row, format!("{:.2} / {:.1}", row.felt_n, row.peak_n))
        });
        across(ui, &self.rows, all, "Placed after (s), and where (mm, both users)", |row| {
            if_stable(row, format!("{:.1}: {:.0} {:.0}", row.placed_s, row.rests_mm[0], row.rests_mm[1]))
        });
        across(ui, &self.rows, all, "Bytes a second: one user / server (kB/s, sealed)", |row| {
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

/// One number, architectures down and delays across.
fn across(ui: &Ui, rows: &[Row], architectures: &[Architecture], title: &str, cell: impl Fn(&Row) -> String) {
    let delays = DELAYS_MS.map(|delay| delay.to_string());
    let mut table = TextTable::new(std::iter::once(String::new()).chain(delays));
    for architecture in architectures {
        let of_this = rows.iter().filter(|row| row.architecture == *architecture);
        table.push(std::iter::once(architecture.name().to_owned()).chain(of_this.map(&cell)));
    }
    writeln!(ui, "{title}\n\n{table}");
}
