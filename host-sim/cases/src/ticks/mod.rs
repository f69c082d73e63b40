//! The ticks that are measured: one short [`recording`] per scene, the same for every number type and every tool.
//!
//! Shared by `benches/instructions.rs` (exact counts) and `host-sim/benches/ticks.rs` (time).

pub mod recording;

use haptic_core::device::kinematics::KinematicsName;
use haptic_core::device::velocity::VelocityName;
use haptic_core::law::wave::{Decode, PassiveWave};
use haptic_core::law::{AnyLaw, Law};
use haptic_core::num::{Fixed, Scalar};
use haptic_core::peer::{Actuators, Peer};
use haptic_core::settings::Settings;

use recording::{Input, Recording, step};

/// Whatever measures the cases.
pub trait Measure {
    /// Measures the scene that `settings` describe, called `scene`, computing in `S`.
    fn case<S: Scalar, L: Law<S>>(&mut self, scene: &'static str, settings: &Settings);
}

/// Every scene in every number type.
pub fn measure_all(measure: &mut impl Measure) {
    for (scene, change) in SCENES {
        let mut settings = Settings::default();
        change(&mut settings);
        measure.case::<f32, AnyLaw<f32>>(scene, &settings);
        measure.case::<f64, AnyLaw<f64>>(scene, &settings);
        measure.case::<Fixed, AnyLaw<Fixed>>(scene, &settings);
    }
    let settings = Settings::default();
    measure.case::<f32, PassiveWave<f32>>(NAMED, &settings);
    measure.case::<f64, PassiveWave<f64>>(NAMED, &settings);
    measure.case::<Fixed, PassiveWave<Fixed>>(NAMED, &settings);
}

/// A change to the default settings.
type Change = fn(&mut Settings);

/// What each scene changes of the default settings, which are the paper's: passive wave, delayed decode. Stiffnesses are
/// the largest the paper found at a round trip of 16 ms.
const SCENES: &[(&str, Change)] = &[
    ("no-coordination", |settings| settings.coordination.comm = "none"),
    ("power", |settings| {
        settings.coordination.comm = "power";
        settings.coordination.stiffness_n_per_m = 310.0;
    }),
    ("wave", |settings| {
        settings.coordination.comm = "wave";
        settings.coordination.stiffness_n_per_m = 1590.0;
    }),
    ("passive-wave", |_| {}),
    ("passive-wave-implicit", |settings| settings.coordination.decode = Decode::Implicit),
    ("passive-mean-implicit", |settings| {
        settings.coordination.comm = "passive-mean";
        settings.coordination.decode = Decode::Implicit;
    }),
    ("passive-mean-implicit-ledger-drift", |settings| {
        settings.coordination.comm = "passive-mean";
        settings.coordination.decode = Decode::Implicit;
        settings.coordination.ledger = true;
        settings.coordination.drift_correction = true;
    }),
    ("one-sided-gap", |settings| {
        settings.contact.one_sided = true;
        settings.contact.gap_m = 0.002;
    }),
    ("encoder-adaptive-two-axes", |settings| {
        settings.axis.count = 2;
        settings.axis.velocity = VelocityName::Adaptive;
    }),
    ("five-bar-adaptive-two-axes", |settings| {
        settings.axis.count = 2;
        settings.axis.velocity = VelocityName::Adaptive;
        settings.kinematics.model = KinematicsName::FiveBar;
    }),
];

/// The passive wave again, in an image that names its law and carries no other.
const NAMED: &str = "passive-wave-named-law";

/// Replays a recording with `measured_tick`.
pub fn replay<S: Scalar, L: Law<S>>(recording: &Recording<S, L>) {
    recording.replay(measured_tick);
}

/// [`step`] as a function that tools can find by its name, called by nothing but [`replay`].
#[inline(never)]
fn measured_tick<S: Scalar, L: Law<S>>(peer: &mut Peer<S, L>, input: &Input<S>) -> Actuators<S> {
    step(peer, input)
}
