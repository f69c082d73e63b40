//! The protocol in numbers: the scene of all laws, what their gains may do to a hand, and what is tuned between which ends.
//!
//! docs/results/laws.md says why. Settings are those of a scene file, set over the campaign's scene ([`law_scene`]): users push as in the cooperation
//! paper's §5.2, K_LC = 1000 N/m, B_LC = 2 N·s/m, a device of 0.1 kg and 1 N·s/m whose force is late by [`SCENE`], one solve a tick; in silence all let go
//! as late ([`LADDER`](crate::campaign::laws::LADDER)).

use cohold_core::settings::{Allowed, LawInfo, Sends, Value};
use cohold_sim::peers::Laws;
use cohold_sim::scene::Scene;

use crate::Error;
use crate::campaign::laws::law_scene;
use crate::study::around::Gain;

/// What is the same for all beside the campaign's scene: a packet a tick, 8 ms one way.
pub const SCENE: [&str; 2] = ["timing.ticks_per_packet=1", "network.one_way_delay_packets=8"];

/// What a hand may feel at most of an object that it moves alone at 0.2 and 1 Hz, |Z|, N·s/m: each gives a point of a law's front.
pub const BOUNDS_N_S_PER_M: [f64; 3] = [5.0, 25.0, 50.0];
/// Frequencies at which it is measured, Hz.
pub const FREQUENCIES_HZ: [f64; 3] = [0.2, 1.0, 5.0];
/// The most that it may feel at 5 Hz, whatever the bound, N·s/m: 0.7 kg on the contact's spring, which resonate at 6 Hz, are some 70 there.
pub const MOST_AT_5_HZ_N_S_PER_M: f64 = 100.0;
/// The heaviest that the object may feel at 1 Hz, copies and line together, kg.
pub const MOST_MASS_KG: f64 = 0.8;

/// Gains of the scene that every law may choose, and those of a line only laws that send waves.
const COMMON: [(&str, f64, f64); 4] = [
    ("coordination.stiffness_n_per_m", 1e2, 1e5),
    ("coordination.damping_n_s_per_m", 0.5, 60.0),
    ("object.mass_kg", 0.02, 0.3),
    ("object.damping_n_s_per_m", 0.01, 30.0),
];
const LINE: (&str, f64, f64) = ("coordination.wave_impedance_n_s_per_m", 3.0, 200.0);
/// A law's own key goes from a tenth of what it declares to ten times that, within what the key accepts.
const OWN: f64 = 10.0;

/// What is tuned of a law: the common gains, the line's, and the numbers among its own keys: from a tenth of what it declares to ten times that, and, of
/// one that has no unit and is 0 there, all that it accepts. Joules are none of them: what may be given away before anything was taken is a promise, and no
/// gain. Nor is a quantity with a unit that is 0, for nothing says how large it would be.
///
/// # Errors
/// A law whose scene at its own gains is refused.
pub fn gains(laws: Laws, law: &LawInfo) -> Result<Vec<Gain>, Error> {
    let scene = scene(laws, law, "")?;
    let line = law.sends == Sends::Waves;
    let common = COMMON.into_iter().chain(line.then_some(LINE));
    let mut gains: Vec<Gain> =
        common.map(|(key, low, high)| Gain { key: key.to_owned(), ends: [low, high], whole: false }).collect();
    for key in law.keys.iter().filter(|key| key.unit != "J") {
        let (min, max, whole) = match key.allowed {
            Allowed::Number { min, max } => (min, max, false),
            Allowed::Whole { min, max } => (f64::from(min), f64::from(max), true),
            _ => continue,
        };
        // Silence on purpose is part of a law only if it declares some.
        let silent = key.name.starts_with("event.") && !law.gains.iter().any(|gain| gain.starts_with("event."));
        match scene.get(key.name) {
            Some(Value::Number(own)) if !silent && (own > 0.0 || key.unit.is_empty()) => {
                let ends = if own > 0.0 { [min.max(own / OWN), max.min(own * OWN)] } else { [min, max] };
                gains.push(Gain { key: key.name.to_owned(), ends, whole });
            }
            _ => {}
        }
    }
    Ok(gains)
}

/// The scene of a law at these gains, blanks between; none are those that it declares.
///
/// # Errors
/// Gains that the law refuses.
pub fn scene(laws: Laws, law: &LawInfo, gains: &str) -> Result<Scene, Error> {
    let set: Vec<String> = SCENE.iter().copied().chain(gains.split_whitespace()).map(str::to_owned).collect();
    law_scene(laws, law, None, &set)
}
