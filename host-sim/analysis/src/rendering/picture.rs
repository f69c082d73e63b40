//! Both maps on the axes of the architectures paper's Fig. 4: stiffness to the right, delay or sampling period upwards.

use cohold_core::names::Choice;
use cohold_plot::{Dash, Figure, Panel, Series};

use super::closed::longest_object_delay_s;
use super::maps::{Curve, Sweep};
use super::{Body, Place, Rendering};

/// The paper's axes: N/m and ms.
const STIFFNESS: (f64, f64) = (0.0, 1000.0);
const TIME_MS: (f64, f64) = (0.0, 80.0);

/// Name, colour and dash of a curve: objects solid, walls dashed, delays of the dynamics engine dash-dotted. Of two curves that lie on each
/// other the second is dotted, so that both are seen.
fn look(curve: &Curve) -> (String, usize, Dash) {
    let against = if curve.wall { "wall" } else { "object" };
    match curve.sweep {
        Sweep::Period if curve.wall => (against.to_owned(), 0, Dash::Dashed),
        Sweep::Period => (against.to_owned(), 1, Dash::Solid),
        Sweep::Delay(place) => {
            let ([first_color, second_color], line) = match place {
                _ if curve.wall => ([0, 4], Dash::Dashed),
                Place::DeviceToCollision | Place::CollisionToDevice => ([1, 6], Dash::Solid),
                Place::CollisionToDynamics | Place::DynamicsToCollision => ([2, 3], Dash::DashDot),
            };
            let first = matches!(place, Place::DeviceToCollision | Place::CollisionToDynamics);
            let (color, dash) = if first { (first_color, line) } else { (second_color, Dash::Dotted) };
            (format!("{}, {against}", place.name()), color, dash)
        }
    }
}

/// Both maps of these curves as a figure.
pub fn figure(base: &Rendering, curves: &[Curve]) -> Figure {
    let panel = |title: &str, y_label: &str, delays: bool| {
        let of_this = curves.iter().filter(|curve| matches!(curve.sweep, Sweep::Delay(_)) == delays);
        let series = of_this.map(|curve| {
            let (name, color, dash) = look(curve);
            let points = curve.points.iter();
            let line = points.map(|point| (point.largest_stiffness_n_per_m.unwrap_or(f64::NAN), 1e3 * point.time_s));
            Series::dashed(name, color, dash, line.collect())
        });
        Panel {
            title: title.to_owned(),
            x_label: "Virtual object stiffness (N/m)".to_owned(),
            y_label: y_label.to_owned(),
            x_range: Some(STIFFNESS),
            y_range: Some(TIME_MS),
            series: series.collect(),
            ..Panel::default()
        }
    };
    let device = base.device;
    let object = base.object.map_or_else(String::new, |object| {
        let Body { mass_kg, damping_n_s_per_m } = object;
        let undamped = damping_n_s_per_m == 0.0 && base.contact_damping_n_s_per_m == 0.0;
        let longest_ms = 1e3 * longest_object_delay_s(device, object);
        let limit = if undamped {
            format!(" Undamped, it is unstable on even the softest contact once its own delay exceeds m_o/b = {longest_ms:.0} ms.")
        } else {
            String::new()
        };
        format!(" The object has {mass_kg} kg and {damping_n_s_per_m} N·s/m; the wall does not move.{limit}")
    });
    Figure {
        title: "Largest stable stiffness of one haptic device (Buttolo, Oboe & Hannaford 1997, Figure 4)".to_owned(),
        caption: format!(
            "Stable below and left of each line. Device {} kg, {:.3} N·s/m; contact damping {} N·s/m; computing takes {:.3} \
             of a period. Where between device and collision engine (CDE) a delay sits makes no difference, nor where \
             between it and the dynamics engine (DE).{object}",
            device.mass_kg, device.damping_n_s_per_m, base.contact_damping_n_s_per_m, base.computing_ticks
        ),
        columns: 2,
        panels: vec![
            panel("Communication delay", "Delay (ms)", true),
            panel("Sampling period, no delay", "Sampling period (ms)", false),
        ],
        ..Figure::default()
    }
}
