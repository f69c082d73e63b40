//! The bench: laws beside each other, every one in the same scene, at the gains that it declares.
//!
//! All that a row says comes from the law's [`LawInfo`] and from what is measured: whoever adds a law, to core's list or in a crate
//! outside, has a row here.
//!
//! | module | what of a law |
//! |---|---|
//! | `campaign::cells` | runs over every network: discrepancy, forces, mobility, energies |
//! | [`stability`] | largest K_T and K_LC in every mode, by the analyser |
//! | [`touch`] | what the hand feels: impedance, Z-width, mass, drag |
//! | [`promises`] | what it promises, and whether that was kept here |
//! | [`tables`], [`figures`], [`page`] | how it is shown |
//!
//! **Fair** means: one scene for all, that of the campaign (the users of the paper's §5.2, packets of 8 ms, 8 ms one way, m_O = 0.3 kg, K_LC = 1000 N/m), with
//! peers that solve each tick at once, one [`LADDER`], and for each law the gains that its author declares for trying it. Gains are not tuned here: a
//! stiffer law has the smaller discrepancy and, as a rule, the smaller region; both stand in the row.

pub mod figures;
pub mod page;
pub mod promises;
pub mod stability;
pub mod tables;
pub mod touch;

use std::path::Path;

use cohold_core::settings::LawInfo;
use cohold_protocol::wire::packet_bytes;
use cohold_sim::pair::Pair;
use cohold_sim::peers::Laws;
use cohold_sim::scene::{Scene, law_meant};
use cohold_sim::scenes;
use cohold_sim::user::User;

use self::promises::Kept;
use self::stability::Stability;
use self::touch::Touch;
use super::{BASE, Cell, over_networks};
use crate::Error;
use crate::accuracy::counts::Processor;
use crate::entrant::Entrant;
use crate::networks::{self, Named};

/// Peers that break nothing by themselves: one solve a tick, so that what a copy does is the law's and the network's doing.
pub const SOLVED: [&str; 3] =
    ["coordination.decode=implicit", "object.integrator=midpoint", "object.force_delay_ticks=0"];

/// When a peer lets go of the other one in silence, the same for all, whatever a law declares: what is compared is what laws do in a silence, not a timer that ends them.
/// Long enough for every network here.
pub const LADDER: [&str; 2] = ["safety.fade_s=5", "safety.disengage_s=8"];

/// The laws that are asked for: `all`, or their names with commas between.
///
/// # Errors
/// A name that no law has.
pub fn asked_for(laws: Laws, text: &str) -> Result<Vec<&'static LawInfo>, Error> {
    let infos = laws.all();
    if text == "all" {
        return Ok(infos.iter().collect());
    }
    let mut found: Vec<&LawInfo> = Vec::new();
    for name in text.split(',').map(str::trim) {
        let Some(law) = infos.iter().find(|law| law.name == name) else {
            let names = || infos.iter().map(|law| law.name).chain(["all"]).collect::<Vec<_>>().join(", ");
            let hint = law_meant(name, infos).unwrap_or_else(|| format!("the laws are {}", names()));
            return Err(format!("there is no law called {name:?}; {hint}").into());
        };
        if !found.contains(&law) {
            found.push(law);
        }
    }
    Ok(found)
}

/// The scene in which a law is tried: this one, or that of the campaign with peers that solve each tick at once and let go as late as all; between them
/// the gains that the law declares, and at last these settings.
///
/// # Errors
/// What the scene or the law does not accept.
pub fn law_scene(laws: Laws, law: &LawInfo, scene: Option<&Path>, set: &[String]) -> Result<Scene, Error> {
    let campaign = |settings: &'static [&'static str]| settings.iter().filter(|_| scene.is_none());
    let settings = campaign(&SOLVED).chain(law.gains).chain(campaign(&LADDER)).map(|setting| (*setting).to_owned());
    let law = format!("coordination.comm={}", law.name);
    let settings: Vec<String> = std::iter::once(law).chain(settings).chain(set.iter().cloned()).collect();
    Ok(scenes::find(laws, Some(scene.unwrap_or(Path::new(BASE))), &settings)?)
}

/// The scene of each of these laws ([`law_scene`]); users who do nothing are those of the campaign.
///
/// # Errors
/// As [`law_scene`]; the law is named.
pub fn law_scenes(laws: Laws, infos: &[&LawInfo], scene: Option<&Path>, set: &[String]) -> Result<Vec<Scene>, Error> {
    let scene = |law: &&LawInfo| {
        let mut found = law_scene(laws, law, scene, set).map_err(|error| format!("{}: {error}", law.name))?;
        if !found.users.iter().any(User::acts) {
            found.users = scenes::load(laws, BASE)?.users;
        }
        Ok(found)
    };
    infos.iter().map(scene).collect()
}

/// A law on the bench.
#[derive(Clone, Debug)]
pub struct Row {
    /// The law that was tried.
    pub law: &'static LawInfo,
    /// The scene it was tried in.
    pub scene: Scene,
    /// Results, network by network.
    pub cells: Vec<Cell>,
    /// What the analyser says, or why it says nothing.
    pub stability: Result<Stability, String>,
    /// What the hand feels.
    pub touch: Touch,
    /// The law's promises, and whether they were kept.
    pub promises: Vec<Kept>,
    /// Packets that a peer sends, /s, on the scene's own network.
    pub packets_per_s: f64,
    /// Instructions of a tick in f32 on a Cortex-M7, if it was counted.
    pub instructions: Option<u64>,
}

impl Row {
    /// The runs on the scene's own network.
    pub fn own(&self) -> &Cell {
        &self.cells[0]
    }
}

/// Puts laws on the bench, each in its scene; `done` is called once for each.
///
/// # Errors
/// Settings that no peer accepts on one of the networks.
pub fn bench(laws: Laws, scenes: &[Scene], done: &dyn Fn()) -> Result<Vec<Row>, Error> {
    over(laws, scenes, networks::IMPAIRMENTS, done)
}

/// [`bench`] over these networks; the first is the scene's own.
fn over(laws: Laws, scenes: &[Scene], networks: &[Named], done: &dyn Fn()) -> Result<Vec<Row>, Error> {
    let row = |scene: &Scene| {
        let law = laws.all().iter().find(|law| law.name == scene.law().name).unwrap_or(scene.law());
        let cells = over_networks(vec![Entrant { name: law.name.to_owned(), scene: scene.clone() }], networks, 0)?;
        let stable = cells[0].is_stable();
        let (stability, touch) = rayon::join(
            || stability::judged(scene, stable).map_err(|why| why.to_string()),
            || touch::felt(scene, stable),
        );
        let row = Row {
            law,
            scene: scene.clone(),
            stability,
            touch: touch?,
            promises: promises::kept(scene, &cells, networks)?,
            packets_per_s: packets_per_s(scene)?,
            instructions: Processor::CortexM7.count(&format!("law/{}", law.name), "f32"),
            cells,
        };
        done();
        Ok(row)
    };
    scenes.iter().map(row).collect()
}

/// Simulated time over which packets are counted, s.
const COUNTED_S: f64 = 10.0;

/// Packets that a peer sends on the scene's own network, mean of both, /s.
fn packets_per_s(scene: &Scene) -> Result<f64, Error> {
    let mut pair = Pair::<f64>::new(scene)?;
    let ticks = (COUNTED_S / scene.peer.timing.control_period_s).round() as u64;
    (0..ticks).for_each(|_| pair.step());
    let sent: u64 = pair.sides().iter().map(|side| side.sent).sum();
    Ok(sent as f64 / 2.0 / COUNTED_S)
}

/// Bytes of a packet on the wire.
pub const PACKET_BYTES: usize = packet_bytes(1);

#[cfg(test)]
#[path = "../../../tests/inside/laws.rs"]
mod tests;
