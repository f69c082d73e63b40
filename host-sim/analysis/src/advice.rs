//! What to change in a scene that lies outside its region in any mode ([`super::judge`]): the smallest change of one gain
//! that brings it back, with a margin, or where no gain does, the settings that would.
//!
//! Gains are tried in this order: coordination stiffness K_T (it costs coherency, not feel), contact stiffness K_LC. Of each
//! the nearest stable interval is taken and entered by [`MARGIN`] of the gain at its edge, or to its middle where it is
//! narrower. What is proposed has been checked: the scene with it is stable.

use cohold_core::law::wave::Decode;
use cohold_core::settings::{Allowed, Key, Value};
use cohold_sim::scene::Scene;
use serde::Serialize;

use super::limit::{Effort, Limit, along};
use super::modes::{Hands, judge};
use super::sweep::{Range, Sweep};
use super::verdict::{Verdict, unjudged};
use crate::error::Error;

/// How far inside its region a proposed gain lies, as a fraction of the gain at the edge.
pub const MARGIN: f64 = 0.1;

/// The gains, in the order in which they are tried.
pub(crate) const GAINS: [&str; 2] = ["coordination.stiffness_n_per_m", "contact.stiffness_n_per_m"];

/// A change of one gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// Name of the key, `table.key`.
    pub key: &'static str,
    /// Value in the scene, in `unit`.
    pub from: f64,
    /// Value proposed, in `unit`.
    pub to: f64,
    /// The edge of the region between the two.
    pub limit: f64,
    /// Unit of all three.
    pub unit: &'static str,
    /// Spectral radius with the value proposed.
    pub spectral_radius: f64,
}

/// One line of advice on a scene: that it is stable, or which gain to change and to what.
///
/// # Errors
/// A scene that the analyser cannot judge.
pub fn advice(scene: &Scene) -> Result<String, Error> {
    let now = judge(scene)?;
    let radius = now.worst.spectral_radius;
    if now.worst.stable {
        return Ok(format!("inside its stability region (spectral radius {radius:.6})"));
    }
    if let Some(because) = now.worst.not_judged_because {
        return Ok(unjudged(because));
    }
    let far = if radius < 1e3 { "" } else { "far " };
    let size = if radius < 1e3 { format!(" (spectral radius {radius:.6})") } else { String::new() };
    // Where both hands would hold it, say that letting go is what does not.
    let held = now.modes.first().is_some_and(|mode| mode.mode == Hands::Both && mode.verdict.stable);
    let let_go = match now.worst_mode() {
        Hands::One if held => " once one hand lets go",
        Hands::None if held => " once both hands let go",
        _ => "",
    };
    let place = format!("{far}outside its stability region{let_go}{size}");
    if let Some(change) = change(scene)? {
        let Change { key, from, to, limit, unit, .. } = change;
        let verb = if to < from { "lower" } else { "raise" };
        return Ok(format!("{place}: {verb} {key} from {from} to {to} {unit} (its limit in every mode is {limit:.4})"));
    }
    Ok(match others(scene)? {
        None => format!("{place}: no single stiffness mends it; try less delay or more damping"),
        Some(settings) => format!("{place}: no single stiffness mends it, but {settings} does"),
    })
}

/// The change of one gain that brings an unstable scene back, if there is one.
///
/// # Errors
/// A scene that the analyser cannot judge.
pub fn change(scene: &Scene) -> Result<Option<Change>, Error> {
    let keys = scene.keys();
    for (name, key) in keys.iter().filter(|(name, _)| GAINS.contains(&name.as_str())) {
        let (Some(Value::Number(now)), Allowed::Number { max, .. }) = (scene.get(name), key.allowed) else { continue };
        let range = Range::up_to(name, max.min((4.0 * now).max(1.0)));
        let sweep = Sweep::new(scene, range)?;
        let limit = along(&sweep, Effort::every_mode())?;
        if let Some(change) = nearest(&sweep, &limit, now, key)? {
            return Ok(Some(change));
        }
    }
    Ok(None)
}

/// The nearest value that is stable with a margin.
fn nearest(sweep: &Sweep, limit: &Limit, now: f64, key: &Key) -> Result<Option<Change>, Error> {
    let range = &sweep.range;
    let edges = [&[range.from], &limit.crossings[..], &[range.to]].concat();
    let mut candidates: Vec<(f64, f64)> = Vec::new();
    for (at, pair) in edges.windows(2).enumerate() {
        let (low, high) = (pair[0], pair[1]);
        let stable = limit.stable_at_start == (at % 2 == 0);
        if stable && high < now {
            candidates.push((high, (high * (1.0 - MARGIN)).max(0.5 * (low + high))));
        } else if stable && low > now {
            candidates.push((low, (low * (1.0 + MARGIN)).min(0.5 * (low + high))));
        }
    }
    candidates.sort_by(|a, b| (a.0 - now).abs().total_cmp(&(b.0 - now).abs()));
    for (edge, inside) in candidates {
        let to = short(inside);
        let Verdict { stable, spectral_radius, .. } = judge(&sweep.at(to)?)?.worst;
        if stable && edge > 0.0 {
            return Ok(Some(Change { key: key.name, from: now, to, limit: edge, unit: key.unit, spectral_radius }));
        }
    }
    Ok(None)
}

/// Three significant digits: a gain is not known better.
pub(crate) fn short(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Other settings that make the scene stable as it is.
fn others(scene: &Scene) -> Result<Option<&'static str>, Error> {
    let named = [
        (true, false, "coordination.decode = \"implicit\""),
        (false, true, "object.force_delay_ticks = 0"),
        (true, true, "coordination.decode = \"implicit\" with object.force_delay_ticks = 0"),
    ];
    for (implicit, prompt, name) in named {
        let mut scene = scene.clone();
        if implicit {
            scene.peer.coordination.decode = Decode::Implicit;
        }
        if prompt {
            scene.peer.object.force_delay_ticks = 0.0;
        }
        if judge(&scene)?.worst.stable {
            return Ok(Some(name));
        }
    }
    Ok(None)
}
