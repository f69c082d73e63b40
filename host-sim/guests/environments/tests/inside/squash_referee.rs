//! Tests of `src/squash/referee.rs` from inside.

use cohold_protocol::wire::PeerId;

use super::*;

fn game() -> (Referee, Verdict) {
    let mut referee = Referee::new(Court::SINGLES, 2);
    let ball = Ball { position: [8.75, 1.0], velocity: [50.0, 0.0] };
    referee.hit(1.0, 2, Turn { rally: 1, stroke: 1 }, ball, false);
    (referee, Verdict { rally: 1, strokes: 1, ending: Ending::Missed, loser: PeerId(1) })
}

#[test]
fn a_ball_has_left_after_the_way_to_the_front_and_back() {
    // 1 m to the front and 9.75 m back, at 50 m/s: 0.215 s.
    for (news_s, left) in [(1.214, 0), (1.216, 1)] {
        let (mut referee, _) = game();
        referee.next_knows(news_s, Turn { rally: 1, stroke: 1 });
        assert_eq!(referee.report.left_the_court, left);
    }
}

#[test]
fn whoever_was_told_something_else_disagrees() {
    let (mut referee, verdict) = game();
    referee.decided(verdict);
    let score = [0, 1, 0, 0, 0, 0, 0, 0];
    referee.reported(1, verdict, score, 1);
    referee.reported(2, verdict, score, 0);
    referee.ends(&[true, true], 0);
    assert!(referee.report.agreed && referee.report.results_before_hits == 1);

    let (mut referee, verdict) = game();
    referee.decided(verdict);
    referee.reported(1, Verdict { strokes: 2, ..verdict }, score, 1);
    referee.ends(&[true, false], 0);
    assert!(!referee.report.agreed);

    let (mut referee, verdict) = game();
    referee.decided(verdict);
    referee.reported(1, verdict, [1, 0, 0, 0, 0, 0, 0, 0], 1);
    assert!(referee.report.disagreement.unwrap().contains("the score [1, 0"));

    let (mut referee, verdict) = game();
    referee.decided(verdict);
    referee.ends(&[true, false], 0);
    assert!(referee.report.disagreement.unwrap().contains("player 1 was told 0 results of 1"));
}
