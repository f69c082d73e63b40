//! Which laws keep their forces within the limits, for every number: [`haptic_proof`], law by law.

use haptic_core::law::{AnyLaw, Law};
use haptic_core::peer::Peer;
use haptic_proof::{Number, Proved, Whatever, prove};
use haptic_sim::report::Columns;

/// One law.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name; of the law that says anything, words.
    pub law: &'static str,
    /// What came of it.
    pub proved: Proved,
}

/// What the laws of core are called, and after them the one that says anything.
pub fn names() -> Vec<&'static str> {
    AnyLaw::<Number>::KINDS.iter().chain(Whatever::KINDS).map(|kind| kind.name).collect()
}

/// The law of that name.
pub fn row(name: &str) -> Option<Row> {
    let named = |kinds: &'static [haptic_core::law::Kind]| kinds.iter().find(|kind| kind.name == name);
    let proved = match named(AnyLaw::<Number>::KINDS) {
        Some(kind) => (kind.name, prove::<AnyLaw<Number>>(kind, Peer::tick)),
        None => named(Whatever::KINDS).map(|kind| (kind.name, prove::<Whatever>(kind, Peer::tick)))?,
    };
    Some(Row { law: proved.0, proved: proved.1 })
}

/// Declares the table.
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
