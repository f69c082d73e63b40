//! The bench's part of a page of the documentation, between two lines of the page.

use super::points::Point;
use super::protocol::BOUNDS_N_S_PER_M;
use super::{Bench, Found, tables};

/// Between these lines of the page stands what `cohold study bench --page` writes.
pub const BENCH: [&str; 2] = ["<!-- bench begin -->", "<!-- bench end -->"];

/// How the page calls its picture.
pub const PICTURE: &str = "laws-bench.png";

/// What the page says of a bench.
pub fn section(bench: &Bench, found: &Found) -> String {
    let fronts = tables::fronts(found);
    let [moved, felt] = tables::parts(found);
    let bounds = BOUNDS_N_S_PER_M.map(|bound| bound.to_string()).join(", ");
    let networks: Vec<&str> = bench.networks.iter().map(|network| network.name.as_str()).collect();
    let gains: String = found.best().filter(|point| point.name != "declared").map(line).collect();
    format!(
        "Written by `cohold study bench --budget {budget} --page docs/results/laws.md` by [the protocol](#how-is-the-bench-fair), in one scene.\n\
         Each law has {searches} searches of {budget} tunings. They use other networks than the test. The felt impedance |Z| at 1 Hz is bounded\n\
         by {bounds} N·s/m, and each bound gives one result. Test networks, with {seeds} seeds each: {networks}. {tunings} tunings, {runs} runs of\n\
         the test. [Columns](../reference/columns.md) explains the columns. `--out` writes every run and tuning.\n\n\
         `mm/N` is the true discrepancy over the contact force, under pushes against each other, on the **worst test network**. The first three\n\
         columns are for the gains that a law declares. The others are for the best gains that the searches found within each bound.\n\n\
         - `-`: no search found gains within the bound, or a run stopped.\n\
         - `from`, `to`: smallest and largest result of the searches. `to` is missing if a search found none, or found gains that stop.\n\
         - `stops`: runs of any motion in which a peer stopped.\n\n\
         ```text\n{fronts}```\n\n\
         <img src=\"{PICTURE}\" width=\"500\" alt=\"Fronts: true discrepancy of the worst network against what a hand feels, law by law\">\n\n\
         What happens at the hands, motion by motion? Forces are forces of the motor at the hand. Values are means of the worst network. Columns\n\
         with `peak`, `change` or `worst` have the largest value of any run.\n\n\
         - `against`: mm/N, and the largest instant in mm.\n\
         - `together`: distance moved by a common push of 1 s, in mm, and the largest force at a hand.\n\
         - `led`: position error under an arm that moves 200 mm at 0.7 Hz, the force at the hand, its largest change in a tick, and its error.\n\
         - `contact`: contact is made and lost. `let go`: a hand releases the object.\n\n\
         ```text\n{moved}```\n\n\
         Felt impedance, mass of the object, minimum energy balance of the link in J, and cost. A link may deliver its initial energy\n\
         (`coordination.tank_j`, `coordination.carry_energy_j`). `tuning` is the result of the search on its own networks.\n\n\
         ```text\n{felt}```\n\n\
         Gains that the searches chose:\n\n{gains}",
        budget = bench.budget,
        searches = bench.searches,
        seeds = bench.seeds,
        networks = networks.join("; "),
        runs = found.points.iter().map(|point| point.runs.len()).sum::<usize>(),
        tunings = found.tunings.len(),
    )
}

/// The gains of a point as a line of a list.
fn line(point: &Point) -> String {
    let name = if point.tuning.number == 0 { "its own".to_owned() } else { format!("`{}`", point.tuning.gains) };
    format!("- `{}` {}: {name}\n", point.law.name, point.name)
}
