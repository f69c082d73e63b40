//! A stroke as a figure: the forces around the outline, and their size along the way.

use cohold_plot::{Figure, Panel, Series};

use super::stroke::Stroke;

/// Between two arrows, m of way.
const APART_M: f64 = 0.002;
/// Length of an arrow, m/N.
const SCALE_M_PER_N: f64 = 0.008;
/// Height of a frame over its width, two beside each other.
const ASPECT: f64 = 0.87;

/// The stroke as a figure.
pub fn figure(stroke: &Stroke) -> Figure {
    let millimetres = |[x, y]: [f64; 2]| (1e3 * x, 1e3 * y);
    let column = |name: &str| stroke.table.column(name).unwrap_or(&[]).iter().copied();
    let vectors = |x: &str, y: &str| column(x).zip(column(y)).map(|(x, y)| [x, y]);
    let (hands, forces) = (|| vectors("hand_x_m", "hand_y_m"), || vectors("force_x_n", "force_y_n"));
    let (mut arrows, mut next_m) = (Vec::new(), 0.0);
    for ((([x, y], [fx, fy]), way_m), depth_m) in hands().zip(forces()).zip(column("way_m")).zip(column("depth_m")) {
        if depth_m > 0.0 && way_m >= next_m {
            next_m = way_m + APART_M;
            let tip = [x + SCALE_M_PER_N * fx, y + SCALE_M_PER_N * fy];
            arrows.extend([millimetres([x, y]), millimetres(tip), (f64::NAN, f64::NAN)]);
        }
    }
    let outline: Vec<(f64, f64)> = stroke.outline.iter().copied().map(millimetres).collect();
    let hand = hands().map(millimetres).collect();
    // Metres are as long in both directions: the wider of the two fills its axis.
    let shown = || outline.iter().chain(&arrows).filter(|(x, _)| x.is_finite());
    let span = |pick: fn(&(f64, f64)) -> f64| {
        let (least, most) =
            shown().map(pick).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), at| (a.min(at), b.max(at)));
        (0.5 * (least + most), 0.55 * (most - least))
    };
    let ((x, wide), (y, high)) = (span(|point| point.0), span(|point| point.1));
    let half = wide.max(high / ASPECT);
    let force = column("way_m").zip(forces()).map(|(way_m, [x, y])| (1e3 * way_m, libm::hypot(x, y))).collect();
    Figure {
        title: "A hand strokes along an object and pushes it about".to_owned(),
        caption: format!(
            "Left: the object's outline, the way of the hand as the object sees it, and every {} mm the force on the hand, {} mm \
             to the newton. Right: its size along the way. At a corner that points out, the hand stays under the side that it \
             comes from until the other one is as near; at one that points in, the force turns with the hand.",
            1e3 * APART_M,
            1e3 * SCALE_M_PER_N
        ),
        columns: 2,
        panels: vec![
            Panel {
                x_label: "x (mm)".to_owned(),
                y_label: "y (mm)".to_owned(),
                x_range: Some((x - half, x + half)),
                y_range: Some((y - ASPECT * half, y + ASPECT * half)),
                series: vec![
                    Series::line("force", 1, arrows.clone()),
                    Series::line("outline", 6, outline.clone()),
                    Series::line("hand", 0, hand),
                ],
                ..Panel::default()
            },
            Panel {
                x_label: "Way along the outline (mm)".to_owned(),
                y_label: "Force (N)".to_owned(),
                series: vec![Series::line("", 1, force)],
                ..Panel::default()
            },
        ],
        ..Figure::default()
    }
}
