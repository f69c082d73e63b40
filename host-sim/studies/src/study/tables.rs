//! The tables of a study: every run, every point, the answers, and the pairs.

use cohold_report::{Cell, Columns, Holds, Rows};

use super::answers::{Answer, Counts, Goal, Next};
use super::halving::LeftOut;
use super::pairs::Pair;
use super::{Place, Study};
use crate::sweep::{METRICS, Row, Summed, of_points, of_runs};

/// What the number of a point means.
const POINT: &str =
    "which point, from 0: an entrant over a network at a point of the grid, which varies fastest, then the networks";
const ENTRANT: &str = "the scene or law, with its own settings";
/// Not `network`: a document nests keys that are varied, such as `network.loss`, below it.
const NETWORK: &str = "the network; own: as each scene has it";

impl Study {
    /// Columns that say which point it is.
    fn of_place<'a, R>(&self, rows: Rows<'a, R>, point: impl Fn(&R) -> usize + Copy) -> Rows<'a, R> {
        let rows = rows.data("point", point).means(POINT);
        let rows = self.of_names(rows, move |row| self.place(point(row)));
        self.grid().of_keys(rows, move |row| Some(self.place(point(row)).grid))
    }

    /// Columns that say whose point on which network it is.
    fn of_names<'a, R>(&self, rows: Rows<'a, R>, place: impl Fn(&R) -> Place + Copy) -> Rows<'a, R> {
        rows.value("entrant", move |row| self.entrants[place(row).entrant].name.as_str())
            .means(ENTRANT)
            .value("network_name", move |row| self.networks[place(row).network].name.as_str())
            .means(NETWORK)
            .head("network")
    }

    /// Every run.
    pub fn columns(&self, rows: &[Row]) -> Columns {
        of_runs(self.of_place(Columns::of(rows), |row| row.point))
    }

    /// Every point: means over all seeds that it has, and those that a search has left out.
    pub fn summary(&self, rows: &[Row], left_out: &[LeftOut]) -> Columns {
        let mut points = Summed::each(rows);
        points.extend(left_out.iter().map(|LeftOut { point, unstable_modes }| Summed {
            point: *point,
            runs: &[],
            unstable_modes,
        }));
        points.sort_by_key(|one| one.point);
        of_points(self.of_place(Columns::of(&points), |one| one.point))
    }

    /// The best points.
    pub fn answer_columns(&self, answers: &[Answer], goal: &Goal) -> Columns {
        let place = |answer: &Answer| Place { entrant: answer.entrant, network: answer.network, grid: 0 };
        let rows = self.of_names(Columns::of(answers), place);
        let grid = |answer: &Answer| answer.best.as_ref().map(|best| self.place(best.point).grid);
        // The ends of what is as good, along the first key.
        let first = self.grid().keys().next().map(|key| self.grid().holds(key));
        let end = |answer: &Answer, last: bool| {
            let as_good = answer.best.as_ref().map_or(&[][..], |best| &best.as_good);
            let at = if last { as_good.last() } else { as_good.first() };
            first.zip(at).map_or(Cell::Empty, |(holds, at)| self.grid().cell(*at, 0, holds))
        };
        let holds = first.unwrap_or(Holds::Texts);
        let seeds = |answer: &Answer| answer.best.as_ref().map(|best| best.seeds);
        fn next(answer: &Answer) -> Option<&Next> {
            answer.best.as_ref()?.next.as_ref()
        }
        self.grid()
            .of_keys(rows, grid)
            .data("merit", |_| METRICS[goal.metric].name())
            .means("figure of merit; the mean is in its unit")
            .significant("mean", 4, |answer| answer.best.as_ref().map(|best| best.judged.mean))
            .means("mean over the seeds that judge, which did not choose the point")
            .significant("mean_95", 2, |answer| answer.best.as_ref()?.judged.within_95)
            .head("±")
            .means("half of its 95 % interval (Student)")
            .value("seeds", seeds)
            .means("seeds that judge")
            .value("as_good_points", |answer| answer.best.as_ref().map(|best| best.as_good.len()))
            .means("points that may be taken and are not told from the best one, itself included")
            .head("as good")
            .cells("as_good_from", holds, |answer| end(answer, false))
            .means("value of the first key at the first of them")
            .head("from")
            .cells("as_good_to", holds, |answer| end(answer, true))
            .means("and at the last")
            .head("to")
            .data("next", |answer| next(answer).map(|next| self.grid().values(next.grid).join(", ")))
            .means("values of the keys at the point that comes closest to the best one by the seeds that choose")
            .data("next_difference", |answer| next(answer).map(|next| next.difference.mean))
            .means("its figure less the best one's, over the same seeds")
            .data("next_difference_95", |answer| next(answer)?.difference.within_95)
            .means("half of the 95 % interval of the paired differences (Student)")
            .data("next_seeds", |answer| next(answer).map(|next| next.seeds))
            .means("over how many seeds")
            .data("next_judged", |answer| next(answer).map(|next| next.judged))
            .means("whether they judge; else a search gave the point up after so many of those that choose, which favour the best one")
            .value("points", |answer| answer.counts.points)
            .means("points of the grid")
            .value("allowed_points", |answer| answer.counts.allowed())
            .means("those that may be taken: every run stable, stable in every mode, within the bounds")
            .head("allowed")
            .data("failed_points", |answer| answer.counts.failed)
            .means("those of which a run is not stable")
            .data("let_go_points", |answer| answer.counts.let_go)
            .means("of the others, those that are not stable in every mode; a search does not run them, and counts them all here")
            .data("beyond_points", |answer| answer.counts.beyond)
            .means("of the others, those of which a run is beyond a bound")
            .data("given_up_points", |answer| answer.counts.given_up)
            .means("of the others, those that a search gave up as worse before they had all their seeds")
            .value("reason", |answer| reason(answer.counts))
            .means("why other points may not be taken")
            .done()
    }

    /// The pairs.
    pub fn pair_columns(&self, pairs: &[Pair]) -> Columns {
        let name = |which: usize| move |pair: &Pair| self.entrants[pair.entrants[which]].name.as_str();
        let network = |pair: &Pair| pair.network.map_or("all in common", |at| self.networks[at].name.as_str());
        let of = |pair: &Pair| if pair.network.is_some() { 1 } else { self.networks.len() };
        let without = |pair: &Pair| {
            let asked = pair.network.map_or(0..self.networks.len(), |at| at..at + 1);
            let missing = asked.filter(|at| !pair.common.contains(at)).map(|at| self.networks[at].name.as_str());
            missing.collect::<Vec<_>>().join("; ")
        };
        let mean = |which: usize| move |pair: &Pair| pair.paired.means[which];
        Columns::of(pairs)
            .value("first", name(0))
            .means("a scene or law, at its best point on each network")
            .value("entrant", name(1))
            .means("another one, at its own best points")
            .value("network_name", network)
            .means("the network, or all on which both have a point that may be taken")
            .head("network")
            .value("common_networks", |pair| pair.common.len())
            .means("networks on which both have such a point: nothing else is compared")
            .head("common")
            .value("of_networks", of)
            .means("networks that were asked for")
            .head("of")
            .significant("first_mean", 4, mean(0))
            .means("the first one's figure of merit, mean over these networks and the seeds that judge")
            .significant("mean", 4, mean(1))
            .means("the same of the other one")
            .significant("difference", 3, |pair| pair.paired.difference.map(|found| found.mean))
            .means("the second mean less the first")
            .significant("difference_95", 2, |pair| pair.paired.difference?.within_95)
            .head("±")
            .means("half of the 95 % interval of the paired differences over the seeds (Student)")
            .value("differs", |pair| pair.paired.differs())
            .means("whether the interval leaves out 0")
            .value("without", without)
            .means("networks on which one of them has no such point")
            .done()
    }
}

/// Why points may not be taken.
fn reason(counts: Counts) -> Option<String> {
    let said = [
        (counts.failed, "not stable in a run"),
        (counts.let_go, "not in every mode"),
        (counts.beyond, "beyond a bound"),
        (counts.given_up, "given up as worse"),
    ];
    let said = said.iter().filter(|(count, _)| *count > 0).map(|(count, why)| format!("{count} {why}"));
    Some(said.collect::<Vec<_>>().join(", ")).filter(|said| !said.is_empty())
}
