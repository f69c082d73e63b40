//! Scenes whose ticks are counted, each with the scene that it adds something to.
//!
//! The table that comes of it: [the cost per scene](../../cost/index.html).

use haptic_core::device::kinematics::{KinematicsName, Maths};
use haptic_core::device::velocity::VelocityName;
use haptic_core::law::wave::Decode;
use haptic_core::object::IntegratorName;
use haptic_core::settings::{LawInfo, Settings, Value};

/// A scene that is counted.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Name; `tick/NAME` is its case.
    pub name: &'static str,
    /// The scene it is compared with.
    pub over: Option<&'static str>,
    /// What it has that the other has not.
    pub adds: &'static str,
    change: fn(&mut Settings),
}

impl Scene {
    /// The settings of a peer of this scene.
    pub fn settings(&self) -> Settings {
        let mut settings = Settings::default();
        settings.coordination.stiffness_n_per_m = 1590.0;
        (self.change)(&mut settings);
        settings
    }
}

/// The passive wave with implicit decode and the cheapest integrator: what the rest is built on.
fn implicit(settings: &mut Settings) {
    settings.coordination.decode = Decode::Implicit;
}

/// One solve of contact, law and object.
fn solved(settings: &mut Settings, integrator: IntegratorName) {
    implicit(settings);
    settings.object.integrator = integrator;
    settings.object.force_delay_ticks = 0.0;
}

fn encoder(settings: &mut Settings, velocity: VelocityName) {
    implicit(settings);
    settings.axis.velocity = velocity;
}

fn five_bar(settings: &mut Settings, maths: Maths) {
    encoder(settings, VelocityName::Difference);
    settings.axis.count = 2;
    settings.kinematics.model = KinematicsName::FiveBar;
    settings.kinematics.maths = maths;
}

const fn scene(name: &'static str, over: Option<&'static str>, adds: &'static str, change: fn(&mut Settings)) -> Scene {
    Scene { name, over, adds, change }
}

/// Every scene that is counted, each after the one it is compared with.
pub const SCENES: &[Scene] = &[
    scene("none", None, "one peer: contact, object, limits, duty", |s| s.coordination.comm = "none"),
    scene("power", Some("none"), "power-domain coordination", |s| {
        s.coordination.comm = "power";
        s.coordination.stiffness_n_per_m = 310.0;
    }),
    scene("wave", Some("none"), "wave-domain coordination, delayed decode", |s| s.coordination.comm = "wave"),
    scene("delayed-forward-euler", Some("wave"), "anti-aliasing filter (passive wave)", |_| {}),
    scene("delayed-semi-implicit", Some("delayed-forward-euler"), "semi-implicit instead of forward Euler", |s| {
        s.object.integrator = IntegratorName::SemiImplicit;
    }),
    scene("delayed-exact", Some("delayed-forward-euler"), "exact instead of forward Euler", |s| {
        s.object.integrator = IntegratorName::Exact;
    }),
    scene("implicit-forward-euler", Some("delayed-forward-euler"), "implicit instead of delayed decode", implicit),
    scene("implicit-semi-implicit", Some("implicit-forward-euler"), "semi-implicit instead of forward Euler", |s| {
        implicit(s);
        s.object.integrator = IntegratorName::SemiImplicit;
    }),
    scene("implicit-exact", Some("implicit-forward-euler"), "exact instead of forward Euler", |s| {
        implicit(s);
        s.object.integrator = IntegratorName::Exact;
    }),
    scene(
        "implicit-midpoint",
        Some("implicit-forward-euler"),
        "one solve of contact, law and object (midpoint)",
        |s| solved(s, IntegratorName::Midpoint),
    ),
    scene(
        "implicit-backward-euler",
        Some("implicit-midpoint"),
        "the same solve, forces as the tick ends (backward Euler)",
        |s| solved(s, IntegratorName::BackwardEuler),
    ),
    scene("passive-mean", Some("implicit-forward-euler"), "mean of a packet instead of the filter", |s| {
        implicit(s);
        s.coordination.comm = "passive-mean";
    }),
    scene("ledger", Some("passive-mean"), "energy ledger that pays for what comes in", |s| {
        implicit(s);
        (s.coordination.comm, s.coordination.ledger) = ("passive-mean", true);
    }),
    scene("drift-correction", Some("ledger"), "drift correction out of the ledger", |s| {
        implicit(s);
        (s.coordination.comm, s.coordination.ledger) = ("passive-mean", true);
        s.coordination.drift_correction = true;
    }),
    scene("self-timed", Some("implicit-midpoint"), "a line with a time of its own instead of the filter", |s| {
        solved(s, IntegratorName::Midpoint);
        s.coordination.comm = "self-timed";
    }),
    scene("self-timed-backward-euler", Some("self-timed"), "the same solve, forces as the tick ends", |s| {
        solved(s, IntegratorName::BackwardEuler);
        s.coordination.comm = "self-timed";
    }),
    scene("play", Some("implicit-forward-euler"), "contact with play to both sides", |s| {
        implicit(s);
        s.contact.gap_m = 0.002;
    }),
    scene("one-sided-gap", Some("implicit-forward-euler"), "one-sided contact with a gap", |s| {
        implicit(s);
        (s.contact.one_sided, s.contact.gap_m) = (true, 0.002);
    }),
    scene("encoder-difference", Some("implicit-forward-euler"), "encoder, velocity by difference", |s| {
        encoder(s, VelocityName::Difference);
    }),
    scene("encoder-filtered", Some("encoder-difference"), "filtered instead of plain difference", |s| {
        encoder(s, VelocityName::Filtered);
    }),
    scene("encoder-adaptive", Some("encoder-difference"), "adaptive window instead of difference", |s| {
        encoder(s, VelocityName::Adaptive);
    }),
    scene("capstan", Some("encoder-difference"), "capstan kinematics", |s| {
        encoder(s, VelocityName::Difference);
        s.kinematics.model = KinematicsName::Capstan;
    }),
    scene("two-axes", Some("implicit-forward-euler"), "second axis, held", |s| {
        implicit(s);
        s.axis.count = 2;
    }),
    scene("two-axes-encoder", Some("encoder-difference"), "second axis with its encoder, held", |s| {
        encoder(s, VelocityName::Difference);
        s.axis.count = 2;
    }),
    scene("five-bar-micromath", Some("two-axes-encoder"), "five-bar kinematics, micromath", |s| {
        five_bar(s, Maths::Micromath);
    }),
    scene("five-bar-libm", Some("two-axes-encoder"), "five-bar kinematics, libm", |s| five_bar(s, Maths::Libm)),
    scene("everything", Some("none"), "all: five-bar, adaptive, gap, implicit, exact", |s| {
        five_bar(s, Maths::Libm);
        s.axis.velocity = VelocityName::Adaptive;
        s.object.integrator = IntegratorName::Exact;
        (s.contact.one_sided, s.contact.gap_m) = (true, 0.002);
    }),
];

/// The scene of an image that names its law and carries no other.
pub const NAMED: Scene = scene("named-models", Some("delayed-forward-euler"), "models named at compile time", |_| {});

/// The settings of a peer where laws are compared: one solve a tick, and the gains that the law declares.
pub fn of_law(law: &LawInfo) -> Settings {
    let mut settings = Settings::default();
    solved(&mut settings, IntegratorName::Midpoint);
    settings.coordination.comm = law.name;
    for (key, value) in law.gains.iter().filter_map(|gain| gain.split_once('=')) {
        // A key of the world (a network's) is nothing that a peer is configured with.
        let _ = settings.set(key, Value::of_text(value));
    }
    settings
}
