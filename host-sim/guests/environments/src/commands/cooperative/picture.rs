//! Pictures of `cooperative`: one run over time, and a sweep of delays.

use cohold_plot::{Figure, Panel, Series};

use super::Row;
use crate::cooperative::run::Outcome;
use crate::cooperative::{Collision, Engine};

pub(super) fn over_time(row: &Row) -> Figure {
    let column = |name: &str, factor: f64| row.outcome.table.points("time_s", name, factor);
    let panel = |y_label: &str, series| Panel {
        x_label: "Time (s)".to_owned(),
        y_label: y_label.to_owned(),
        series,
        ..Panel::default()
    };
    Figure {
        title: format!("One object, {} users, {} ms one way", row.users, row.one_way_ms),
        caption: "Above: the object where it is moved, and as the first and the last client render it. Below: what they push \
                  it with."
            .to_owned(),
        columns: 1,
        share_x: true,
        panels: vec![
            panel(
                "Position (mm)",
                vec![
                    Series::line("object", 0, column("object_m", 1e3)),
                    Series::line("first client", 1, column("view_1_m", 1e3)),
                    Series::line("last client", 2, column("view_last_m", 1e3)),
                ],
            ),
            panel(
                "Contact force (N)",
                vec![
                    Series::line("first client", 1, column("force_1_n", 1.0)),
                    Series::line("last client", 2, column("force_last_n", 1.0)),
                ],
            ),
        ],
        ..Figure::default()
    }
}

pub(super) fn sweep(rows: &[Row]) -> Figure {
    let line = |bounder: bool, value: fn(&Outcome) -> f64| {
        let of_these = rows.iter().filter(|row| row.bounder == bounder && row.outcome.stable);
        of_these.map(|row| (row.one_way_ms, value(&row.outcome))).collect::<Vec<_>>()
    };
    let both = |value: fn(&Outcome) -> f64| {
        vec![Series::line("with the bounder", 0, line(true, value)), Series::line("without", 1, line(false, value))]
    };
    let panel = |y_label: &str, value| Panel {
        x_label: "One-way delay (ms)".to_owned(),
        y_label: y_label.to_owned(),
        log_x: true,
        log_y: true,
        series: both(value),
        ..Panel::default()
    };
    let contact = match rows.first().map(|row| row.collision) {
        Some(Collision::Server) => "server",
        _ => "clients",
    };
    let engine = match rows.first().map(|row| row.engine) {
        Some(Engine::Client) => "at the first client",
        Some(Engine::Moves) => "that moves to the first client and back",
        _ => "at the server",
    };
    Figure {
        title: format!("One dynamics engine {engine}, contact at the {contact}"),
        caption: "Only runs that are stable: without the bounder a line ends where the environment breaks.".to_owned(),
        columns: 2,
        panels: vec![
            panel("True discrepancy (mm)", |outcome| outcome.true_discrepancy_mm),
            panel("Contact stiffness (N/m)", |outcome| outcome.stiffness_n_per_m),
        ],
        ..Figure::default()
    }
}
