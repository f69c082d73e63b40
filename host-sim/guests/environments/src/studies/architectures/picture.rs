//! Every architecture side by side: coherency, force and bandwidth against delay, and where each is stable.

use cohold_core::names::Choice;
use cohold_plot::{Dash, Figure, Panel, Series};

use super::{Architecture, Row};

/// One panel with a line for every architecture, with their names in one of the panels; a line has a gap where it is unstable.
fn panel(rows: &[Row], named: bool, y_label: &str, log_y: bool, value: fn(&Row) -> f64) -> Panel {
    let line = |(at, architecture): (usize, &Architecture)| {
        let of_this = rows.iter().filter(|row| row.architecture == *architecture);
        let points = of_this.map(|row| (row.delay_ms, if row.stable { value(row) } else { f64::NAN })).collect();
        // The palette's yellow is weak on white, and no other solid line is green.
        let color = if *architecture == Architecture::DistributedWave { 2 } else { at };
        // What is in a family shares a dash. Of its lines, which may lie on each other, the first is the widest, and the last, drawn
        // above them, the narrowest.
        let (dash, beneath) = match architecture {
            Architecture::Static => (Dash::Dotted, 2),
            Architecture::CollaborativeLock => (Dash::Dotted, 1),
            Architecture::CollaborativeRing => (Dash::Dotted, 0),
            Architecture::CooperativeServerUnbounded => (Dash::Dashed, 2),
            Architecture::CooperativeServer => (Dash::Dashed, 1),
            Architecture::CooperativeClient => (Dash::Dashed, 0),
            Architecture::DistributedWave => (Dash::Solid, 3),
            Architecture::DistributedPassiveWave => (Dash::Solid, 2),
            Architecture::DistributedPassiveMean => (Dash::Solid, 1),
            Architecture::DistributedPower => (Dash::Solid, 0),
        };
        let width = 2.6 + 2.2 * f64::from(beneath);
        Series::dashed(if named { architecture.title() } else { "" }, color, dash, points).wide(width)
    };
    Panel {
        x_label: "Delay from user to user, one way (ms)".to_owned(),
        y_label: y_label.to_owned(),
        log_y,
        series: Architecture::ALL.iter().enumerate().map(line).collect(),
        ..Panel::default()
    }
}

/// The rows as one figure of four panels.
pub fn figure(rows: &[Row]) -> Figure {
    Figure {
        title: "Two people carry and place a body, in every architecture".to_owned(),
        caption: "Dotted: own copies, lock, token ring. Dashed: one dynamics engine. Solid: copies held together by a law. Where lines of one \
                  kind lie on each other the wider one shows beside the narrower. Lines end where an architecture is unstable, as the engine without bounder is everywhere; a discrepancy of \
                  0, as with one engine at the server, has no place on its axis. Lock and ring are apart only while one \
                  carries, and only who carries feels the body. Bytes are those that one user sends, sealed."
            .to_owned(),
        columns: 2,
        panels: vec![
            panel(rows, true, "Mean true discrepancy (mm)", true, |row| row.true_discrepancy_mm),
            panel(rows, false, "Mean force felt (N)", false, |row| row.felt_n),
            panel(rows, false, "Largest force (N)", false, |row| row.peak_n),
            panel(rows, false, "Bytes sent by a user (kB/s)", true, |row| 1e-3 * row.user_bytes_per_s),
        ],
        ..Figure::default()
    }
}
