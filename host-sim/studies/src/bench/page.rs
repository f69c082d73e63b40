//! The bench's part of docs/laws.md, which stands between two lines of its own; the rest of that page other commands write.

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
        "Written by `cohold study bench --budget {budget} --page docs/laws.md` by [the protocol](bench.md), with one scene. Every law has {searches} searches of {budget} tunings, on networks\n\
         apart from those of the test. What a hand alone feels is bounded by {bounds} N·s/m (|Z| at 1 Hz); each bound is a point of a law's front. Test networks, {seeds} seeds each:\n\
         {networks}. {tunings} tunings, {runs} runs of the test. [What the columns mean](data.md#the-bench); every run and tuning is in the files (`--out`).\n\n\
         *mm/N* is the true discrepancy over the force of contact, under pushes against each other, on the **worst test network**. First it is given at the gains that a law\n\
         declares, with what a hand then feels. Then it is given at the best gains that the searches found within each bound.\n\n\
         - `-`: no search found gains within the bound, or a run stopped.\n- *from*, *to*: the least and the most over the searches' own best gains. There is no *to* where a search found none, or such that stop.\n- *stops*: runs of any motion in which a peer stopped.\n\n\
         ```text\n{fronts}```\n\n\
         <img src=\"{PICTURE}\" width=\"500\" alt=\"Fronts: true discrepancy of the worst network against what a hand feels, law by law\">\n\n\
         What the hands meet, motion by motion. A force is that of the motor at the hand; means of the worst network, the largest of any run where it says peak, change or worst.\n\n\
         - *against*: mm/N, and the largest instant in mm.\n- *together*: the way of a common push of 1 s in mm (not normalised), and the largest force at a hand.\n\
         - *led*: by an arm over 200 mm at 0.7 Hz: the distance in mm, the force at the hand, its largest change in a tick, and its error.\n- *contact* is made and lost; a hand is *let go*.\n\n\
         ```text\n{moved}```\n\n\
         What a hand feels, the mass of the object, the least balance of energy of the link in J (what it began with, E₀, may be given back: `coordination.tank_j`,\n\
         `coordination.carry_energy_j`), and what it costs. *tuning*: what the search saw on its own networks.\n\n\
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
