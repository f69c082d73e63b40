//! Whether what is asked for is stable, on a thread of its own, one order after the other.
//!
//! **What is judged**: the linear scene at its shortest and at its longest constant delay, with the hands of [`super::hand`] on both
//! devices, on one, and on none. Where contact is two-sided and has no gap, device and object never part, and the mode with both
//! in contact is all there is; elsewhere every mode of [`haptic_analysis::judge`] counts. A delay of more than [`MOST_PACKETS`] in
//! flight takes seconds to judge, and is not.
//!
//! **What is asked first**: an order that takes a stable scene to one that is not known to be stable, unless it touches nothing
//! but the network, which nobody asks. Such a window learns why, and what to change; who says `anyway` gets it.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use haptic_analysis::{delays_ticks, judge, verdict};
use haptic_core::contact::RenderingName;
use haptic_core::names::Choice as _;
use haptic_core::{law::Sends, settings::Value};
use haptic_live::endpoint::stand_back;
use haptic_plot::significant;
use haptic_sim::scene::{Jitter, Scene};
use serde::Serialize;
use serde_json::json;

use super::hand::{DAMPING, STIFFNESS};
use super::kinds::EnvironmentKind;
use super::mailbox::{Mailbox, Request};
use super::orders::apply;
use super::session::same_but_for_network;
use crate::Error;

/// Packets in flight that are still judged.
const MOST_PACKETS: usize = 120;
/// Gains that are proposed to be lowered, in the order in which they are tried: K_T costs coherency, K_LC feel.
const GAINS: [&str; 2] = ["coordination.stiffness_n_per_m", "contact.stiffness_n_per_m"];
/// Halvings of a gain, then of the interval that holds the edge; how far inside it a proposal lies.
const HALVINGS: i32 = 16;
const CLOSER: usize = 10;
const MARGIN: f64 = 0.1;

/// Longest refusal, characters.
pub(super) const LONGEST_REFUSAL: usize = 1000;

/// How far the judge stands back behind what has to be in time.
const NICENESS: i32 = 10;

/// An order, and the window that gives it.
pub(super) struct Ask {
    pub(super) window: u64,
    pub(super) line: String,
}

/// What is known of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Finding {
    /// None where it was not judged.
    pub(super) stable: Option<bool>,
    /// Largest spectral radius of a packet period.
    pub(super) spectral_radius: Option<f64>,
    /// In words, with what to change.
    pub(super) text: String,
    /// `key=value` that would make it stable, if one gain does.
    pub(super) instead: Option<String>,
    /// What the verdict leaves out.
    pub(super) not_judged: Vec<&'static str>,
}

/// Starts the thread; gives where orders go. What is `fixed` is not changed, for this reason.
pub(super) fn start(
    mailbox: &Arc<Mailbox>,
    scene: Scene,
    kind: EnvironmentKind,
    fixed: Option<&'static str>,
) -> Result<SyncSender<Ask>, Error> {
    let (asks, orders) = sync_channel(16);
    let mailbox = Arc::clone(mailbox);
    let work = move || {
        stand_back(NICENESS);
        run(&mailbox, scene, kind, &orders, fixed);
    };
    std::thread::Builder::new().name("judge".into()).spawn(work)?;
    Ok(asks)
}

fn run(mailbox: &Mailbox, mut scene: Scene, mut kind: EnvironmentKind, orders: &Receiver<Ask>, fixed: Option<&str>) {
    tell(mailbox, &scene, None);
    let mut finding = find(&scene);
    tell(mailbox, &scene, Some(&finding));
    for Ask { window, line } in orders {
        let (anyway, line) = line.strip_prefix("anyway ").map_or((false, line.as_str()), |line| (true, line));
        let wanted = match wanted(&scene, kind, line, fixed) {
            Ok(Request::Scene(wanted)) => *wanted,
            Ok(Request::Show(other, fitting)) => {
                mailbox.lock().want(Request::Show(other, fitting.clone()));
                if fitting.settings() != scene.settings() {
                    tell(mailbox, &fitting, None);
                    finding = find(&fitting);
                }
                (kind, scene) = (other, *fitting);
                tell(mailbox, &scene, Some(&finding));
                continue;
            }
            Err(why) => {
                mailbox.lock().answer(window, json!({ "refused": refusal(&why) }).to_string());
                tell(mailbox, &scene, Some(&finding));
                continue;
            }
        };
        let free = anyway || finding.stable != Some(true) || same_but_for_network(&wanted, &scene);
        if free {
            // It acts now; what is to be said of it comes after.
            mailbox.lock().want(Request::Scene(Box::new(wanted.clone())));
            tell(mailbox, &wanted, None);
        }
        let found = find(&wanted);
        if !free && found.stable != Some(true) {
            let ask = json!({ "ask": { "line": line, "text": found.text, "instead": found.instead } });
            mailbox.lock().answer(window, ask.to_string());
            tell(mailbox, &scene, Some(&finding));
            continue;
        }
        if !free {
            mailbox.lock().want(Request::Scene(Box::new(wanted.clone())));
        }
        tell(mailbox, &wanted, Some(&found));
        (kind, scene, finding) = (kind.in_scene(&wanted), wanted, found);
    }
}

/// Why an order is refused, as a window gets it: one line, of which a long quotation is left out in the middle.
pub(super) fn refusal(why: &Error) -> String {
    let why = why.to_string();
    let why = haptic_io::escaped(&why);
    let length = why.chars().count();
    if length <= LONGEST_REFUSAL {
        return why.into_owned();
    }
    let part = LONGEST_REFUSAL / 2 - 1;
    why.chars().take(part).chain(['…']).chain(why.chars().skip(length - part)).collect()
}

/// What a line asks for, where that can be shown; else why not.
pub(super) fn wanted(scene: &Scene, kind: EnvironmentKind, line: &str, fixed: Option<&str>) -> Result<Request, Error> {
    if let Some(why) = fixed {
        return Err(why.into());
    }
    let Some(name) = line.strip_prefix("show ") else {
        let wanted = apply(scene, line)?;
        if kind.axes().is_none() {
            kind.open(&wanted)?;
        }
        return Ok(Request::Scene(Box::new(wanted)));
    };
    let other = EnvironmentKind::from_name(name)
        .ok_or_else(|| format!("{name}: there are {}", EnvironmentKind::NAMES.join(", ")))?;
    let fitting = other.fitting(scene.clone())?;
    other.open(&fitting)?;
    Ok(Request::Show(other, Box::new(fitting)))
}

/// Tells every window what holds: all settings, those that are not the usual ones, and what is known of them.
fn tell(mailbox: &Mailbox, scene: &Scene, finding: Option<&Finding>) {
    let usual = Scene::new(scene.laws).settings();
    let settings = scene.settings();
    let changed: Vec<_> = settings.iter().filter(|pair| !usual.contains(pair)).collect();
    let all: serde_json::Map<_, _> = settings.iter().map(|(key, value)| (key.clone(), json!(value))).collect();
    let one_way_s = delays_ticks(&scene.linear()).map(|ticks| ticks as f64 * scene.peer.timing.control_period_s);
    let holds = json!({ "settings": all, "changed": changed, "one_way_s": one_way_s[1], "finding": finding });
    mailbox.lock().tell(json!({ "holds": holds }).to_string());
}

/// Judges whether a scene is stable.
pub(super) fn find(scene: &Scene) -> Finding {
    let network = &scene.world.network;
    let in_flight = |scene: &Scene| {
        let longest = delays_ticks(&scene.linear()).into_iter().max().unwrap_or_default();
        longest / scene.peer.timing.ticks_per_packet as usize
    };
    let mut longest = scene.clone();
    if network.jitter == Jitter::Uniform {
        longest.world.network.extra_delay_s += network.jitter_s;
    }
    let mut not_judged = vec!["limits of force and speed", "the ends of travel"];
    not_judged.extend((scene.law().sends == Sends::Counters).then_some("ticks in which the line stands"));
    not_judged.extend((network.loss > 0.0).then_some("packets that are lost"));
    not_judged.extend((network.jitter != Jitter::None && network.jitter_s > 0.0).then_some("a delay that changes"));
    if in_flight(&longest) > MOST_PACKETS {
        let text = format!(
            "not judged: with more than {MOST_PACKETS} packets in flight that takes too long here; host-sim stability point does it"
        );
        return Finding { text, not_judged, ..Finding::default() };
    }
    match radius(scene, &longest) {
        Err(why) => Finding { text: format!("not judged: {why}"), not_judged, ..Finding::default() },
        Ok((radius, true)) => {
            let text = format!("stable: spectral radius {radius:.6}, not above 1");
            Finding { stable: Some(true), spectral_radius: Some(radius), text, instead: None, not_judged }
        }
        Ok((radius, false)) => {
            let (text, instead) = advice(scene, &longest, radius);
            Finding { stable: Some(false), spectral_radius: Some(radius.min(f64::MAX)), text, instead, not_judged }
        }
    }
}

/// The largest spectral radius of a scene whose delay is between that of the first and that of the second, and whether all are
/// stable.
fn radius(shortest: &Scene, longest: &Scene) -> Result<(f64, bool), haptic_analysis::Error> {
    let contact = &shortest.peer.contact;
    let parts = contact.one_sided || contact.gap_m > 0.0 || contact.rendering == RenderingName::Impulsive;
    let delays = if shortest.world.network == longest.world.network { &[shortest][..] } else { &[shortest, longest] };
    let mut worst = (f64::NEG_INFINITY, true);
    for scene in delays {
        for hands in [&[][..], &[0], &[0, 1]] {
            let mut held = (*scene).clone();
            for user in hands {
                let user = &mut held.users[*user].settings.user;
                user.arm_stiffness_n_per_m += STIFFNESS;
                user.arm_damping_n_s_per_m += DAMPING;
            }
            // Each delay is judged by itself.
            held.world.network.jitter = Jitter::None;
            let found = if parts { judge(&held)?.worst } else { verdict(&held)? };
            worst = (worst.0.max(found.spectral_radius), worst.1 && found.stable);
        }
    }
    Ok(worst)
}

/// What is wrong with an unstable scene and what to change, in words and as `key=value`.
fn advice(scene: &Scene, longest: &Scene, radius: f64) -> (String, Option<String>) {
    let size = if radius < 1e3 { format!("spectral radius {radius:.6}") } else { "far outside".to_owned() };
    let at = |key: &str, value: f64| -> Option<bool> {
        let [mut shortest, mut longest] = [scene, longest].map(Clone::clone);
        shortest.set_number(key, value).ok()?;
        longest.set_number(key, value).ok()?;
        self::radius(&shortest, &longest).ok().map(|(_, stable)| stable)
    };
    for key in GAINS {
        let Some(Value::Number(now)) = scene.get(key) else { continue };
        let lower = (1..=HALVINGS).map(|halvings| now * f64::powi(0.5, halvings));
        let Some(mut inside) = lower.into_iter().find(|value| at(key, *value) == Some(true)) else { continue };
        let mut outside = 2.0 * inside;
        for _ in 0..CLOSER {
            let middle = 0.5 * (inside + outside);
            *(if at(key, middle) == Some(true) { &mut inside } else { &mut outside }) = middle;
        }
        // Three significant digits: a gain is not known better.
        let to: f64 = format!("{:.2e}", (1.0 - MARGIN) * inside).parse().unwrap_or(inside);
        if at(key, to) == Some(true) {
            let text = format!(
                "unstable: {size}, above 1. Lower {key} from {now} to {to} N/m: its limit here is {} N/m",
                significant(inside, 4)
            );
            return (text, Some(format!("{key}={to}")));
        }
    }
    (format!("unstable: {size}, above 1. No single stiffness mends it: try less delay, or more damping"), None)
}

#[cfg(test)]
#[path = "../../tests/inside/judge.rs"]
mod tests;
