//! Pictures of runs: the cooperation paper's Figures 6–9, and one sheet for any scene.

use super::paper::Experiment;
use haptic_plot::{Dash, Figure, Panel, Series, ShareY};
use haptic_sim::run::Outcome;

/// One column of a table over time, scaled.
fn over_time(outcome: &Outcome, column: &str, scale: f64) -> Vec<(f64, f64)> {
    outcome.table.points("time_s", column, scale)
}

/// Position of local and remote copy, coordination force, discrepancy and energy ledger: one column of a sheet.
fn column(title: &str, outcome: &Outcome, peer: usize, window: (f64, f64), first: bool) -> [Panel; 4] {
    let other = 3 - peer;
    // A run that stopped shows how it came to that.
    let window =
        outcome.fault_time_s.map_or(window, |stop| ((stop - (window.1 - window.0) + 0.5).max(0.0), stop + 0.5));
    let panel = |title: &str, y_label: &str, series: Vec<Series>| Panel {
        title: title.to_owned(),
        x_label: "Time (s)".to_owned(),
        y_label: y_label.to_owned(),
        x_range: Some(window),
        off_scale: !outcome.bounded,
        note: outcome
            .fault
            .zip(outcome.fault_time_s)
            .filter(|_| !title.is_empty())
            .map(|((peer, fault), time_s)| format!("peer {peer} stops at {time_s:.2} s: {fault:?}")),
        series,
        ..Panel::default()
    };
    // A legend in the first column serves the row.
    let label = |text: &str| if first { text.to_owned() } else { String::new() };
    let names = [format!("object_{peer}_m"), format!("desired_{peer}_m"), format!("object_{other}_m")];
    let [local, decoded, remote] = names.map(|name| over_time(outcome, &name, 1e3));
    let energy = |name: &str| over_time(outcome, &format!("energy_{name}_{peer}_j"), 1.0);
    let net = energy("received").into_iter().zip(energy("sent")).map(|((t, a), (_, b))| (t, a - b)).collect();
    [
        panel(
            title,
            "Position (mm)",
            vec![
                Series::line(label("local copy"), 0, local),
                Series::dashed(label("remote copy, decoded here"), 1, Dash::Dashed, decoded),
                Series::dashed(label("remote copy, true"), 2, Dash::Dotted, remote),
            ],
        ),
        panel(
            "",
            "Coordination force (N)",
            vec![Series::line("", 0, over_time(outcome, &format!("coordination_force_{peer}_n"), 1.0))],
        ),
        panel(
            "",
            "Discrepancy (mm)",
            vec![
                Series::line(label("true"), 2, over_time(outcome, "true_discrepancy_m", 1e3)),
                Series::dashed(
                    label("decoded, peer 2"),
                    1,
                    Dash::Dashed,
                    over_time(outcome, "decoded_discrepancy_2_m", 1e3),
                ),
            ],
        ),
        panel("", "Net energy from network (J)", vec![Series::line("", 3, net)]),
    ]
}

/// A column of a figure: its title, the run, and which peer's.
type OfPeer<'a> = (String, &'a Outcome, usize);

/// Columns side by side on equal axes.
fn side_by_side(title: &str, caption: &str, columns: &[OfPeer<'_>], window: (f64, f64)) -> Figure {
    let sheet = |(at, (title, outcome, peer)): (usize, &OfPeer<'_>)| column(title, outcome, *peer, window, at == 0);
    let sheets: Vec<[Panel; 4]> = columns.iter().enumerate().map(sheet).collect();
    Figure {
        title: title.to_owned(),
        caption: caption.to_owned(),
        columns: columns.len(),
        share_y: ShareY::Rows,
        panels: (0..4).flat_map(|row| sheets.iter().map(move |sheet| sheet[row].clone())).collect(),
        ..Figure::default()
    }
}

/// The sheet of one run.
pub fn run(name: &str, outcome: &Outcome) -> Figure {
    let end = outcome.table.column("time_s").and_then(|time| time.last().copied()).unwrap_or(1.0);
    let columns = [1, 2].map(|peer| (format!("{name}, peer {peer}"), outcome, peer));
    side_by_side(&format!("Two peers, one object: {name}"), "", &columns, (0.0, end))
}

/// How a figure calls one kind of communications.
fn title(experiment: &Experiment) -> String {
    let name = match experiment.comm {
        "power" => "Power-domain",
        "wave" => "Traditional wave",
        "passive-wave" => "Passive wave",
        other => other,
    };
    format!("{name}, K_T = {} N/m", experiment.coordination_stiffness_n_per_m)
}

/// Figures 6 to 9 of the cooperation paper and one of position coherency, each with its name.
pub(crate) fn paper(experiments: &[Experiment]) -> Vec<(&'static str, Figure)> {
    let of = |section: &str, round_trip_ms: f64| -> Vec<&Experiment> {
        experiments.iter().filter(|one| one.section == section && one.round_trip_ms == round_trip_ms).collect()
    };
    let gains = |number, round_trip_ms| {
        let columns: Vec<_> = of("5.1", round_trip_ms).into_iter().map(|one| (title(one), &one.outcome, 2)).collect();
        let heading = format!("Figure {number}: largest coordination gains, {round_trip_ms} ms round trip (peer 2)");
        let caption = "Each user pushes 0.1 N toward the other; user 1 adds 1 N for 25 ms every 2.5 s. The paper plots the \
                       remote copy as decoded at the same peer; the true one stands beside it. An unstable run is shown \
                       as it comes to a fault, cut at the others' scale.";
        // Two pulses, after the start has settled; an unstable run shows how it begins.
        side_by_side(&heading, caption, &columns, (9.5, 13.5))
    };
    let runs = of("5.2", 16.0);
    let matched = experiments.iter().filter(|one| one.section == "matched-line");
    let matched = matched.map(|one| ("Matched line".to_owned(), &one.outcome, 2));
    let columns: Vec<_> = runs.iter().map(|one| (title(one), &one.outcome, 2)).chain(matched).collect();
    let caption = "Each user pushes 1 N toward the other; user 2 adds 0.25 sin 3t N. The matched line puts the object's mass \
                   into the wave line (b = 40 N s/m) and leaves 20 g to each copy.";
    let heading = "Section 5.2: position coherency, 16 ms round trip (peer 2)";
    vec![
        ("figure-6", gains(6, 16.0)),
        ("figure-7", gains(7, 32.0)),
        ("figure-8", forces(&runs)),
        ("figure-9", discrepancies(&runs)),
        ("coherency", side_by_side(heading, caption, &columns, (10.0, 16.0))),
    ]
}

/// Figure 8: coordination forces at peer 2.
fn forces(runs: &[&Experiment]) -> Figure {
    let series = runs
        .iter()
        .enumerate()
        .map(|(at, one)| Series::line(title(one), at, over_time(&one.outcome, "coordination_force_2_n", 1.0)))
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
                bars("decoded |x_o - x_d|", 1, &|one| {
                    one.outcome.merit(|o| o.decoded_discrepancy_mm).unwrap_or(f64::NAN)
                }),
                bars("true |x_o1 - x_o2|", 2, &|one| one.outcome.whole(|o| o.true_discrepancy_mm).unwrap_or(f64::NAN)),
            ],
            ..Panel::default()
        }],
        ..Figure::default()
    }
}
