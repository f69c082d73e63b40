//! What a page may ask to be set, as one line of text, and the scene that it gives: all of it, or none and why not.
//!
//! | line | asks for |
//! |---|---|
//! | `set KEY=VALUE …` | these keys, as `--set` takes them |
//! | `scene NAME [KEY=VALUE …]` | a built-in scene, or `default`, and these keys |
//! | `law NAME [KEY=VALUE …]` | another law, with the settings that it is recommended with, and these keys |
//! | `file TOML` | a scene file |
//! | `show NAME` | another environment in this scene ([`super::kinds`]) |
//!
//! Values go through the checks of a scene file. A key that names a file is refused: a page reads nothing of this machine.

use cohold_core::settings::Settings;
use cohold_sim::Laws;
use cohold_sim::{scene::Scene, scenes};
use cohold_studies::campaign::laws::SOLVED;

use super::session::PERIOD_S;
use cohold_cli::Failure;

/// The built-in scenes that are one click, with what the click is called and what it sets besides.
pub(super) const CLICKS: [(&str, &str, &str); 7] = [
    ("paper, taps, 16 ms", "paper-5.1-passive-wave-16ms", ""),
    ("paper, taps, 32 ms", "paper-5.1-passive-wave-32ms", ""),
    ("paper, both push, 16 ms", "paper-5.2-passive-wave-16ms", ""),
    ("matched line", "matched-line", ""),
    ("any network", "any-network", ""),
    ("50 % lost", "any-network", "network.loss=0.5"),
    ("bursts of 200 ms", "any-network", "network.loss=0.1 network.loss_burst_packets=200"),
];

/// Whether a scene can be played in real time.
pub(crate) fn check(scene: &Scene) -> Result<(), Failure> {
    let period_s = scene.peer.timing.control_period_s;
    if period_s != PERIOD_S {
        return Err(format!(
            "timing.control_period_s = {period_s} is not allowed with play: it must be {PERIOD_S} s, which is real time at 1 kHz"
        ).into());
    }
    Ok(())
}

/// What the scene is after a line.
pub(super) fn apply(scene: &Scene, line: &str) -> Result<Scene, Failure> {
    let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
    let (name, keys) = rest.split_once(' ').unwrap_or((rest, ""));
    let (scene, keys) = match word {
        "set" => (scene.clone(), split(rest)),
        "scene" if name == "default" => (Scene::new(scene.laws), split(keys)),
        "scene" => (scenes::load(scene.laws, name)?, split(keys)),
        "law" => {
            let (changed, own) = with_law(scene, name)?;
            (changed, own.into_iter().chain(split(keys)).collect())
        }
        "file" => (Scene::new(scene.laws), keys_of(rest)?),
        _ => return Err(format!("{word}: there is no such order; a page knows set, scene, law, file and show").into()),
    };
    set(scene, &keys)
}

/// The scene of a file's text, whatever its control period.
pub(super) fn of_file(laws: Laws, text: &str) -> Result<Scene, Failure> {
    let mut scene = Scene::new(laws);
    keys_of(text)?.iter().try_for_each(|key| scene.apply_override(key))?;
    Ok(scene)
}

fn split(keys: &str) -> Vec<String> {
    keys.split_whitespace().map(str::to_owned).collect()
}

fn set(mut scene: Scene, keys: &[String]) -> Result<Scene, Failure> {
    for text in keys {
        let key = text.split_once('=').map_or(text.as_str(), |(key, _)| key).trim();
        if key.rsplit('.').next() == Some("trace") {
            return Err(
                format!("{key} names a file, and a page reads none: give it as --set when play is started").into()
            );
        }
        scene.apply_override(text)?;
    }
    scene.check("the scene")?;
    check(&scene)?;
    Ok(scene)
}

/// What a scene file sets, a line for each key.
fn keys_of(text: &str) -> Result<Vec<String>, Failure> {
    let mut table: toml::Table = text.parse().map_err(|error: toml::de::Error| {
        let line = error.span().map_or(1, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
        format!("line {line} of the file: {}", error.message().replace('\n', " "))
    })?;
    // What made a file of results stands in its scene file too.
    table.remove("made");
    let mut keys = Vec::new();
    flatten("", &table, &mut keys);
    Ok(keys)
}

fn flatten(prefix: &str, table: &toml::Table, keys: &mut Vec<String>) {
    for (name, value) in table {
        match value {
            toml::Value::Table(inner) => flatten(&format!("{prefix}{name}."), inner, keys),
            value => keys.push(format!("{prefix}{name}={value}")),
        }
    }
}

/// This scene under another law, and the keys that make it that: with the peers' settings of the scene that
/// recommends it, or with the paper's settings and the law's own gains. Users, device and contact stay, and so does the network: where a
/// packet period is another one, its delay is kept in seconds. Keys that another law has declared are as if nobody had set them.
fn with_law(scene: &Scene, name: &str) -> Result<(Scene, Vec<String>), Failure> {
    let recommended = match name {
        "self-timed" => Some("any-network"),
        "passive-mean" => Some("hub"),
        _ => None,
    };
    let base = match recommended {
        Some(from) => scenes::load(scene.laws, from)?.peer,
        None => Settings::default(),
    };
    let mut changed = scene.clone();
    (changed.peer.timing, changed.peer.object) = (base.timing, base.object);
    (changed.peer.coordination, changed.peer.safety) = (base.coordination, base.safety);
    changed.peer.own = base.own;
    let network = &mut changed.world.network;
    let delay_s = f64::from(network.one_way_delay_packets) * scene.peer.timing.packet_period_s();
    if base.timing != scene.peer.timing && delay_s > 0.0 {
        let packets = base.timing.packet_periods(delay_s);
        let left_s = delay_s - f64::from(packets) * base.timing.packet_period_s();
        let whole = left_s.abs() < 1e-9;
        network.one_way_delay_packets = if whole { packets } else { 0 };
        network.extra_delay_s += if whole { 0.0 } else { delay_s };
    }
    let info = scene.laws.all().iter().find(|law| law.name == name);
    let gains = info.filter(|_| recommended.is_none()).map_or(&[][..], |law| law.gains);
    // What moves and decodes in one solve takes neither from the tick before.
    let solved = if gains.contains(&"object.integrator=midpoint") { &SOLVED[..] } else { &[] };
    let law = format!("coordination.comm={name}");
    let keys = solved.iter().chain(gains).map(|gain| (*gain).to_owned());
    Ok((changed, std::iter::once(law).chain(keys).collect()))
}

#[cfg(test)]
#[path = "../tests/inside/orders.rs"]
mod tests;
