//! Pictures of runs: the cooperation paper's Figures 6–9, and one sheet for any scene.

use cohold_plot::{Dash, Figure, Panel, Series, Shape, ShareY};
use cohold_sim::run::Outcome;

use super::reproduce::paper::Experiment;

/// One column of an axis' table over time, scaled; of a run that stopped, until it did: what comes after it is nobody's.
fn over_time(outcome: &Outcome, axis: usize, column: &str, scale: f64) -> Vec<(f64, f64)> {
    let mut points = outcome.axes[axis].table.points("time_s", column, scale);
    points.retain(|(time_s, _)| outcome.fault_time_s.is_none_or(|stop_s| *time_s <= stop_s));
    points
}

/// How a column of a sheet is drawn.
#[derive(Clone, Copy)]
struct Look {
    /// Time that is shown, s.
    window: (f64, f64),
    /// Positions and energy count from the beginning of the window, so that columns that have come elsewhere by then share a scale.
    from_there: bool,
    /// The first column: its legend serves the row.
    first: bool,
    discrepancy: Discrepancy,
    /// Which shared axis, from 0.
    axis: usize,
}

/// What a panel of discrepancies shows.
#[derive(Clone, Copy, PartialEq)]
enum Discrepancy {
    True,
    /// The decoded discrepancy at peer 2.
    Decoded,
    Both,
}

/// Position of hand, local and remote copy, forces, discrepancy and energy ledger: one column of a sheet.
fn column(title: &str, outcome: &Outcome, peer: usize, look: Look) -> [Panel; 4] {
    let other = 3 - peer;
    // A run that stopped is shown from its start until then, at a scale of its own.
    let stopped = outcome.fault_time_s.map(|stop_s| (0.0, stop_s));
    let window = stopped.unwrap_or(look.window);
    let own_scale = |series: &[Series]| {
        let lines = series.iter().filter_map(|series| match &series.shape {
            Shape::Line { points, .. } => Some(points),
            _ => None,
        });
        let values = lines.flatten().map(|(_, value)| (*value, *value)).filter(|(value, _)| value.is_finite());
        values.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    };
    let panel = |title: &str, y_label: &str, series: Vec<Series>| Panel {
        title: title.to_owned(),
        x_label: "Time (s)".to_owned(),
        y_label: y_label.to_owned(),
        x_range: Some(window),
        y_range: stopped.and_then(|_| own_scale(&series)),
        off_scale: !outcome.bounded || stopped.is_some(),
        note: outcome
            .fault
            .zip(outcome.fault_time_s)
            .filter(|_| !title.is_empty())
            .map(|((peer, fault), time_s)| format!("peer {peer} stops at {time_s:.2} s: {fault:?}")),
        series,
        ..Panel::default()
    };
    let label = |text| if look.first { text } else { "" };
    let from_there = |points: Vec<(f64, f64)>, zero: f64| -> Vec<(f64, f64)> {
        let zero = if look.from_there { zero } else { 0.0 };
        points.into_iter().map(|(time_s, value)| (time_s, value - zero)).collect()
    };
    let at_start = |points: &[(f64, f64)]| points.iter().find(|(time_s, _)| *time_s >= window.0).map_or(0.0, |at| at.1);
    let in_mm = |name: &str| over_time(outcome, look.axis, name, 1e3);
    let local = in_mm(&format!("object_{peer}_m"));
    let zero = at_start(&local);
    let place = |name: String| from_there(in_mm(&name), zero);
    let [hand, decoded, remote] =
        [format!("device_{peer}_m"), format!("decoded_{peer}_m"), format!("object_{other}_m")].map(place);
    let force = |name: &str| over_time(outcome, look.axis, &format!("{name}_{peer}_n"), 1.0);
    let energy = |name: &str| over_time(outcome, look.axis, &format!("energy_{name}_{peer}_j"), 1e3);
    let net: Vec<_> = energy("received").into_iter().zip(energy("sent")).map(|((t, a), (_, b))| (t, a - b)).collect();
    let net = from_there(net.clone(), at_start(&net));
    // One that stands alone always has its name.
    let alone = look.discrepancy != Discrepancy::Both;
    let which = |text| if alone { text } else { label(text) };
    let mut discrepancies = Vec::new();
    if look.discrepancy != Discrepancy::Decoded {
        discrepancies.push(Series::line(which("true"), 2, in_mm("true_discrepancy_m")));
    }
    if look.discrepancy != Discrepancy::True {
        let points = in_mm("decoded_discrepancy_2_m");
        discrepancies.push(Series::dashed(which("decoded, peer 2"), 1, Dash::Dashed, points));
    }
    [
        panel(
            title,
            "Position (mm)",
            vec![
                Series::dashed(label("hand"), 4, Dash::DashDot, hand),
                Series::line(label("local copy"), 0, from_there(local, zero)),
                Series::dashed(label("remote copy, decoded here"), 1, Dash::Dashed, decoded),
                Series::dashed(label("remote copy, true"), 2, Dash::Dotted, remote),
            ],
        ),
        panel(
            "",
            "Force on the copy (N)",
            vec![
                Series::line(label("coordination"), 0, force("coordination")),
                Series::dashed(label("contact"), 4, Dash::Dashed, force("contact")),
            ],
        ),
        panel("", "Discrepancy (mm)", discrepancies),
        panel("", "Net energy from network (mJ)", vec![Series::line("", 3, net)]),
    ]
}

/// A column of a figure: its title, the run, and which peer's.
type OfPeer<'a> = (String, &'a Outcome, usize);

/// Columns side by side on equal axes, positions and energy from the beginning of the window.
fn side_by_side(title: &str, caption: &str, columns: &[OfPeer<'_>], window: (f64, f64)) -> Figure {
    // A legend stands in the first column that shares the scales.
    let first = columns.iter().position(|(_, outcome, _)| outcome.fault_time_s.is_none()).unwrap_or(0);
    let look = |at| Look { window, from_there: true, first: at == first, discrepancy: Discrepancy::Both, axis: 0 };
    let sheet = |(at, (title, outcome, peer)): (usize, &OfPeer<'_>)| column(title, outcome, *peer, look(at));
    sheet_of(title, caption, columns.iter().enumerate().map(sheet).collect())
}

/// Columns of panels as one figure.
fn sheet_of(title: &str, caption: &str, sheets: Vec<[Panel; 4]>) -> Figure {
    Figure {
        title: title.to_owned(),
        caption: caption.to_owned(),
        columns: sheets.len(),
        share_y: ShareY::Rows,
        panels: (0..4).flat_map(|row| sheets.iter().map(move |sheet| sheet[row].clone())).collect(),
        ..Figure::default()
    }
}

/// The sheet of one run. The copies' true discrepancy is one, and stands once.
pub fn run(name: &str, outcome: &Outcome, axis: usize) -> Figure {
    let end = outcome.axes[axis].table.column("time_s").and_then(|time| time.last().copied()).unwrap_or(1.0);
    let peer = |(peer, discrepancy)| {
        let look = Look { window: (0.0, end), from_there: false, first: peer == 1, discrepancy, axis };
        column(&format!("{name}, peer {peer}"), outcome, peer, look)
    };
    let sheets = [(1, Discrepancy::True), (2, Discrepancy::Decoded)].map(peer);
    sheet_of(&format!("Two peers, one object: {name}"), "", sheets.to_vec())
}

/// How a figure calls one kind of communications.
fn title(experiment: &Experiment) -> String {
    let name = match experiment.law {
        "power" => "Power-domain",
        "wave" => "Traditional wave",
        "passive-wave" => "Passive wave",
        other => other,
    };
    // What belongs together is not broken.
    format!("{name}, K_T\u{a0}= {}\u{a0}N/m", experiment.coordination_stiffness_n_per_m)
}

/// Figures 6 to 9 of the cooperation paper and one of position coherency, each with its name.
pub fn paper(experiments: &[Experiment]) -> Vec<(&'static str, Figure)> {
    let of = |section: &str, round_trip_ms: f64| -> Vec<&Experiment> {
        experiments.iter().filter(|one| one.section == section && one.round_trip_ms == round_trip_ms).collect()
    };
    let gains = |number, round_trip_ms| {
        let columns: Vec<_> = of("5.1", round_trip_ms).into_iter().map(|one| (title(one), &one.outcome, 2)).collect();
        let heading = format!("Figure {number}: largest coordination gains, {round_trip_ms} ms round trip (peer 2)");
        let caption = "Each user pushes 0.1 N toward the other; user 1 adds 1 N for 25 ms every 2.5 s. The paper plots the \
                       remote copy as decoded at the same peer; the true one stands beside it. Positions and energy count from 9.5 s on. A run that \
                       stopped is shown from its start until then, at scales of its own.";
        // Two pulses, after the start has settled.
        side_by_side(&heading, caption, &columns, (9.5, 13.5))
    };
    let runs = of("5.2", 16.0);
    let matched = experiments.iter().filter(|one| one.section == "matched-line");
    let matched = matched.map(|one| ("Matched line".to_owned(), &one.outcome, 2));
    let columns: Vec<_> = runs.iter().map(|one| (title(one), &one.outcome, 2)).chain(matched).collect();
    let caption = "Each user pushes 1 N toward the other; user 2 adds 0.25 sin 3t N. The matched line puts the object's mass \
                   into the wave line (b = 40 N s/m) and leaves 20 g to each copy. Positions and energy count from 10 s on.";
    let heading = "Section 5.2: position coherency, 16 ms round trip (peer 2)";
    vec![
        ("figure-6", gains(6, 16.0)),
        ("figure-7", gains(7, 32.0)),
        ("figure-8", forces(&runs)),
        ("figure-9", discrepancies(&runs)),
        ("coherency", side_by_side(heading, caption, &columns, (10.0, 16.0))),
    ]
}

/// Figure 8: coordination forces at peer 2, each line broken as in the paper.
fn forces(runs: &[&Experiment]) -> Figure {
    let dashes = [Dash::DashDot, Dash::Dashed, Dash::Solid];
    let series = runs
        .iter()
        .zip(dashes)
        .enumerate()
        .map(|(at, (one, dash))| {
            Series::dashed(title(one), at, dash, over_time(&one.outcome, 0, "coordination_2_n", 1.0))
        })
        .collect();
    Figure {
        title: "Figure 8: coordination force on the local copy at peer 2, 16 ms round trip".to_owned(),
        columns: 1,
        panels: vec![Panel {
            x_label: "Time (s)".to_owned(),
            y_label: "Coordination force (N)".to_owned(),
            x_range: Some((10.0, 18.0)),
            series,
            ..Panel::default()
        }],
        ..Figure::default()
    }
}

/// Figure 9: mean discrepancies, ours beside the paper's.
fn discrepancies(runs: &[&Experiment]) -> Figure {
    let bars = |label: &str, color: usize, value: &dyn Fn(&Experiment) -> f64| {
        let points = runs.iter().enumerate().map(|(at, one)| (at as f64, value(one))).collect();
        Series::bars(label, color, points)
    };
    let found = |of: fn(&Outcome) -> f64| move |one: &Experiment| one.outcome.metric(of).unwrap_or(f64::NAN);
    Figure {
        title: "Figure 9: mean position discrepancy, 16 ms round trip".to_owned(),
        caption:
            "The paper's remote copy is the one decoded at the same peer; the true discrepancy is larger, because the \
                  wave line itself is a spring."
                .to_owned(),
        columns: 1,
        panels: vec![Panel {
            x_label: "Communications".to_owned(),
            y_label: "Discrepancy (mm)".to_owned(),
            categories: runs.iter().map(|one| title(one)).collect(),
            series: vec![
                bars("paper, Fig. 9", 0, &|one| one.paper_discrepancy_mm.unwrap_or(f64::NAN)),
                bars("decoded |x_o - x_d|", 1, &found(|o| o.whole.decoded_discrepancy_mm)),
                bars("true |x_o1 - x_o2|", 2, &found(|o| o.whole.true_discrepancy_mm)),
            ],
            ..Panel::default()
        }],
        ..Figure::default()
    }
}
