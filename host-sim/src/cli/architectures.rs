//! `host-sim architectures`: the same task in every architecture, side by side.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::stability::{folder, tell, write};
use super::{Failure, print_json, progress_bar};
use crate::architectures::{Architecture, DELAYS_MS, Row, picture, rows};
use crate::report::plot::draw;
use crate::report::table::Table;
use crate::report::text::{TextTable, significant};

/// Arguments of `architectures`.
#[derive(Debug, Args)]
pub(super) struct Architectures {
    /// Print JSON; files are written only with --out.
    #[arg(long)]
    json: bool,
    /// Folder for CSV and pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    rows: Vec<Row>,
    wall_s: f64,
    files: Vec<PathBuf>,
}

impl Architectures {
    /// Runs every architecture at every delay.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn run(&self) -> Result<(), Failure> {
        let start = Instant::now();
        let bar = progress_bar((Architecture::ALL.len() * DELAYS_MS.len()) as u64, "architectures");
        let rows = rows(&|| bar.inc(1))?;
        bar.finish_and_clear();
        let mut written = Vec::new();
        if let Some(folder) = folder(self.out.as_deref(), self.json, "out/architectures") {
            let base = folder.join("architectures");
            let figure = picture::figure(&rows);
            written = write(&base, &table(&rows)?, || draw(&figure, &base))?;
        }
        let report = Report { rows, wall_s: start.elapsed().as_secs_f64(), files: written };
        if self.json {
            return print_json(&report);
        }
        report.print();
        tell(&report.files);
        Ok(())
    }
}

/// All numbers, one row for each; architectures by their place in the list, from 1.
fn table(rows: &[Row]) -> Result<Table, Failure> {
    let mut table = Table::with_names(&[
        "architecture",
        "delay_ms",
        "stable",
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
    fn print(&self) {
        println!("Two users carry and place a body; delay from user to user, one way, ms\n");
        self.across("Mean true discrepancy (mm); NO: unstable, or not done in time", |row| {
            significant(row.true_discrepancy_mm, 3)
        });
        println!("Packets go every 8 ms, which counts as delay; host-sim cooperative sends them every tick.\n");
        self.across("Mean / largest force felt (N)", |row| format!("{:.2} / {:.1}", row.felt_n, row.peak_n));
        self.across("Placed after (s), and where (mm, both users)", |row| {
            format!("{:.1}: {:.0} {:.0}", row.placed_s, row.rests_mm[0], row.rests_mm[1])
        });
        self.across("Bytes a second: one user / server (kB/s, sealed)", |row| {
            format!("{:.1} / {:.1}", 1e-3 * row.user_bytes_per_s, 1e-3 * row.server_bytes_per_s)
        });
        println!("{:.1} s", self.wall_s);
    }

    /// One number, architectures down and delays across.
    fn across(&self, title: &str, cell: fn(&Row) -> String) {
        let delays = DELAYS_MS.map(|delay| delay.to_string());
        let mut table = TextTable::new(std::iter::once(String::new()).chain(delays));
        for architecture in Architecture::ALL {
            let of_this = self.rows.iter().filter(|row| row.architecture == architecture);
            let cells = of_this.map(|row| if row.stable { cell(row) } else { "NO".to_owned() });
            table.push(std::iter::once(architecture.name().to_owned()).chain(cells));
        }
        println!("{title}\n\n{table}");
    }
}
