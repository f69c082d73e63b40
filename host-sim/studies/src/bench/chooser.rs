//! Which law is nearest, for how much of what a hand feels: of all laws, and of those that promise passivity.

use cohold_core::settings::Promise;
use cohold_report::Columns;

use super::Found;
use super::motions::Motion;
use super::points::Point;
use super::protocol::BOUNDS_N_S_PER_M;
use super::search::point_name;

/// Between these lines of a page stands what [`section`] says.
pub const CHOOSER: [&str; 2] = ["<!-- chooser begin -->", "<!-- chooser end -->"];

/// What is compared: a column's name and unit, what it heads, and the figure of a point.
type Compared = (&'static str, &'static str, &'static str, fn(&Point) -> Option<f64>);

const COMPARED: [Compared; 2] = [
    ("pushed", "mm_per_n", "under pushes", Point::worst_mm_per_n),
    ("led", "mm", "where led", |point| point.worst_network(Motion::Led, |run| run.true_mm).map(|(_, mean)| mean)),
];

/// A row a bound of what a hand feels, for all laws and for those that promise passivity.
pub fn nearest(found: &Found) -> Columns {
    let rows = BOUNDS_N_S_PER_M.map(|bound| [(bound, false), (bound, true)]);
    let mut columns = Columns::of(rows.as_flattened())
        .number("felt_at_most_n_s_per_m", 0, |row| row.0)
        .means("bound of |Z| that a hand alone feels at 0.2 and 1 Hz")
        .head("felt up to")
        .value("laws", |row| if row.1 { "that promise passivity" } else { "all" })
        .means("which laws are asked");
    for (name, unit, head, figure) in COMPARED {
        let best = move |(bound, passive): &(f64, bool)| {
            let may = found.best().filter(|point| point.name == point_name(*bound) && point.stopped() == 0);
            let may = may.filter(|point| !passive || point.law.promises.contains(&Promise::Passive));
            may.filter_map(|point| Some((point, figure(point)?))).min_by(|one, other| one.1.total_cmp(&other.1))
        };
        let spread = move |row: &(f64, bool)| best(row).map_or([None; 2], |(point, _)| found.spread(point, figure));
        columns = columns
            .value(format!("{name}_law"), move |row| best(row).map(|(point, _)| point.law.name))
            .means("whose copies are nearest on the worst test network: pushed against each other, or where an arm leads a hand, at gains that were sought under pushes")
            .head(head)
            .significant(format!("{name}_{unit}"), 2, move |row| best(row).map(|(_, figure)| figure))
            .means("distance of its copies; under pushes over the force of contact")
            .head("true")
            .significant(format!("{name}_least_{unit}"), 2, move |row| spread(row)[0])
            .means("the least that any search came to")
            .head("from")
            .significant(format!("{name}_most_{unit}"), 2, move |row| spread(row)[1])
            .means("the most; none where a search found no gains, or such that stop")
            .head("to");
    }
    columns.done()
}

/// What a page says of it.
pub fn section(found: &Found) -> String {
    format!("```text\n{}```", nearest(found))
}
