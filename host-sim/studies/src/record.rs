//! Records what one peer of a scene reads, for [`cohold_cases::replay`] on another processor, and the hash of what it computes.

use cohold_board_tools::calibrate::settings_file::plain;
use cohold_cases::replay::{EXACT, EXCHANGE, PACKET, SEED, fold};
use cohold_core::device::Reading;
use cohold_core::settings::{Key, Settings};
use cohold_sim::pair::{Pair, PeerTick};
use cohold_sim::scene::Scene;

use crate::Error;

/// The recording and what it must come to.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Bytes of the file.
    pub bytes: Vec<u8>,
    /// Number of ticks in the file.
    pub ticks: u64,
    /// Hash of what the peer computed in the scene, with its device and the other peer around it.
    pub hash: u64,
}

/// The settings that differ from the defaults, a line each.
fn lines(settings: &Settings) -> String {
    let defaults = Settings::default();
    let changed = Settings::keys().filter(|key| settings.get(key.name) != defaults.get(key.name));
    let line = |key: Key| settings.get(key.name).map(|value| format!("{}={}\n", key.name, plain(value)));
    changed.filter_map(line).collect()
}

/// Peer `number` (1 or 2) of a scene in f32 for so many ticks.
///
/// # Errors
/// A scene that cannot be built.
pub fn record(scene: &Scene, number: usize, ticks: u64) -> Result<Recording, Error> {
    if scene.world.network.clock_drift_ppm != 0.0 {
        return Err("network.clock_drift_ppm must be 0: a recording has one tick a control period".into());
    }
    let mut pair = Pair::<f32>::new(scene)?;
    let settings = scene.peers()[number - 1];
    let text = lines(&settings);
    let mut bytes = (text.len() as u32).to_le_bytes().to_vec();
    bytes.extend(text.as_bytes());
    for axis in pair.sides()[number - 1].plant.motions() {
        bytes.extend((axis.position as f32).to_le_bytes());
    }
    let mut hash = SEED;
    for _ in 0..ticks {
        pair.step_watched(&mut |seen| {
            if seen.number == number {
                put(&mut bytes, &seen);
                fold(&mut hash, seen.peer, seen.actuators);
            }
        });
    }
    Ok(Recording { bytes, ticks, hash })
}

fn put(bytes: &mut Vec<u8>, seen: &PeerTick<'_, f32>) {
    let exchange = if seen.exchanged { EXCHANGE } else { 0 };
    let flags = exchange | if seen.heard.is_some() { PACKET } else { 0 };
    match seen.sensors.reading {
        Reading::Exact(axes) => {
            bytes.push(flags | EXACT);
            bytes.extend(axes.iter().flat_map(|axis| [axis.position, axis.velocity]).flat_map(f32::to_le_bytes));
        }
        Reading::Counts(counts) => {
            bytes.push(flags);
            bytes.extend(counts.iter().flat_map(|counts| counts.0.to_le_bytes()));
        }
    }
    if let Some([packet]) = seen.heard {
        bytes
            .extend([packet.motion.position, packet.motion.velocity, packet.wave].iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([packet.energy_j, packet.wave_integral].iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(packet.live_ticks.to_le_bytes());
    }
}
