//! The bench as a picture: what each law lets a hand feel.

use cohold_plot::{Dash, Figure, Panel, Series, ShareY};
use cohold_sim::measure::impedance::{Complex, SPEED_M_PER_S};

use super::Row;
use super::touch::Point;

/// The impedance that a hand feels, law by law.
pub fn impedance(rows: &[Row]) -> Figure {
    let panel = |(at, row): (usize, &Row)| {
        let size = |of: fn(&Point) -> Option<Complex>| -> Vec<(f64, f64)> {
            let size = |point: &Point| (point.frequency_hz, of(point).map_or(f64::NAN, Complex::norm));
            row.touch.points.iter().map(size).collect()
        };
        let lacks = |of: fn(&Point) -> Option<Complex>| -> Vec<(f64, f64)> {
            let points = row.touch.points.iter();
            let active =
                points.filter_map(|point| of(point).filter(|z| z.re < 0.0).map(|z| (point.frequency_hz, z.norm())));
            active.collect()
        };
        let label = |text| if at == 0 { text } else { "" };
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
