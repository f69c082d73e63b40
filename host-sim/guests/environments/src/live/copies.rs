//! How far the copies of a hub's peers are from each other, as each peer reports its own now and then.

use cohold_live::discrepancy::{Discrepancy, KEPT_S, PositionHistory};
use cohold_live::recording::common_clock::Watched;
use cohold_protocol::wire::Telemetry;

/// Recent positions of the copies of several peers, as each reports its own now and then.
#[derive(Clone, Debug)]
pub(crate) struct Copies {
    lines: Vec<PositionHistory>,
    /// By how much the clock of each may be wrong, s.
    errors_s: Vec<f64>,
    /// The instant that was looked at last, s.
    looked_s: f64,
}

impl Copies {
    /// For so many lines, on none of which a peer has reported anything yet.
    pub(crate) fn new(lines: usize) -> Self {
        Self { lines: vec![PositionHistory::default(); lines], errors_s: vec![0.0; lines], looked_s: f64::NEG_INFINITY }
    }

    /// What the peer on a line says, in a datagram that was sealed at this time of its clock. Gives how far the copies are apart at
    /// the newest instant of which all have reported, between two tellings each; those who have not reported for 3 s
    /// are left out.
    pub(crate) fn observe(
        &mut self,
        line: usize,
        said: &Telemetry,
        sealed_us: u64,
        period_s: f64,
        clock: &Watched,
    ) -> Option<Discrepancy> {
        let relation = clock.relation.as_ref()?;
        if said.mode != 1 {
            self.lines[line].forget();
            return None;
        }
        let at_s = relation.own_s(sealed_us as f64 * 1e-6 - period_s);
        if self.lines[line].newest_s().is_none_or(|newest_s| at_s > newest_s) {
            self.lines[line].is_at(at_s, said.object_position.into());
        }
        self.errors_s[line] = relation.error_s(at_s);
        let newest = self.lines.iter().filter_map(PositionHistory::newest_s);
        let latest_s = newest.clone().fold(f64::NEG_INFINITY, f64::max);
        let known_s = newest.filter(|newest_s| *newest_s > latest_s - KEPT_S).fold(f64::INFINITY, f64::min);
        if known_s <= self.looked_s {
            return None;
        }
        let places = self.lines.iter().zip(&self.errors_s);
        let places: Vec<_> = places
            .filter_map(|(own, error_s)| {
                let (position_m, _) = own.was_at(known_s)?;
                Some((position_m, own.strays_m(known_s, *error_s) + own.bent_m(known_s)))
            })
            .collect();
        if places.len() < 2 {
            return None;
        }
        self.looked_s = known_s;
        let (least, most) =
            places.iter().fold((f64::MAX, f64::MIN), |(least, most), (at, _)| (least.min(*at), most.max(*at)));
        // Two of them are the farthest apart, each of which may be wrong.
        let [first_m, second_m] = places.iter().fold([0.0_f64; 2], |[first_m, second_m], (_, error_m)| {
            [first_m.max(*error_m), second_m.max(error_m.min(first_m))]
        });
        Some(Discrepancy { offset_m: most - least, error_m: first_m + second_m })
    }
}
