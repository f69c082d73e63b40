//! Whether what is asked for is stable, on a thread of its own, one order after the other.
//!
//! **What is judged**: [`cohold_analysis::find`], with the hands of [`super::hand`] on both devices, on one, and on none. A delay of more
//! than [`MOST_PACKETS`] in flight takes seconds to judge, and is not.
//!
//! **What is asked first**: an order that takes a stable scene to one that is not known to be stable, unless it touches nothing
//! but the network, which nobody asks. Such a window learns why, and what to change; who says `anyway` gets it.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use cohold_analysis::{Effort, Finding, Hand, Question, Range, delays_ticks, limit};
use cohold_live::endpoint::stand_back;
use cohold_sim::scene::{Jitter, Scene};
use serde_json::json;

use super::kinds::{EnvironmentKind, Kinds};
use super::mailbox::{Mailbox, Request};
use super::orders::apply;
use super::session::same_but_for_network;
use cohold_cli::Failure;
use cohold_live::hand::{DAMPING, STIFFNESS};

/// A hand of the page's, as an analysis has it.
pub(crate) const HAND: Hand = Hand { stiffness_n_per_m: STIFFNESS, damping_n_s_per_m: DAMPING };
/// Packets in flight that are still judged.
const MOST_PACKETS: usize = 120;
/// What is asked of a scene: the hand is one of the page's on a device.
const QUESTION: Question = Question { hand: Some(HAND), most_packets: MOST_PACKETS };

/// Longest refusal, characters.
pub(super) const LONGEST_REFUSAL: usize = 1000;

/// The gain whose edge a picture tells of, where that is looked for, N/m, and at how many points first.
const EDGE_OF: &str = "coordination.stiffness_n_per_m";
const EDGE_WITHIN: [f64; 2] = [50.0, 5000.0];
const EDGE_STEPS: usize = 40;

/// How far the judge stands back behind what has to be in time.
const NICENESS: i32 = 10;

/// An order, and the window that gives it.
pub(super) struct Ask {
    pub(super) window: u64,
    pub(super) line: String,
}

/// Starts the thread; gives where orders go. A picture with a scene of its own is left to the scene of the workshop. What is `fixed` is not
/// changed, for this reason.
pub(super) fn start(
    mailbox: &Arc<Mailbox>,
    scene: Scene,
    workshop: Scene,
    kind: EnvironmentKind,
    kinds: Kinds,
    fixed: Option<&'static str>,
) -> Result<SyncSender<Ask>, Failure> {
    let (asks, orders) = sync_channel(16);
    let mailbox = Arc::clone(mailbox);
    let work = move || {
        stand_back(NICENESS);
        run(&mailbox, scene, workshop, kind, &orders, &|scene, kind, line| wanted(scene, kind, line, kinds, fixed));
    };
    std::thread::Builder::new().name("judge".into()).spawn(work)?;
    Ok(asks)
}

fn run(
    mailbox: &Mailbox,
    mut scene: Scene,
    mut workshop: Scene,
    mut kind: EnvironmentKind,
    orders: &Receiver<Ask>,
    wanted: &dyn Fn(&Scene, EnvironmentKind, &str) -> Result<Request, Failure>,
) {
    let mut edge = Edge::default();
    tell(mailbox, &scene, None, None);
    let mut finding = find(&scene);
    loop {
        tell(mailbox, &scene, Some(&finding), edge.of(&scene, kind));
        let Ok(Ask { window, line }) = orders.recv() else { return };
        let (anyway, line) = line.strip_prefix("anyway ").map_or((false, line.as_str()), |line| (true, line));
        // What follows a picture is the workshop as it was left.
        let from = if kind.is_story() && line.starts_with("show ") { &workshop } else { &scene };
        let wanted = match wanted(from, kind, line) {
            Ok(Request::Scene(wanted)) => *wanted,
            Ok(Request::Show(other, fitting)) => {
                if !kind.is_story() {
                    workshop = scene.clone();
                }
                mailbox.lock().want(Request::Show(other, fitting.clone()));
                if fitting.settings() != scene.settings() {
                    tell(mailbox, &fitting, None, None);
                    finding = find(&fitting);
                }
                (kind, scene) = (other, *fitting);
                continue;
            }
            Err(why) => {
                mailbox.lock().answer(window, json!({ "refused": refusal(&why) }).to_string());
                continue;
            }
        };
        let free = anyway || finding.stable != Some(true) || same_but_for_network(&wanted, &scene);
        if free {
            // It acts now; what is to be said of it comes after.
            mailbox.lock().want(Request::Scene(Box::new(wanted.clone())));
            tell(mailbox, &wanted, None, None);
        }
        let found = find(&wanted);
        if !free && found.stable != Some(true) {
            let ask = json!({ "ask": { "line": line, "text": found.text, "instead": found.instead } });
            mailbox.lock().answer(window, ask.to_string());
            continue;
        }
        if !free {
            mailbox.lock().want(Request::Scene(Box::new(wanted.clone())));
        }
        (kind, scene, finding) = (kind.in_scene(&wanted), wanted, found);
    }
}

/// Where a scene becomes unstable along [`EDGE_OF`], which is looked for anew when anything else of it is another.
#[derive(Default)]
struct Edge {
    others: Vec<(String, String)>,
    at: Option<f64>,
}

impl Edge {
    /// The least gain that is unstable, N/m, where the picture tells of it.
    fn of(&mut self, scene: &Scene, kind: EnvironmentKind) -> Option<f64> {
        if kind != EnvironmentKind::TooStiff {
            return None;
        }
        let others: Vec<_> = scene.settings().into_iter().filter(|(key, _)| key != EDGE_OF).collect();
        if others != self.others {
            (self.others, self.at) = (others, edge(scene));
        }
        self.at
    }
}

/// The least gain that is unstable with both simulated hands on, N/m, if there is one.
pub(super) fn edge(scene: &Scene) -> Option<f64> {
    let [from, to] = EDGE_WITHIN;
    let effort = Effort { steps: EDGE_STEPS, tolerance: 1e-3, ..Effort::default() };
    let found = limit(scene, Range { key: EDGE_OF.into(), from, to }, effort).ok()?;
    found.crossings.first().copied().filter(|_| found.stable_at_start)
}

/// Why an order is refused, as a window gets it: one line, of which a long quotation is left out in the middle.
pub(super) fn refusal(why: &Failure) -> String {
    let why = why.to_string();
    let why = cohold_io::escaped(&why);
    let length = why.chars().count();
    if length <= LONGEST_REFUSAL {
        return why.into_owned();
    }
    let part = LONGEST_REFUSAL / 2 - 1;
    why.chars().take(part).chain(['…']).chain(why.chars().skip(length - part)).collect()
}

/// What a line asks for, where that can be shown; else why not.
pub(super) fn wanted(
    scene: &Scene,
    kind: EnvironmentKind,
    line: &str,
    kinds: Kinds,
    fixed: Option<&str>,
) -> Result<Request, Failure> {
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
    let other = kinds.named(name).ok_or_else(|| format!("{name}: there are {}", kinds.names().join(", ")))?;
    let fitting = other.fitting(scene.clone())?;
    other.open(&fitting)?;
    Ok(Request::Show(other, Box::new(fitting)))
}

/// Tells every window what holds.
fn tell(mailbox: &Mailbox, scene: &Scene, finding: Option<&Finding>, edge: Option<f64>) {
    mailbox.lock().tell(holds(scene, finding, edge));
}

/// What holds: all settings, those that are not the usual ones, what is known of them, and where the edge is that a picture tells of.
pub(super) fn holds(scene: &Scene, finding: Option<&Finding>, edge: Option<f64>) -> String {
    let usual = Scene::new(scene.laws).settings();
    let settings = scene.settings();
    let changed: Vec<_> = settings.iter().filter(|pair| !usual.contains(pair)).collect();
    let all: serde_json::Map<_, _> = settings.iter().map(|(key, value)| (key.clone(), json!(value))).collect();
    let one_way_s = delays_ticks(&scene.linear()).map(|ticks| ticks as f64 * scene.peer.timing.control_period_s);
    let holds =
        json!({ "settings": all, "changed": changed, "one_way_s": one_way_s[1], "finding": finding, "edge": edge });
    json!({ "holds": holds }).to_string()
}

/// What is found of a scene whose devices the page's hands may hold.
pub(super) fn find(scene: &Scene) -> Finding {
    let network = &scene.world.network;
    let mut not_judged = vec!["limits of force and speed", "the ends of travel"];
    not_judged.extend((scene.law().own_time).then_some("ticks in which the line stands"));
    not_judged.extend((network.loss > 0.0).then_some("packets that are lost"));
    not_judged.extend((network.jitter != Jitter::None && network.jitter_s > 0.0).then_some("a delay that changes"));
    Finding { not_judged, ..cohold_analysis::find(scene, QUESTION) }
}

#[cfg(test)]
#[path = "../tests/inside/judge.rs"]
mod tests;
