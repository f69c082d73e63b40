//! A game as figures: the court from above, and where everybody thinks that the ball is.

use cohold_plot::{Dash, Figure, Panel, Series, ShareY};

use super::game::{Game, Moment, Options};
use crate::roles::squash::Court;

/// Time shown in the second figure, s.
const SHOWN_S: f64 = 6.0;

/// How the lines of players are broken, in turn, so that they are told apart without colours and where they lie on each other.
const DASHES: [Dash; 4] = [Dash::Solid, Dash::Dashed, Dash::DashDot, Dash::Dotted];

/// The longest rally of a game.
pub fn figure(game: &Game, options: &Options) -> Figure {
    let longest =
        game.moments.iter().map(|moment| moment.turn).max_by_key(|(rally, stroke)| (*stroke, u16::MAX - *rally));
    let rally = longest.map_or(0, |(rally, _)| rally);
    let moments: Vec<&Moment> =
        game.moments.iter().filter(|moment| moment.turn.0 == rally && moment.turn.1 > 0).collect();
    let first_s = moments.first().map_or(0.0, |moment| moment.time_s);
    let [length, width] = [Court::SINGLES.length_m, Court::SINGLES.width_m].map(f64::from);
    let players = usize::from(options.players);
    let ball = |moment: &Moment, at: usize| moment.balls[at].map(|ball| ball.position.map(f64::from));
    // Of the player who is to hit it, as that player sees it: what counts.
    let path: Vec<(f64, f64)> =
        moments.iter().filter_map(|moment| ball(moment, moment.active?)).map(|[x, y]| (y, x)).collect();
    let player = |name: String, at: usize, way| Series::dashed(name, at + 1, DASHES[at % DASHES.len()], way);
    let mut above = vec![Series::line("ball", 0, path).wide(5.0)];
    above.extend((0..players).map(|at| {
        let way = moments.iter().map(|moment| (moment.hands[at][1], moment.hands[at][0])).collect();
        player(format!("player {}", at + 1), at, way)
    }));
    let shown = |moment: &&&Moment| moment.time_s - first_s <= SHOWN_S;
    let along = (0..players).map(|at| {
        let points = moments
            .iter()
            .filter(shown)
            .map(|moment| (moment.time_s - first_s, ball(moment, at).map_or(f64::NAN, |[x, _]| x)))
            .collect();
        // One legend serves both.
        player(String::new(), at, points)
    });
    let report = &game.report;
    // Unknown until everybody has measured it.
    let bound = if options.bounder && report.round_trip_ms > 0.0 {
        format!("ball bounded to {:.1} m/s", length / report.round_trip_ms * 1e3)
    } else {
        "no bound".to_owned()
    };
    Figure {
        title: format!("Squash, {players} players, round trip {:.0} ms, {bound}", options.round_trip_s * 1e3),
        caption: format!(
            "Rally {rally}, the longest of {}. Left: from above, the ball as the active player sees it. Right: the distance of the \
             ball from the back as each player reckons it; a jump is a hit that has become known. Balls that left the court \
             before the next player knew: {}.",
            report.rallies, report.left_the_court
        ),
        columns: 2,
        share_x: false,
        share_y: ShareY::Rows,
        panels: vec![
            Panel {
                x_label: "y (m)".to_owned(),
                y_label: "x from the back (m)".to_owned(),
                x_range: Some((0.0, width)),
                y_range: Some((0.0, length)),
                series: above,
                ..Panel::default()
            },
            Panel {
                x_label: "Time (s)".to_owned(),
                y_label: "x from the back (m)".to_owned(),
                y_range: Some((0.0, length)),
                series: along.collect(),
                ..Panel::default()
            },
        ],
    }
}
