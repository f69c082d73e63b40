//! What is known of a scene while it runs: whether it is stable at every constant delay of its network table, and which gain to lower if
//! not. A page and a live peer ask this, and wait: so a gain is halved until it holds and then closed in on, in some thirty verdicts, where
//! [`super::advice`] scans its whole range.
//!
//! **What is judged**: every mode of [`super::judge`], as the command line has it: at each delay of [`super::delays`], with both hands on, one and
//! none, away from walls and at them. A hand that may take either device beside its user is tried on both, on one and on none. What is proposed
//! holds in all of that, as what [`super::advice`] proposes does.
//!
//! **What is not**: a law that is not linear, and more packets in flight than the caller has time for (an eigenvalue costs their cube).

use cohold_core::settings::Value;
use cohold_plot::significant;
use cohold_sim::scene::{Jitter, Network, Scene};
use serde::Serialize;

use super::advice::{GAINS, MARGIN, short};
use super::delays::delays;
use super::lifted::delay::whole_ticks;
use super::linear::is_linear;
use super::modes::{entered_by, not_judged, worst};
use super::verdict::{Verdict, unjudged};
use crate::error::Error;

/// Halvings of a gain, then of the interval that holds the edge.
const HALVINGS: i32 = 16;
const CLOSER: usize = 10;

/// A hand that may take a device beside its user, as a spring and a damper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Its stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// Its damping, N·s/m.
    pub damping_n_s_per_m: f64,
}

/// What is asked of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// A hand that may take either device.
    pub hand: Option<Hand>,
    /// Packets in flight one way that are still judged; of an object shared along several axes fewer, by the square of their number.
    pub most_packets: usize,
}

/// What is known of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Finding {
    /// None where it was not judged.
    pub stable: Option<bool>,
    /// Largest spectral radius of a packet period.
    pub spectral_radius: Option<f64>,
    /// In words, with what to change.
    pub text: String,
    /// `key=value` that would make it stable, if one gain does.
    pub instead: Option<String>,
    /// What the verdict leaves out.
    pub not_judged: Vec<&'static str>,
}

/// Judges whether a scene is stable.
pub fn find(scene: &Scene, question: Question) -> Finding {
    let (text, not_judged) = (String::new(), not_judged(scene));
    let finding = Finding { text, not_judged, ..Finding::default() };
    let unknown = |why: &str| Finding { text: format!("not judged: {why}"), ..finding.clone() };
    let most = question.most_packets / (scene.peer.axis.shared as usize).pow(2);
    let longest = delays(scene, &scene.linear()).0.into_iter().flatten().max().unwrap_or_default();
    if longest / scene.peer.timing.ticks_per_packet as usize > most {
        return unknown(&format!(
            "with more than {most} packets in flight that takes too long here; cohold stability point does it"
        ));
    }
    match is_linear(scene).and_then(|linear| linear.then(|| radius(scene, question.hand)).transpose()) {
        Err(why) => unknown(&why.to_string()),
        Ok(None) => unknown("the law is not linear"),
        Ok(Some(Verdict { spectral_radius, stable: true, .. })) => Finding {
            stable: Some(true),
            spectral_radius: Some(spectral_radius),
            text: format!("stable: spectral radius {spectral_radius:.6}, not above 1"),
            ..finding
        },
        Ok(Some(Verdict { not_judged_because: Some(because), .. })) => {
            Finding { stable: Some(false), text: unjudged(because), ..finding }
        }
        Ok(Some(Verdict { spectral_radius, .. })) => {
            let (text, instead) = lower(scene, question, spectral_radius);
            let spectral_radius = Some(spectral_radius.min(f64::MAX));
            Finding { stable: Some(false), spectral_radius, text, instead, ..finding }
        }
    }
}

/// This scene on a network on which a packet takes from `least_s` to `most_s`, s, each way, as a live end measures it, and nothing else is known.
/// Each end looks once a tick, wherever its ticks are, so that a round trip counts as the whole ticks that it fills or one more.
pub fn measured(scene: &Scene, [least_s, most_s]: [f64; 2]) -> Scene {
    let (mut scene, period_s) = (scene.clone(), scene.peer.timing.control_period_s);
    let round_trip = |one_way_s: f64| whole_ticks(2.0 * one_way_s, period_s);
    let (least, most) = (round_trip(least_s), round_trip(most_s) + 1);
    // Both ways vary alike, so a round trip by an even number.
    let least = least.saturating_sub((most - least) % 2);
    let seconds = |ticks: usize| ticks as f64 * period_s;
    scene.network_trace = None;
    scene.world.network = Network {
        one_way_delay_packets: 0,
        extra_delay_s: seconds(least / 2),
        asymmetry_s: seconds(least % 2),
        jitter: Jitter::Uniform,
        jitter_s: seconds((most - least).div_ceil(2)),
        playout_packets: scene.world.network.playout_packets,
        ..Network::default()
    };
    scene
}

/// The verdict with the largest spectral radius, over hands, walls, modes and delays.
fn radius(scene: &Scene, hand: Option<Hand>) -> Result<Verdict, Error> {
    let mut found = Vec::new();
    for held in 0..=hand.map_or(0, |_| scene.users.len()) {
        let mut scene = scene.clone();
        for (user, hand) in scene.users.iter_mut().zip(hand).take(held) {
            user.settings.user.arm_stiffness_n_per_m += hand.stiffness_n_per_m;
            user.settings.user.arm_damping_n_s_per_m += hand.damping_n_s_per_m;
        }
        found.extend(entered_by(&scene)?);
    }
    Ok(worst(&found))
}

/// What is wrong with an unstable scene and what to change, in words and as `key=value`.
fn lower(scene: &Scene, question: Question, radius: f64) -> (String, Option<String>) {
    let size = if radius < 1e3 { format!("spectral radius {radius:.6}") } else { "far outside".to_owned() };
    let holds = |key: &str, value: f64| {
        let mut scene = scene.clone();
        scene.set_number(key, value).is_ok() && self::radius(&scene, question.hand).is_ok_and(|verdict| verdict.stable)
    };
    for key in GAINS {
        let Some(Value::Number(now)) = scene.get(key) else { continue };
        let mut lower = (1..=HALVINGS).map(|halvings| now * f64::powi(0.5, halvings));
        let Some(mut inside) = lower.find(|value| holds(key, *value)) else { continue };
        let mut outside = 2.0 * inside;
        for _ in 0..CLOSER {
            let middle = 0.5 * (inside + outside);
            *(if holds(key, middle) { &mut inside } else { &mut outside }) = middle;
        }
        let to = short((1.0 - MARGIN) * inside);
        if holds(key, to) {
            let text = format!(
                "unstable: {size}, above 1. Lower {key} from {now} to {to} N/m: its limit in every mode is {} N/m",
                significant(inside, 4)
            );
            return (text, Some(format!("{key}={to}")));
        }
    }
    (format!("unstable: {size}, above 1. No single stiffness mends it: try less delay, or more damping"), None)
}
