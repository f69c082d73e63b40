//! A live peer as its faces hold it, the command `peer` and the Python module: judged at the delays that its link measures, and limited
//! for the hand at its device. The peer itself is [`cohold_live::peer`].

use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;

use cohold_analysis::{Finding, Hand, Question, find, measured};
use cohold_live::endpoint::{Span, Stop};
use cohold_live::key_file;
use cohold_live::peer::{self, Report};
use cohold_live::verdict::{Judge, Measured, Verdict};
use cohold_live::watch::LiveOptions;
use cohold_protocol::key::{Key, Role};
use cohold_report::Provenance;
use cohold_sim::scene::{Device, PlantSettings, Scene};

pub use crate::device_options;

/// What a peer with a device in a person's hand is limited to where its scene does not say otherwise.
pub const OF_A_HAND: [(&str, f64); 5] = [
    ("safety.max_force_n", 3.0),
    ("safety.max_slew_n_per_s", 60.0),
    ("safety.max_rms_power_w", 5.0),
    ("safety.max_hand_power_w", 5.0),
    ("safety.max_speed_m_per_s", 0.5),
];

/// Packets in flight that are still judged of a peer's scene; a verdict on more takes seconds, and arming waits for it.
const MOST_PACKETS: usize = 40;

/// One end of a line, and who is at the other.
#[derive(Clone)]
pub struct LivePeer {
    /// What both are told.
    pub scene: Scene,
    /// Which of the two: 1 (left) or 2 (right).
    pub number: u8,
    /// The same at both ends.
    pub key: Key,
    /// Where it listens, and where the other end, or the place where they meet, does.
    pub ends: [SocketAddr; 2],
    /// How long.
    pub span: Span,
    /// To arm also where the scene is unstable, and how that is said; without it a peer waits for a better network.
    pub anyway: Result<(), &'static str>,
}

impl LivePeer {
    /// The key in this file, which two peers share.
    ///
    /// # Errors
    /// It cannot be read, may be read by others, or is no such key.
    pub fn key(file: &Path) -> Result<Key, cohold_sim::Error> {
        key_file::read(file, Role::Peers)
    }

    /// Makes a new key file for two peers; an existing file is left alone.
    ///
    /// # Errors
    /// The file exists or cannot be written, or the system gives no random bytes.
    pub fn generate_key(file: &Path) -> Result<(), cohold_sim::Error> {
        key_file::generate(file, Role::Peers)
    }

    /// Runs it to its end, or until it is stopped.
    ///
    /// # Errors
    /// It did not begin, or nobody was there.
    pub fn run(self, wanted: LiveOptions, stop: &Stop) -> Result<Report, cohold_live::Error> {
        let Self { scene, number, key, ends, span, anyway } = self;
        let judge = Some(judge(scene.clone(), number, None, anyway));
        peer::run(&scene, key, number, ends, span, &LiveOptions { judge, ..wanted }, stop)
    }

    /// What made its recording, by this program.
    pub fn provenance(&self, program: Provenance) -> Provenance {
        program.settings(self.scene.settings()).with("peer", self.number)
    }
}

/// What a verdict leaves out of a device that the scene does not simulate.
const DEVICE_S_OWN: &str = "a delay of the device itself that changes from tick to tick";
/// And of one that is later than any in a scene.
const LATER: &str = "what the device is late by beyond 20 ticks";

/// This scene where the device of peer `number` acts so many ticks after it was read, or as many as a scene has. Its motors are its own: what the
/// scene simulates of motors leaves their delay to the other end's device.
fn with_device(mut scene: Scene, number: u8, ticks: u32) -> Result<Scene, cohold_sim::Error> {
    scene.world.device.force_delay_ticks = scene.force_delay_ticks();
    scene.world.plant = PlantSettings::default();
    let ticks = f64::from(ticks).min(Device::MOST_DELAY_TICKS);
    scene.set_number(&format!("peer.{number}.device.force_delay_ticks"), ticks)?;
    Ok(scene)
}

/// Who judges this scene at measured delays, of the network and of a device at peer `number` that the scene does not simulate, with a hand that
/// may take either device if there is one, and lets it arm anyway or not.
pub fn judge(scene: Scene, number: u8, hand: Option<Hand>, anyway: Result<(), &'static str>) -> Judge {
    let question = Question { hand, most_packets: MOST_PACKETS };
    let find = move |Measured { one_way_s, device_ticks }: Measured| {
        let scene = measured(&scene, one_way_s);
        let found = match device_ticks.map(|ticks| with_device(scene.clone(), number, ticks)) {
            None => find(&scene, question),
            Some(Ok(scene)) => find(&scene, question),
            Some(Err(why)) => Finding { text: format!("not judged: {why}"), ..Finding::default() },
        };
        let Finding { stable, spectral_radius, text, instead, mut not_judged } = found;
        not_judged.extend(device_ticks.map(|_| DEVICE_S_OWN));
        not_judged.extend(device_ticks.filter(|ticks| f64::from(*ticks) > Device::MOST_DELAY_TICKS).map(|_| LATER));
        Verdict {
            one_way_ms: one_way_s.map(|s| 1e3 * s),
            device_delay_ticks: device_ticks,
            stable,
            spectral_radius,
            text,
            instead,
            not_judged,
        }
    };
    Judge { find: Arc::new(find), unless: anyway.err() }
}

#[cfg(test)]
#[path = "../tests/inside/live_peer.rs"]
mod tests;
