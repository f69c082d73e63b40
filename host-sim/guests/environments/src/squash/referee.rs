//! The referee: sees everything in true time, and nothing of what the roles compute to protect themselves.
//!
//! Whether a ball had left the court when the next player got to know of it is reckoned here anew, from the moment of the
//! hit, the moment of the news and the way to the open back; the score is counted anew from who made which hit.

use std::collections::HashMap;

use serde::Serialize;

use crate::roles::squash::{Ball, Court, Ending, PLAYERS, Turn, Verdict};

/// What a game came to.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// Number of rallies that ended.
    pub rallies: u32,
    /// Hits, serves among them.
    pub strokes: u32,
    /// Hits in the longest rally.
    pub(crate) longest_rally: u16,
    /// Rallies that a player lost by not hitting the ball, or not to the front.
    pub lost: u32,
    /// Rallies that were played again because the ball had left the court before the active player knew of the hit.
    pub unseen: u32,
    /// Rallies that were played again because somebody had gone.
    pub broken: u32,
    /// Hits of which the next player heard when the ball had left the court: the referee's count.
    pub left_the_court: u32,
    /// All rallies were played, and everybody who was there knew.
    pub over: bool,
    /// Every player and the server have the same result of every rally, and the score that the referee counts.
    pub agreed: bool,
    /// What was not agreed on first.
    pub(crate) disagreement: Option<String>,
    /// Results that somebody heard before the rally's last hit.
    pub(crate) results_before_hits: u32,
    /// Points of each player.
    pub score: Vec<u8>,
    /// Longest round trip that the server knew of in the end, ms; 0 without the bounder.
    pub round_trip_ms: f64,
    /// Largest speed of the ball, m/s.
    pub fastest_m_per_s: f64,
    /// Hits that a bounder made softer.
    pub bounded: u32,
    /// Farthest that any ball flew before the next player knew of the hit, m.
    pub farthest_before_news_m: f64,
    /// Farthest that somebody's ball had to be moved when a hit became known, m.
    pub largest_correction_m: f64,
    /// Farthest that a hand moved in one round trip, m.
    pub hand_travel_m: f64,
    /// Largest difference between a hand and what another player had last heard of it, m.
    pub(crate) hand_error_m: f64,
    /// Largest force of a hit on a device, as a pulse of one control period, N.
    pub(crate) largest_pulse_n: f64,
    /// Bytes that a player sent in a second, sealed.
    pub(crate) bytes_per_s: f64,
    /// Hash of everything that the players know in the end.
    pub state_hash: String,
}

/// One hit as it was.
struct Hit {
    by: u8,
    at_s: f64,
    ball: Ball,
    known: bool,
}

/// What the referee has seen.
pub(super) struct Referee {
    court: Court,
    hits: HashMap<(u16, u16), Hit>,
    verdicts: Vec<Verdict>,
    score: [u8; PLAYERS],
    /// The results that were reported to each player.
    reported: Vec<Vec<Verdict>>,
    pub(super) report: Report,
}

impl Referee {
    /// Before a game of so many players.
    pub(super) fn new(court: Court, players: u8) -> Self {
        Self {
            court,
            hits: HashMap::new(),
            verdicts: Vec::new(),
            score: [0; PLAYERS],
            reported: vec![Vec::new(); usize::from(players)],
            report: Report { agreed: true, ..Report::default() },
        }
    }

    /// Player `by` (1, 2 …) has hit the ball.
    pub(super) fn hit(&mut self, at_s: f64, by: u8, turn: Turn, ball: Ball, bounded: bool) {
        let report = &mut self.report;
        report.strokes += 1;
        report.bounded += u32::from(bounded);
        report.longest_rally = report.longest_rally.max(turn.stroke);
        let [vx, vy] = ball.velocity.map(f64::from);
        report.fastest_m_per_s = report.fastest_m_per_s.max(vx.hypot(vy));
        self.hits.insert((turn.rally, turn.stroke), Hit { by, at_s, ball, known: false });
    }

    /// Who is next has heard of a hit.
    pub(super) fn next_knows(&mut self, at_s: f64, turn: Turn) {
        let Some(hit) = self.hits.get_mut(&(turn.rally, turn.stroke)).filter(|hit| !hit.known) else { return };
        hit.known = true;
        let flown_s = at_s - hit.at_s;
        let ([vx, vy], x) = (hit.ball.velocity.map(f64::from), f64::from(hit.ball.position[0]));
        // Forward to the front wall, and all the way back.
        let distance_m = 2.0 * f64::from(self.court.length_m) - x;
        self.report.left_the_court += u32::from(flown_s * vx > distance_m);
        self.report.farthest_before_news_m = self.report.farthest_before_news_m.max(flown_s * vx.hypot(vy));
    }

    /// The server has decided.
    pub(super) fn decided(&mut self, verdict: Verdict) {
        let report = &mut self.report;
        report.rallies += 1;
        match verdict.ending {
            Ending::Missed | Ending::Fault => report.lost += 1,
            Ending::Unseen => report.unseen += 1,
            Ending::Broken | Ending::None => report.broken += 1,
        }
        if matches!(verdict.ending, Ending::Missed | Ending::Fault)
            && let Some(hit) = self.hits.get(&(verdict.rally, verdict.strokes))
        {
            self.score[usize::from(hit.by) - 1] += 1;
        }
        self.verdicts.push(verdict);
    }

    /// A result is reported to player `by`, having heard of so many hits.
    pub(super) fn reported(&mut self, by: u8, verdict: Verdict, score: [u8; PLAYERS], seen: u16) {
        let at = usize::from(by) - 1;
        self.report.results_before_hits += u32::from(seen < verdict.strokes);
        self.reported[at].push(verdict);
        if self.reported[at].len() == self.verdicts.len() && score != self.score {
            self.disagree(format!("player {by} has the score {score:?}, the referee {:?}", self.score));
        }
    }

    /// What a player who comes back has not been told, for it was not there.
    pub(super) fn came_back(&mut self, by: u8) {
        let at = usize::from(by) - 1;
        self.reported[at].clone_from(&self.verdicts);
        self.reported[at].pop();
    }

    fn disagree(&mut self, what: String) {
        self.report.agreed = false;
        self.report.disagreement.get_or_insert(what);
    }

    /// The end: whoever is still there must have been told everything, but for what is still on its way.
    pub(super) fn ends(&mut self, present: &[bool], on_its_way: usize) {
        for (at, reported) in self.reported.clone().into_iter().enumerate() {
            let complete = reported.len() + on_its_way >= self.verdicts.len() || !present[at];
            if !self.verdicts.starts_with(&reported) || !complete {
                let differs = reported.iter().zip(&self.verdicts).find(|(one, two)| one != two);
                self.disagree(format!(
                    "player {} was told {} results of {}, and differs in {differs:?}",
                    at + 1,
                    reported.len(),
                    self.verdicts.len()
                ));
            }
        }
        self.report.score = self.score.to_vec();
    }
}

#[cfg(test)]
#[path = "../../tests/inside/squash_referee.rs"]
mod tests;
