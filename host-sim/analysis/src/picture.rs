//! Stability regions as pictures: tinted where stable, with the crossings as lines.

use cohold_plot::{Dash, Figure, Panel, Series, ShareY};

use super::figure4::{self, Curve};
use super::map::Map;
use super::outline::{outline, strips};

/// Key and unit, for an axis.
fn label(key: &str, unit: &str) -> String {
    if unit.is_empty() { key.to_owned() } else { format!("{key} ({unit})") }
}

/// The outline of a region; the first path carries the name.
fn lines(map: &Map, name: &str, color: usize, dash: Dash) -> impl Iterator<Item = Series> {
    let named = move |at| if at == 0 { name } else { "" };
    outline(map).into_iter().enumerate().map(move |(at, path)| Series::dashed(named(at), color, dash, path))
}

/// The stability region of one map as a figure.
pub fn region(title: &str, map: &Map) -> Figure {
    let [x, y] = &map.axes;
    let mut series = vec![Series::region("stable", 0, strips(map))];
    series.extend(lines(map, "", 0, Dash::Solid));
    let panel = Panel {
        x_label: label(&x.range.key, map.units[0]),
        y_label: label(&y.range.key, map.units[1]),
        x_range: Some((x.range.from, x.range.to)),
        y_range: Some((y.range.from, y.range.to)),
        series,
        ..Panel::default()
    };
    Figure { title: title.to_owned(), columns: 1, panels: vec![panel], ..Figure::default() }
}

/// The cooperation paper's Figure 4.
pub fn figure4(curves: &[(Curve, Map)]) -> Figure {
    let titles = ["(a) Power-domain", "(b) Traditional wave", "(c) Passive wave"];
    let dashes = [Dash::Solid, Dash::Dashed, Dash::Dotted, Dash::DashDot];
    let per_panel = figure4::DELAYS.len();
    let panel = |(title, curves): (&str, &[(Curve, Map)])| Panel {
        title: title.to_owned(),
        x_label: "K_LC (N/m)".to_owned(),
        y_label: "K_T (N/m)".to_owned(),
        x_range: Some((0.0, 2500.0)),
        y_range: Some((0.0, 12_000.0)),
        series: curves
            .iter()
            .enumerate()
            .flat_map(|(at, (curve, map))| {
                // One legend, where there is room for it, serves all panels.
                let first = curve.comm == figure4::COMMS[0];
                let name = if first { format!("n_t = {}", curve.one_way_delay_packets) } else { String::new() };
                lines(map, &name, at, dashes[at % dashes.len()]).collect::<Vec<_>>()
            })
            .collect(),
        ..Panel::default()
    };
    Figure {
        title: "Stability regions for two-user haptic cooperation (Rakhsha & Constantinescu 2012, Figure 4)".to_owned(),
        caption: "Lines are outlines of stable regions: one holds the lower left corner; in (b) a second one lies above \
                  5017 N/m; in (c) a line that folds back encloses an unstable pocket. One-way delay n_t packets of 8 ms; \
                  every force one tick late; parameters of the paper's section 4.3."
            .to_owned(),
        columns: 3,
        share_y: ShareY::Rows,
        panels: titles.into_iter().zip(curves.chunks(per_panel)).map(panel).collect(),
        ..Figure::default()
    }
}
