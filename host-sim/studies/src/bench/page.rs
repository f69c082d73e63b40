//! The bench's tables in a page of the documentation, each between two lines of the page.

use cohold_report::Columns;

use super::points::Point;
use super::{Bench, Found, tables};

/// Between these lines is what `cohold study bench --page` writes: what was asked, the fronts, what happens at the hands, what a hand feels,
/// and the gains.
pub const BENCH: [[&str; 2]; 5] = [
    ["<!-- bench asked begin -->", "<!-- bench asked end -->"],
    ["<!-- bench fronts begin -->", "<!-- bench fronts end -->"],
    ["<!-- bench motions begin -->", "<!-- bench motions end -->"],
    ["<!-- bench felt begin -->", "<!-- bench felt end -->"],
    ["<!-- bench gains begin -->", "<!-- bench gains end -->"],
];

/// How the page calls its picture.
pub const PICTURE: &str = "laws-bench.png";

/// Texts between the lines of [`BENCH`].
pub fn sections(bench: &Bench, found: &Found) -> Vec<([&'static str; 2], String)> {
    let networks: Vec<&str> = bench.networks.iter().map(|network| network.name.as_str()).collect();
    let asked = format!(
        "`--searches {} --budget {} --seeds {}`: {} tunings, {} runs of the test. Its networks are {}.",
        bench.searches,
        bench.budget,
        bench.seeds,
        found.tunings.len(),
        found.points.iter().map(|point| point.runs.len()).sum::<usize>(),
        networks.join("; ")
    );
    let gains = found.best().filter(|point| point.name != "declared").map(line).collect();
    let text = |table: Columns| format!("```text\n{table}```");
    let [moved, felt] = tables::parts(found).map(text);
    BENCH.into_iter().zip([asked, text(tables::fronts(found)), moved, felt, gains]).collect()
}

/// The gains of a point as a line of a list.
fn line(point: &Point) -> String {
    let name = if point.tuning.number == 0 { "its own".to_owned() } else { format!("`{}`", point.tuning.gains) };
    format!("- `{}` {}: {name}\n", point.law.name, point.name)
}
