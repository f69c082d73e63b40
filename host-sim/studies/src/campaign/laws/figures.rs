//! The bench as pictures: how laws compare, and what each lets a hand feel.

use haptic_plot::{Dash, Figure, Panel, Series, ShareY};
use haptic_sim::measure::impedance::{Complex, SPEED_M_PER_S};
use haptic_sim::run::Verdict;

use super::super::Cell;
use super::Row;
use super::touch::Point;

/// Colours of stable, apart and NO.
const VERDICTS: [(&str, usize); 3] = [("stable", 2), ("apart", 4), ("NO", 1)];

/// More names than this beside each other are hard to read.
const BESIDE: usize = 9;

/// True discrepancy against mobility, and the verdict of every law over every network.
pub fn laws(rows: &[Row]) -> Figure {
    let places: Vec<(f64, f64, &str)> = rows
        .iter()
        .filter_map(|row| {
            let true_mm = row.mean(|cell| cell.true_discrepancy_mm().map(|estimate| estimate.mean))?;
            Some((true_mm, row.mean(|cell| cell.mobility().map(|estimate| estimate.mean))?, row.law.name))
        })
        .collect();
    let points = places.iter().map(|(x, y, _)| (*x, *y)).collect();
    let names = places.iter().map(|(.., name)| (*name).to_owned()).collect();
    let against = Panel {
        title: "How near the copies are, and how far a common push gets".to_owned(),
        x_label: "True discrepancy, mean of the networks on which the law is stable (mm)".to_owned(),
        y_label: "Way, mean of those".to_owned(),
        log_x: true,
        series: vec![Series::dots("", 0, points, names)],
        ..Panel::default()
    };
    let panels = rows.len().div_ceil(BESIDE).max(1);
    let grids = rows.chunks(rows.len().div_ceil(panels).max(1)).enumerate().map(|(at, rows)| verdicts(rows, at == 0));
    Figure {
        title: "Coordination laws over the same networks".to_owned(),
        caption: "Every law at the gains that it declares, in the same scene. A law that is stable on few networks has its mean over those \
                  few: read all panels together."
            .to_owned(),
        columns: 1,
        panels: std::iter::once(against).chain(grids).collect(),
        ..Figure::default()
    }
}

/// The verdict of each of these laws over every network; the first panel says what the colours are.
fn verdicts(rows: &[Row], first: bool) -> Panel {
    let at = |colour: usize| -> Vec<(f64, f64)> {
        let cells = rows.iter().enumerate().flat_map(|(law, row)| {
            let cells = row.cells.iter().enumerate();
            cells.map(move |(network, cell)| (law, network, verdict(cell)))
        });
        let of = cells.filter(|(.., found)| *found == colour);
        of.map(|(law, network, _)| (law as f64, network as f64 + 1.0)).collect()
    };
    let label = |name: &str| if first { name.to_owned() } else { String::new() };
    let series = VERDICTS
        .iter()
        .enumerate()
        .map(|(which, (name, colour))| Series::dots(label(name), *colour, at(which), Vec::new()));
    let networks = rows.first().map_or(0, |row| row.cells.len()) as f64;
    Panel {
        title: if first { "Verdict, the worst of the seeds".to_owned() } else { String::new() },
        y_label: "Network, in the order of the table".to_owned(),
        y_range: Some((0.0, networks + if first { 8.0 } else { 1.0 })),
        categories: rows.iter().map(|row| row.law.name.to_owned()).collect(),
        series: series.collect(),
        ..Panel::default()
    }
}

/// Index of a cell's verdict in [`VERDICTS`].
fn verdict(cell: &Cell) -> usize {
    match (cell.count(Verdict::Unstable), cell.is_stable()) {
        (0, true) => 0,
        (0, false) => 1,
        _ => 2,
    }
}

/// The impedance that a hand feels, law by law.
pub fn impedance(rows: &[Row]) -> Figure {
    let panel = |(at, row): (usize, &Row)| {
        let size = |of: fn(&Point) -> Option<Complex>| -> Vec<(f64, f64)> {
            let size = |point: &Point| (point.frequency_hz, of(point).map_or(f64::NAN, Complex::abs));
            row.touch.points.iter().map(size).collect()
        };
        let lacks = |of: fn(&Point) -> Option<Complex>| -> Vec<(f64, f64)> {
            let points = row.touch.points.iter();
            let active =
                points.filter_map(|point| of(point).filter(|z| z.re < 0.0).map(|z| (point.frequency_hz, z.abs())));
            active.collect()
        };
        let label = |text: &str| if at == 0 { text.to_owned() } else { String::new() };
        let device = &row.scene.world.device;
        let alone = |point: &Point| {
            let reactance = core::f64::consts::TAU * point.frequency_hz * device.mass_kg;
            (point.frequency_hz, device.damping_n_s_per_m.hypot(reactance))
        };
        let none = row.touch.points.iter().any(|point| point.held.is_none() || point.let_go.is_none());
        Panel {
            title: row.law.name.to_owned(),
            x_label: "Frequency (Hz)".to_owned(),
            y_label: "|Z| (N·s/m)".to_owned(),
            log_x: true,
            log_y: true,
            note: none.then(|| "gaps: no answer that repeats".to_owned()),
            series: vec![
                Series::dashed(label("device alone"), 6, Dash::Dotted, row.touch.points.iter().map(alone).collect()),
                Series::line(label("far hand holds"), 0, size(|point| point.held)),
                Series::dashed(label("far hand off"), 2, Dash::Dashed, size(|point| point.let_go)),
                Series::dots(label("not passive"), 1, [lacks(|p| p.held), lacks(|p| p.let_go)].concat(), Vec::new()),
            ],
            ..Panel::default()
        }
    };
    Figure {
        title: "What a hand feels of each law: impedance, with the far hand holding its device and off".to_owned(),
        caption: format!(
            "Device, contact, copies and law on the scene's own network, a hand that moves at up to {} mm/s. Between the two lines lies \
             what can be felt of the other side. Where the real part is negative (dots) the hand could draw energy from it.",
            1e3 * SPEED_M_PER_S
        ),
        columns: 3,
        share_x: true,
        share_y: ShareY::All,
        panels: rows.iter().enumerate().map(panel).collect(),
    }
}
