//! The bench as tables: a row a law, whole or in three parts that fit a page, and a row a law and frequency.

use cohold_analysis::Limit;
use cohold_report::{Columns, Rows};
use cohold_sim::run::{Outcome, Verdict};

use super::super::Cell;
use super::stability::{Stability, stable_to};
use super::touch::Point;
use super::{PACKET_BYTES, Row};

impl Row {
    fn count(&self, verdict: Verdict) -> usize {
        let worst = |cell: &&Cell| match verdict {
            Verdict::Stable => cell.is_stable(),
            Verdict::Apart => cell.count(Verdict::Unstable) == 0 && cell.count(Verdict::Apart) > 0,
            Verdict::Unstable => cell.count(Verdict::Unstable) > 0,
        };
        self.cells.iter().filter(worst).count()
    }

    /// Over the networks on which every run is stable.
    fn stable<T>(&self, of: impl Fn(&Cell) -> Option<T>) -> Option<Vec<T>> {
        let values: Option<Vec<T>> = self.cells.iter().filter(|cell| cell.is_stable()).map(of).collect();
        values.filter(|values| !values.is_empty())
    }

    pub(super) fn mean(&self, of: impl Fn(&Cell) -> Option<f64>) -> Option<f64> {
        self.stable(of).map(|values| values.iter().sum::<f64>() / values.len() as f64)
    }

    fn most(&self, of: impl Fn(&Cell) -> Option<f64>) -> Option<f64> {
        self.stable(of)?.into_iter().reduce(f64::max)
    }

    /// The largest of every run over every network, those that failed among them.
    fn largest(&self, of: impl Fn(&Outcome) -> f64) -> f64 {
        self.cells.iter().flat_map(|cell| &cell.outcomes).map(of).fold(0.0, f64::max)
    }

    fn limit(&self, of: impl Fn(&Stability) -> &Limit) -> Option<f64> {
        self.stability.as_ref().ok().map(|stability| stable_to(of(stability)))
    }

    /// What it promises and whether that was kept, in words.
    pub(super) fn promise_texts(&self) -> Option<String> {
        let promise_texts = |kept: &super::Kept| {
            format!("{}: {} ({})", kept.promise.name(), if kept.kept { "kept" } else { "NOT KEPT" }, kept.found)
        };
        let all: Vec<String> = self.promises.iter().map(promise_texts).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }
}

/// A row a law.
fn named(rows: &[Row]) -> Rows<'_, Row> {
    Columns::of(rows).value("law", |row| row.law.name).means("what coordination.comm calls it")
}

/// What came of it over the networks.
fn over_networks<'a>(rows: Rows<'a, Row>) -> Rows<'a, Row> {
    let true_mm = |cell: &Cell| cell.true_discrepancy_mm().map(|estimate| estimate.mean);
    rows
        .data("source", |row| Some(row.law.source).filter(|source| !source.is_empty()))
        .means("where it was published")
        .data("promises", Row::promise_texts)
        .means("what it promises, and whether that was kept here")
        .value("promises_kept", |row| (!row.promises.is_empty()).then(|| row.promises.iter().all(|kept| kept.kept)))
        .means("whether every promise was kept")
        .head("kept")
        .number("stiffness_n_per_m", 0, |row| row.scene.peer.coordination.stiffness_n_per_m)
        .means("K_T, as the law declares it")
        .head("K_T")
        .value("stable_networks", |row| row.count(Verdict::Stable))
        .means("networks on which every run is stable")
        .head("stable")
        .value("apart_networks", |row| row.count(Verdict::Apart))
        .means("networks on which copies came apart in a run and nothing worse happened")
        .head("apart")
        .value("unstable_networks", |row| row.count(Verdict::Unstable))
        .means("networks on which a run stopped or grew")
        .head("NO")
        .number("true_discrepancy_mm", 2, move |row| true_mm(row.own()))
        .means("mean of |x_o1 - x_o2| on the scene's own network")
        .head("true")
        .number("decoded_discrepancy_mm", 2, |row| row.own().decoded_discrepancy_mm().map(|estimate| estimate.mean))
        .means("mean of |x_o - x_d| on the scene's own network")
        .head("decoded")
        .number("mean_true_discrepancy_mm", 2, move |row| row.mean(true_mm))
        .means("true discrepancy, mean over the networks on which it is stable")
        .head("mean true")
        .number("worst_true_discrepancy_mm", 1, |row| row.most(|cell| cell.worst(|o| o.whole.largest_true_discrepancy_mm)))
        .means("the largest at any instant on any of those networks")
        .head("worst true")
        .number("energy_made_mj", 3, |row| row.largest(Outcome::energy_made_mj))
        .means("channel: the most, at the end of any tick, that a peer had taken from the network beyond what the other one had given to it, the largest of every run over every network")
        .head("channel made")
        .number("peer_energy_made_mj", 3, |row| row.largest(|o| o.peer_energy_made_mj().unwrap_or(f64::NAN)))
        .means("peer: the most, at the end of any tick, that had left the ports of a peer's coordination beyond what had entered them, the largest of every run over every network")
        .head("peer made")
}

/// What a hand feels, and what it costs.
fn felt<'a>(rows: Rows<'a, Row>) -> Rows<'a, Row> {
    rows.number("apparent_mass_kg", 3, |row| row.touch.swing.map(|swing| swing.mass_kg))
        .means("mass that both hands feel when they move the object together once a second")
        .head("mass")
        .number("drag_n_s_per_m", 2, |row| row.touch.swing.map(|swing| swing.drag_n_s_per_m))
        .means("drag that they feel while they do")
        .head("drag")
        .number("z_width_db", 1, |row| row.touch.width_db())
        .means("impedance felt with the far hand holding its device over that with it off, mean from 0.5 to 2 Hz")
        .head("Z-width")
        .number("needed_damping_n_s_per_m", 2, |row| row.touch.needed_damping())
        .means("damping that the device lacks for what is felt to be passive from 0.5 to 50 Hz")
        .head("lacks")
        .number("packets_per_s", 0, |row| row.packets_per_s)
        .means("packets that a peer sends, on the scene's own network")
        .head("packets")
        .number("bytes_per_s", 0, |row| row.packets_per_s * PACKET_BYTES as f64)
        .means("the same in bytes, each a sealed flow under UDP and IPv4")
        .head("bytes")
        .value("instructions", |row| row.instructions)
        .means("instructions of a tick in f32 on a Cortex-M7 (`cargo xtask count`); none of a law that was not counted")
}

/// What the analyser says.
fn judged<'a>(rows: Rows<'a, Row>) -> Rows<'a, Row> {
    rows.number("stable_to_both_n_per_m", 0, |row| row.limit(|s| &s.coordination[0]))
        .means("first unstable K_T with both hands on; 20000 where there is none up to there")
        .head("K_T both")
        .number("stable_to_one_n_per_m", 0, |row| row.limit(|s| &s.coordination[1]))
        .means("the same with one hand on")
        .head("K_T one")
        .number("stable_to_none_n_per_m", 0, |row| row.limit(|s| &s.coordination[2]))
        .means("the same with no hand on")
        .head("K_T none")
        .number("contact_stable_to_n_per_m", 0, |row| row.limit(|s| &s.contact))
        .means("first unstable K_LC in the worst mode, at the law's K_T; 20000 where there is none up to there")
        .head("K_LC")
        .data("judged_stable", |row| row.stability.as_ref().ok().map(|stability| stability.judgement.worst.stable))
        .means("whether the analyser calls every mode stable at the gains as declared")
        .data("not_judged", |row| row.stability.as_ref().err().cloned())
        .means("why the analyser says nothing")
}

/// All of it, a row a law.
pub fn columns(rows: &[Row]) -> Columns {
    judged(felt(over_networks(named(rows)))).done()
}

/// The columns in three tables, so that each fits a page.
pub fn parts(rows: &[Row]) -> [Columns; 3] {
    [over_networks(named(rows)).done(), felt(named(rows)).done(), judged(named(rows)).done()]
}

/// A row a law and frequency.
pub fn impedance_columns(rows: &[Row]) -> Columns {
    let points: Vec<(&Row, &Point)> =
        rows.iter().flat_map(|row| row.touch.points.iter().map(move |point| (row, point))).collect();
    Columns::of(&points)
        .value("law", |(row, _)| row.law.name)
        .means("what coordination.comm calls it")
        .value("frequency_hz", |(_, point)| point.frequency_hz)
        .means("how often the hand goes to and fro")
        .value("held_n_s_per_m", |(_, point)| point.held.map(|z| z.norm()))
        .means("size of the felt impedance, the far hand holding its device")
        .value("held_phase_rad", |(_, point)| point.held.map(|z| z.arg()))
        .means("its phase: force before speed; beyond a quarter of a turn it is not passive")
        .value("let_go_n_s_per_m", |(_, point)| point.let_go.map(|z| z.norm()))
        .means("size of the felt impedance, the far hand off")
        .value("let_go_phase_rad", |(_, point)| point.let_go.map(|z| z.arg()))
        .means("its phase")
        .done()
}
