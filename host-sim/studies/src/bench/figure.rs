//! The fronts as a picture: a panel a law, every other law's front behind it.

use cohold_plot::{Dash, Figure, Panel, Series, ShareY};

use super::Found;
use super::points::Point;

/// Black, and the colours of a front and of what a law declares.
const BLACK: usize = 6;
const FRONT: usize = 0;
const DECLARED: usize = 1;

/// Where a point lies: |Z| that a hand feels at 1 Hz, and the worst network's distance; none where either is missing.
fn place(point: &Point) -> Option<(f64, f64)> {
    Some((point.tuning.felt_n_s_per_m[1], point.worst_mm_per_n()?)).filter(|(felt, _)| !felt.is_nan())
}

/// The tuned points of a law, or what it declares.
fn places(points: &[Point], declared: bool) -> Vec<(f64, f64)> {
    let of = points.iter().filter(|point| (point.name == "declared") == declared);
    let mut places: Vec<(f64, f64)> = of.filter_map(place).collect();
    places.sort_by(|one, other| one.0.total_cmp(&other.0));
    places.dedup();
    places
}

/// True discrepancy of the worst network against what a hand feels, law by law.
pub fn fronts(found: &Found) -> Figure {
    let best: Vec<Point> = found.best().cloned().collect();
    let laws: Vec<&[Point]> = best.chunk_by(|one, other| one.law.name == other.law.name).collect();
    let behind: Vec<Series> = laws.iter().map(|law| Series::line("", BLACK, places(law, false)).wide(0.7)).collect();
    let panel = |(at, law): (usize, &&[Point])| {
        let label = |text| if at == 0 { text } else { "" };
        let front = places(law, false);
        let none = front.is_empty().then(|| "none within the bounds".to_owned());
        let mut series = behind.clone();
        series.push(Series::dashed("", FRONT, Dash::Solid, front.clone()).wide(2.2));
        series.push(Series::dots(label("tuned"), FRONT, front, Vec::new()));
        let declared = places(law, true);
        // A name beside the dot, so that no colour has to tell.
        let names = declared.iter().map(|_| "own".to_owned()).collect();
        series.push(Series::dots(label("own gains"), DECLARED, declared, names));
        Panel {
            title: law[0].law.name.to_owned(),
            x_label: "|Z| at 1 Hz (N·s/m)".to_owned(),
            y_label: "True (mm/N)".to_owned(),
            x_range: Some((3.0, 100.0)),
            log_x: true,
            log_y: true,
            note: none,
            series,
            ..Panel::default()
        }
    };
    Figure {
        title: "How near the copies are, against what a hand feels".to_owned(),
        caption: "Of every law the best gains that the same searches found under three bounds of what a hand alone feels, on networks apart from these; the \
                  worst of the test networks. Thin: the fronts of all others. Lower and further left is better."
            .to_owned(),
        columns: 3,
        share_x: true,
        share_y: ShareY::All,
        panels: laws.iter().enumerate().map(panel).collect(),
    }
}
