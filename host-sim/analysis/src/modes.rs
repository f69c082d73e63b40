//! Every mode that a scene can enter, judged: both hands on, one, none (THEORY §9).
//!
//! A verdict holds for the mode that it looked at. A scene that is stable while both hold the object may be unstable when one
//! or both let go of it, and a one-sided contact or one with a gap lets go by itself. Each mode is the linear scene
//! ([`Scene::linear`]) with contact at two, one or no peers ([`Scene::hands_off`]), judged at every constant delay that the
//! network table can produce ([`super::delays`]). Where a device or the object can meet a wall, each is judged with every wall met for
//! good as well ([`Scene::at_walls`]). The worst radius decides.
//!
//! Rendered by impacts, a contact that lasts is the spring and the damper of the same table: they are judged, the impacts are not.
//!
//! **Cost**: both and none fall apart into sum and difference where delays and arms are the same; one never does.

use cohold_core::contact::RenderingName;
use cohold_core::device::kinematics::KinematicsName;
use cohold_core::device::velocity::VelocityName;
use cohold_core::law::self_timed::TAUTNESS;
use cohold_core::names::Choice;
use cohold_sim::network::fitted::Like;
use cohold_sim::scene::{DriveName, Jitter, Scene};
use cohold_sim::user::User;
use serde::Serialize;

use super::delays::delays;
use super::lifted::delay::{at_delays, delays_ticks};
use super::lifted::driven::{counts, keeps_silent};
use super::linear::{is_linear, matrix_says_all};
use super::verdict::{Analyser, Reduced, Verdict};
use crate::error::Error;

cohold_sim::choices! {
    /// Whose hands are on their devices, in contact with the object.
    #[derive(Serialize)]
    #[serde(rename_all = "lowercase")]
    Hands {
        "both" => Both, "Both users hold the object.";
        "one" => One, "One user's; the other has let go.";
        "none" => None, "Nobody's: the copies and what holds them together are all there is.";
    }
}

impl Hands {
    /// Name of the mode, for a person.
    pub(crate) fn named(self, at_walls: bool) -> String {
        self.name().to_owned() + if at_walls { ", at the walls" } else { "" }
    }
}

/// The verdict on one mode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mode {
    /// Whose hands are on.
    pub mode: Hands,
    /// What walls there are hold what they can hold ([`Scene::at_walls`]).
    #[serde(skip_serializing_if = "is_false")]
    pub at_walls: bool,
    /// The worst of every delay, and of either peer let go where that matters.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// Delays to peer 1 and to peer 2 that gave it, ticks; absent where it is the scene's own.
    pub at_delay_ticks: Option<[usize; 2]>,
    /// The tautness that gave it; absent where it is the scene's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_tautness: Option<f64>,
}

#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_false(flag: &bool) -> bool {
    !flag
}

impl Mode {
    /// Name of the mode, for a person.
    pub fn name(&self) -> String {
        self.mode.named(self.at_walls)
    }
}

/// The verdict on every mode of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// That of the mode with the largest spectral radius: stable means that every mode is.
    #[serde(flatten)]
    pub worst: Verdict,
    /// One for each mode.
    pub modes: Vec<Mode>,
    /// What this scene has and the verdict leaves out, in plain words.
    pub not_judged: Vec<&'static str>,
}

impl Judgement {
    /// The mode with the largest spectral radius, the first of equals.
    pub fn worst_mode(&self) -> Hands {
        self.modes.iter().find(|mode| mode.verdict == self.worst).map_or(Hands::Both, |mode| mode.mode)
    }

    /// The modes that are not stable, by name.
    pub fn unstable_modes(&self) -> Vec<String> {
        let name =
            |mode: &Mode| mode.name() + if mode.verdict.not_judged_because.is_some() { " (not judged)" } else { "" };
        self.modes.iter().filter(|mode| !mode.verdict.stable).map(name).collect()
    }
}

/// Judges every mode that a scene can enter.
///
/// # Errors
/// A scene that the analyser cannot judge in one of its modes.
pub fn judge(scene: &Scene) -> Result<Judgement, Error> {
    let modes = entered_by(scene)?;
    let worst = worst(&modes);
    let not_judged = worst.not_judged_because.into_iter().chain(not_judged(scene)).collect();
    Ok(Judgement { worst, modes, not_judged })
}

/// Every mode of a scene, away from walls and at them.
pub(crate) fn entered_by(scene: &Scene) -> Result<Vec<Mode>, Error> {
    let mut analyser = Analyser::default();
    let mut modes = analyser.modes(scene, None)?;
    if let Some(met) = scene.at_walls() {
        modes.extend(analyser.modes(&met, None)?.into_iter().map(|mode| Mode { at_walls: true, ..mode }));
    }
    Ok(modes)
}

/// The verdict with the largest spectral radius, the first of equals.
pub(crate) fn worst(modes: &[Mode]) -> Verdict {
    modes.iter().map(|mode| mode.verdict).fold(Verdict::LEAST, Verdict::or_worse)
}

/// Every mode, or the one that is asked for.
pub(crate) fn entered(only: Option<Hands>) -> Vec<Hands> {
    only.map_or_else(|| Hands::ALL.to_vec(), |mode| vec![mode])
}

impl Analyser {
    /// The verdict on each mode that the scene can enter, or on the one that is asked for.
    pub(crate) fn modes(&mut self, scene: &Scene, only: Option<Hands>) -> Result<Vec<Mode>, Error> {
        let modes = entered(only);
        let linear = scene.linear();
        let (own, (delays, _)) = (delays_ticks(&linear), delays(scene, &linear));
        let (verdict, at_delay_ticks, at_tautness) = (Verdict::LEAST, None, None);
        let least = |mode| Mode { mode, at_walls: false, verdict, at_delay_ticks, at_tautness };
        let mut found: Vec<Mode> = modes.iter().copied().map(least).collect();
        self.parts.clear();
        // A line that counts its ticks is another one at each delay, and so is a run.
        let says_all = matrix_says_all(&linear)?;
        let runs = counts(&linear) || !says_all;
        for (tautness, linear) in as_taut_as_it_may_be(&linear) {
            for delays in delays.chunks(if runs { 1 } else { delays.len() }) {
                let other = (runs && delays[0] != own).then(|| at_delays(&linear, delays[0]));
                let linear = other.as_ref().unwrap_or(&linear);
                self.measure((linear, says_all), [modes != [Hands::None], modes != [Hands::Both]], delays)?;
                found.iter_mut().try_for_each(|worst| self.mode(worst, tautness, delays))?;
            }
        }
        found.iter_mut().for_each(|mode| mode.at_delay_ticks = mode.at_delay_ticks.filter(|at| *at != own));
        Ok(found)
    }

    /// Puts the worst verdict on a mode of what was measured in the place of what was the `worst`, if it is worse.
    fn mode(&mut self, worst: &mut Mode, taut: Option<f64>, all: &[[usize; 2]]) -> Result<(), Error> {
        let mode = worst.mode;
        let sides_differ = self.sides_differ();
        let let_go = |[to_one, to_two]: [usize; 2]| -> &[[bool; 2]] {
            match mode {
                Hands::Both => &[[false; 2]],
                // Where in its period each end hears matters to which of them has a hand.
                Hands::One if sides_differ || to_one != to_two => &[[false, true], [true, false]],
                Hands::One => &[[false, true]],
                Hands::None => &[[true; 2]],
            }
        };
        for delays in all {
            for released in let_go(*delays) {
                let verdict = self.judged(*released, *delays)?;
                if verdict.spectral_radius > worst.verdict.spectral_radius {
                    (worst.verdict, worst.at_delay_ticks, worst.at_tautness) = (verdict, Some(*delays), taut);
                }
            }
        }
        Ok(())
    }

    /// What is left of the lifted matrices of a mode, one for every part.
    pub(crate) fn matrices(&mut self, scene: &Scene, mode: Hands) -> Result<Vec<Reduced>, Error> {
        self.reduced(|analyser| analyser.modes(scene, Some(mode)).map(drop))
    }

    /// The largest spectral radius of the modes.
    pub(crate) fn radius(&mut self, scene: &Scene, only: Option<Hands>) -> Result<f64, Error> {
        Ok(worst(&self.modes(scene, only)?).spectral_radius)
    }
}

/// More than all of a line's tautness, as a multiple: for arms and devices that no scene knows (THEORY §15).
const TAUTER: f64 = 1.5;

/// A linear scene as it is; and if its line is taut, also with nothing of that, for a tank that is short leaves less of it, and with more than all.
fn as_taut_as_it_may_be(linear: &Scene) -> impl Iterator<Item = (Option<f64>, Scene)> {
    let all = linear.peer.own(&TAUTNESS);
    let others = [Some(0.0), Some((TAUTER * all).min(TAUTER))].into_iter().filter(move |_| all > 0.0);
    [None].into_iter().chain(others).filter_map(|tautness| {
        let mut other = linear.clone();
        tautness.is_none_or(|tautness| other.set_number(TAUTNESS.name, tautness).is_ok()).then_some((tautness, other))
    })
}

/// What linear analysis at constant delays leaves out of this scene.
pub(crate) fn not_judged(scene: &Scene) -> Vec<&'static str> {
    let (peer, plant, network) = (&scene.peer, &scene.world.plant, &scene.world.network);
    let (contact, law) = (&peer.contact, &peer.coordination);
    let recorded = scene.network_trace.is_some();
    let wound = plant.motor && plant.winding;
    let drawn = |of_table: bool| of_table && !recorded;
    let every_delay = delays(scene, &scene.linear()).1;
    let cogging = plant.cogging_n_or_n_m + peer.motor.cogging_n_or_n_m;
    let all = [
        (true, "limits of force, slew and speed"),
        (contact.rendering == RenderingName::Impulsive, "impacts"),
        (contact.one_sided || contact.gap_m > 0.0, "contact that opens and closes (each state is judged by itself)"),
        (plant.encoder, "steps of the encoder"),
        (plant.coulomb_n > 0.0, "friction of the device"),
        (cogging > 0.0, "cogging, and what cancels it"),
        (plant.motor, "steps and saturation of the motor"),
        (wound && plant.drive == DriveName::Voltage, "the windings of the motors, which no current loop drives"),
        (
            wound && plant.drive == DriveName::Current,
            "the current loop, but for its lag and what back-EMF it lets through",
        ),
        (scene.peers().iter().any(|peer| peer.fixture.friction > 0.0), "friction along walls"),
        (peer.axis.velocity == VelocityName::Adaptive, "the velocity window that adapts"),
        (peer.axis.count > peer.axis.shared, "the axes that are held on their line"),
        (
            peer.kinematics.model != KinematicsName::Direct,
            if scene.is_coupled() {
                "the geometry of the mechanism away from home"
            } else {
                "the geometry of the mechanism"
            },
        ),
        (
            scene.is_shared_along_several() && scene.users.iter().any(User::has_wall),
            "the walls of a room along one axis alone (they are judged along all)",
        ),
        (scene.at_walls().is_some(), "walls that are met and left (each state is judged by itself)"),
        (scene.users.iter().any(|user| user.settings.user.clutch_for_s > 0.0), "clutches that open and close"),
        (law.ledger, "the energy ledger, when it cuts"),
        (scene.law().own_time, "ticks in which the line stands, or is made longer or shorter"),
        (scene.law().budgets().next().is_some(), "what the law's energy tank holds back when it is short"),
        (is_linear(scene).is_ok_and(|linear| !linear), "what is not linear about the law, but for one small kick"),
        (scene.law().learns, "what the law learns, but for what it learns from one kick"),
        (keeps_silent(scene), "silence on purpose, but for motions that are worth no packet, or always one"),
        (law.drift_correction, "the correction of drift"),
        (recorded, "what the recorded network did"),
        (drawn(network.loss > 0.0 || network.corrupt > 0.0), "packets that are lost"),
        (drawn(network.reorder > 0.0), "packets that are overtaken"),
        (drawn(network.duplicate > 0.0), "packets that arrive twice"),
        (drawn(network.bandwidth_bit_per_s > 0.0), "packets that queue for the line"),
        (
            drawn(network.jitter == Jitter::Uniform && network.jitter_s > 0.0),
            "a delay that changes from packet to packet",
        ),
        (
            drawn(matches!(network.jitter, Jitter::Gamma | Jitter::Pareto) && network.jitter_s > 0.0),
            "jitter: it has no largest delay",
        ),
        (drawn(network.like != Like::None), "what varies in a network that is like one that was measured"),
        (drawn(network.reverse_block_packets > 1), "packets that come in reversed blocks"),
        (drawn(network.delay_step_s != 0.0), "the moment at which the delay steps"),
        (!every_delay, "delays between those that were judged"),
        (network.clock_drift_ppm != 0.0, "clocks that drift"),
    ];
    all.into_iter().filter_map(|(has, what)| has.then_some(what)).collect()
}
