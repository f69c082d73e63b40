//! Which laws keep their forces within the limits, for every number: [`cohold_proof`], law by law.

use cohold_core::law::Law;
use cohold_core::settings::Settings;
use cohold_proof::{Proved, Whatever, prove_named};
use cohold_report::Columns;
use cohold_sim::Laws;

/// A law, and what was proved of it.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name; of the law that says anything, words.
    pub law: &'static str,
    /// The result of the proof.
    pub proved: Proved,
}

/// The proof of a law that core does not have, by its name.
pub type Prover = fn(&str) -> Option<(&'static str, Proved)>;

/// What the program's own laws are called, and after them the one that says anything.
pub fn names(laws: Laws) -> Vec<&'static str> {
    let outside: Vec<&str> = laws.outside().collect();
    laws.all().iter().chain(Whatever::LAWS).map(|law| law.name).filter(|name| !outside.contains(name)).collect()
}

/// The law of that name, of core's or of these.
pub fn row(name: &str, others: Prover) -> Option<Row> {
    prove_named(name).or_else(|| others(name)).map(|(law, proved)| Row { law, proved })
}

/// Declares the columns of the rows.
pub fn columns(rows: &[Row]) -> Columns {
    Columns::of(rows)
        .value("law", |row| row.law)
        .means("coordination law")
        .value("box", |_| "every number")
        .means("what readings, counts, packets and state were: any finite packet, any bits of everything else")
        .value("scenes", |row| row.proved.scenes as u64)
        .means("scenes: the law's gains and every choice of settings")
        .value("states", |row| row.proved.states as u64)
        .means("states of whole numbers that a tick began in")
        .value("paths", |row| row.proved.paths as u64)
        .means("ways through a tick")
        .number("widest_force_n", 3, |row| row.proved.widest_n)
        .head("widest force")
        .means("largest force that any path gives")
        .number("widest_step_n", 3, |row| row.proved.widest_step_n)
        .head("change a tick")
        .means("largest change of force in a tick that any path gives")
        .value("verdict", |row| match &row.proved.broken {
            None => "holds".to_owned(),
            Some((scene, broken)) if scene.is_empty() => broken.to_string(),
            Some((scene, broken)) => format!("{broken} ({scene})"),
        })
        .means("whether forces stay within their limits, and if not, what was found, and where")
        .done()
}

/// What was proved, and of which laws.
pub fn report(table: &Columns) -> String {
    let safety = Settings::default().safety;
    format!(
        "Every way through a tick, from any state, with any reading and any finite packet: forces stay within {} N and grow by no\n\
         more than {} N in a tick of 1 ms (and its rounding), or are off; duties stay within motor.max_duty; what is sent is finite\n\n\
         {table}\n\
         (any law): what the law does not matter, for it gives any number, infinite or none, in each tick.",
        safety.max_force_n,
        1e-3 * safety.max_slew_n_per_s
    )
}

/// The proofs as a section of docs/results/laws.md.
pub fn section(report: &str) -> String {
    format!(
        "`cohold stability prove --page docs/results/laws.md` writes this table, and each test run proves it again:\n\n\
         ```text\n{report}\n```"
    )
}

#[cfg(test)]
#[path = "../tests/inside/proof.rs"]
mod tests;
