//! The bench as tables: fronts with a row a law, a row for the gains of a law, every tuning, every run.

use cohold_report::Columns;

use super::Found;
use super::motions::Motion;
use super::points::Point;
use super::protocol::BOUNDS_N_S_PER_M;
use super::runs::Run;
use super::search::{Tuning, point_name};
use crate::sweep::{EVERY_MODE, UNSTABLE_MODES, known, said};

/// A row a law: the worst network's distance at the law's own gains and at the best within each bound.
pub fn fronts(found: &Found) -> Columns {
    let declared: Vec<&Point> = found.best().filter(|point| point.name == "declared").collect();
    let mut columns = Columns::of(&declared)
        .value("law", |own| own.law.name)
        .means("what coordination.comm calls it")
        .significant("declared_felt_n_s_per_m", 3, |own| known(own.tuning.felt_n_s_per_m[1]))
        .means("|Z| that a hand alone feels at 1 Hz at the gains that the law declares")
        .head("declared: felt")
        .significant("declared_mm_per_n", 3, |own| own.worst_mm_per_n())
        .means(
            "distance of the copies over the force of contact at these, worst test network; none where a run stopped",
        )
        .head("true");
    for bound in BOUNDS_N_S_PER_M {
        let point = move |own: &&Point| {
            found.best().find(|point| point.law.name == own.law.name && point.name == point_name(bound))
        };
        let spread = move |own: &&Point| point(own).map_or([None; 2], |best| found.spread(best, Point::worst_mm_per_n));
        columns = columns
            .significant(format!("within_{bound}_mm_per_n"), 3, move |own| point(own)?.worst_mm_per_n())
            .means(&format!("the same at the best gains of all searches of which a hand feels at most {bound} N·s/m; none where there are none, or a run stopped"))
            .head(&point_name(bound))
            .significant(format!("within_{bound}_least_mm_per_n"), 3, move |own| spread(own)[0])
            .means("the least that any search came to")
            .head("from")
            .significant(format!("within_{bound}_most_mm_per_n"), 3, move |own| spread(own)[1])
            .means("the most; none where a search found no gains, or such that stop")
            .head("to")
            .value(format!("within_{bound}_stopped"), move |own| point(own).map(Point::stopped))
            .means("runs of any motion in which a peer stopped at these, or what it did grew")
            .head("stops");
    }
    columns.done()
}

/// A row for the gains of a law.
pub fn points(points: &[Point]) -> Columns {
    felt(moved(named_points(points))).done()
}

/// The same in two tables, so that each fits a page, of the best gains alone.
pub fn parts(found: &Found) -> [Columns; 2] {
    let best: Vec<Point> = found.best().cloned().collect();
    [moved(named_points(&best)).done(), felt(named_points(&best)).done()]
}

type Rows<'a> = cohold_report::Rows<'a, Point>;

fn named_points(points: &[Point]) -> Rows<'_> {
    Columns::of(points)
        .value("law", |point| point.law.name)
        .means("what coordination.comm calls it")
        .value("gains", |point| point.name.as_str())
        .means("declared, or the most that a hand feels of the best within it, N·s/m")
        .data("search_seed", |point| point.tuning.search_seed)
        .means("seed of the search that found them")
}

/// What came of the motions.
fn moved(rows: Rows<'_>) -> Rows<'_> {
    use Motion::{Against, Contact, Led, LetGo, Together};
    let mean = |point: &Point, motion, of: fn(&Run) -> f64| point.worst_network(motion, of).map(|(_, mean)| mean);
    rows.data("runs", |point| point.runs.len())
        .means("runs of all motions over all test networks")
        .value("stopped", Point::stopped)
        .means("those in which a peer stopped, or what it did grew")
        .head("stops")
        .data("reason", Point::reason)
        .means("why the first of them did")
        .significant("against_mm_per_n", 3, Point::worst_mm_per_n)
        .means("pushes against each other: distance of the copies over the force of contact, worst network")
        .head("against")
        .data("against_network", |point| {
            point.worst_network(Against, |run| run.mm_per_n).map(|(name, _)| name.to_owned())
        })
        .means("which network that is")
        .number("against_worst_mm", 1, |point| point.most(Against, |run| run.worst_true_mm))
        .means("the largest distance at any instant of any run")
        .head("worst")
        .number("together_way_mm", 0, |point| point.least(Together, |run| run.way_mm))
        .means("a common push of 1 s: how far the object goes, worst network, mean over the seeds")
        .head("together: way")
        .number("together_peak_n", 1, |point| point.most(Together, |run| run.hand_peak_n))
        .means("largest force at a hand meanwhile")
        .head("peak")
        .number("led_mm", 1, move |point| mean(point, Led, |run| run.true_mm))
        .means("a hand that is led: distance of the copies, worst network")
        .head("led: true")
        .number("led_peak_n", 1, |point| point.most(Led, |run| run.hand_peak_n))
        .means("largest force at a hand meanwhile")
        .head("peak")
        .number("led_change_n", 2, |point| point.most(Led, |run| run.hand_change_n))
        .means("its largest change in a tick")
        .head("change")
        .number("led_error_n", 2, move |point| mean(point, Led, |run| run.hand_error_n))
        .means("root mean square of the force at a hand less the same without a network, worst network")
        .head("error")
        .number("contact_mm", 1, move |point| mean(point, Contact, |run| run.true_mm))
        .means("contact that is made and lost: distance of the copies, worst network")
        .head("contact: true")
        .number("contact_change_n", 2, |point| point.most(Contact, |run| run.hand_change_n))
        .means("largest change of the force at a hand in a tick meanwhile")
        .head("change")
        .number("let_go_worst_mm", 1, |point| point.most(LetGo, |run| run.worst_true_mm))
        .means("a hand that lets go: largest distance of the copies at any instant of any run")
        .head("let go: worst")
}

/// What a hand feels, what energy was made, and what it costs.
fn felt(rows: Rows<'_>) -> Rows<'_> {
    let felt = |at: usize| move |point: &Point| known(point.tuning.felt_n_s_per_m[at]);
    rows.significant("felt_slow_n_s_per_m", 3, felt(0))
        .means("|Z| that a hand alone feels at 0.2 Hz; none where it felt too much at 1 Hz already")
        .head("felt 0.2 Hz")
        .significant("felt_n_s_per_m", 3, felt(1))
        .means("the same at 1 Hz")
        .head("1 Hz")
        .significant("felt_fast_n_s_per_m", 3, felt(2))
        .means("the same at 5 Hz")
        .head("5 Hz")
        .number("mass_kg", 2, |point| known(point.tuning.mass_kg))
        .means("mass of the object as felt at 1 Hz; what pulls it back shows as less, below 0 as a spring")
        .significant("least_balance_j", 2, Point::least_balance_j)
        .means("least of what the copies had put into the link less what they had got from it, over all instants of all runs; passive is down to less what it began with")
        .head("balance")
        .number("packets_per_s", 0, |point| point.mean(|run| run.packets_per_s))
        .means("packets that a peer sent, mean of all runs")
        .head("packets")
        .number("bytes_per_s", 0, |point| point.mean(|run| run.bytes_per_s))
        .means("the same in bytes, each a sealed flow under UDP and IPv4")
        .head("bytes")
        .value("instructions", Point::instructions)
        .means("instructions of a tick in f32 on a Cortex-M7 (`cargo xtask count`); none of a law that was not counted")
        .significant("tuned_mm_per_n", 3, |point| known(point.tuning.worst_mm_per_n))
        .means("worst tuning network's distance over the force of contact, as the search found it")
        .head("tuning: true")
        .data("settings", |point| point.tuning.gains.as_str())
        .means("the gains as settings; none are the law's own")
}

/// Every tuning of every law.
pub fn tunings(tunings: &[Tuning]) -> Columns {
    let felt = |at: usize| move |tuning: &Tuning| known(tuning.felt_n_s_per_m[at]);
    Columns::of(tunings)
        .value("law", |tuning| tuning.law.as_str())
        .means("name of the law")
        .value("search_seed", |tuning| tuning.search_seed)
        .means("seed of the search")
        .value("number", |tuning| tuning.number)
        .means("number of the tuning in its search, from 0, the law's own gains")
        .value("gains", |tuning| tuning.gains.as_str())
        .means("the gains as settings, with blanks between; none are the law's own")
        .value("felt_slow_n_s_per_m", felt(0))
        .means("|Z| that a hand alone feels at 0.2 Hz; none where it was not measured")
        .value("felt_n_s_per_m", felt(1))
        .means("the same at 1 Hz")
        .value("felt_fast_n_s_per_m", felt(2))
        .means("the same at 5 Hz")
        .value("mass_kg", |tuning| known(tuning.mass_kg))
        .means("mass of the object as felt at 1 Hz; what pulls it back shows as less, below 0 as a spring")
        .value("worst_mm_per_n", |tuning| known(tuning.worst_mm_per_n))
        .means(
            "worst tuning network's distance of the copies over the force of contact; none where it was not measured",
        )
        .value("reason", |tuning| said(&tuning.reason))
        .means("why it is not admitted")
        .done()
}

/// Every run of the test.
pub fn runs<'a>(runs: &'a [&'a Run]) -> Columns {
    let figure = |of: fn(&Run) -> f64| move |run: &&Run| known(of(run));
    Columns::of(runs)
        .value("law", |run| run.law.as_str())
        .means("name of the law")
        .value("gains", |run| run.point.as_str())
        .means("declared, or the most that a hand feels of the best within it, N·s/m")
        .value("search_seed", |run| run.search_seed)
        .means("seed of the search that found them")
        .value("motion", |run| run.motion.as_str())
        .means("what the hands do: against, together, led, contact, let go")
        .value("network", |run| run.network.as_str())
        .means("name of the network")
        .value("seed", |run| run.seed)
        .means("network.seed of the run")
        .value("every_mode_stable", |run| run.every_mode_stable)
        .means(EVERY_MODE)
        .value("unstable_modes", |run| said(&run.unstable_modes))
        .means(UNSTABLE_MODES)
        .value("stopped", |run| run.stopped)
        .means("whether a peer stopped, or, under pushes against each other, what the run did grew until its end")
        .value("reason", |run| said(&run.reason))
        .means("why, or why the copies came apart under pushes against each other")
        .significant("true_discrepancy_mm", 4, figure(|run| run.true_mm))
        .means("mean of |x_o1 - x_o2| over the last half; none of a run that stopped")
        .significant("largest_true_discrepancy_mm", 4, figure(|run| run.worst_true_mm))
        .means("the largest of the whole run, or until it stopped")
        .significant("true_discrepancy_mm_per_n", 4, figure(|run| run.mm_per_n))
        .means("that mean over the mean force of contact")
        .significant("hand_peak_n", 4, figure(|run| run.hand_peak_n))
        .means("largest force at either hand")
        .significant("hand_change_n", 4, figure(|run| run.hand_change_n))
        .means("its largest change in a tick")
        .significant("hand_error_n", 4, figure(|run| run.hand_error_n))
        .means("root mean square of the force at a hand less the same without a network")
        .significant("way_mm", 4, figure(|run| run.way_mm))
        .means("where both copies are in the end, their mean")
        .significant("least_balance_j", 4, figure(|run| run.least_balance_j))
        .means("least of what the copies had put into the link less what they had got from it, at any instant")
        .significant("packets_per_s", 4, figure(|run| run.packets_per_s))
        .means("packets that a peer sent, mean of both")
        .significant("wire_bytes_per_s", 4, figure(|run| run.bytes_per_s))
        .means("the same in bytes, sealed, with UDP and IP version 4")
        .done()
}
