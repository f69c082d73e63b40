//! Scenes whose ticks are counted, each with the scene that it adds something to.
//!
//! The table that comes of it: [the cost per scene](../../cost/index.html).

use cohold_core::device::kinematics::{KinematicsName, Maths};
use cohold_core::device::velocity::VelocityName::{Adaptive, Difference, Filtered};
use cohold_core::law::wave::Decode;
use cohold_core::object::IntegratorName::{BackwardEuler, Exact, Midpoint, SemiImplicit};
use cohold_core::schema::Schema;
use cohold_core::settings::{LawInfo, Settings, Value};

/// A scene that is counted.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Name; `tick/NAME` is its case.
    pub name: &'static str,
    /// The scene it is compared with.
    pub over: Option<&'static str>,
    /// What it has that the other has not, in words.
    pub adds: &'static str,
    /// What it changes of the other's settings, or of the defaults.
    change: fn(&mut Settings),
}

impl Scene {
    /// The settings of a peer of this scene.
    pub fn settings(&self) -> Settings {
        let over = SCENES.iter().find(|scene| self.over == Some(scene.name));
        let mut settings = over.map_or_else(Settings::default, Self::settings);
        (self.change)(&mut settings);
        settings
    }
}

const fn scene(name: &'static str, over: &'static str, adds: &'static str, change: fn(&mut Settings)) -> Scene {
    Scene { name, over: Some(over), adds, change }
}

/// Every scene that is counted, each after the one it is compared with.
pub const SCENES: &[Scene] = &[
    Scene {
        name: "none",
        over: None,
        adds: "one peer: contact, object, limits, duty",
        change: |s| {
            s.coordination.comm = "none";
            s.coordination.stiffness_n_per_m = 1590.0;
        },
    },
    scene("power", "none", "power-domain coordination", |s| {
        s.coordination.comm = "power";
        s.coordination.stiffness_n_per_m = 310.0;
    }),
    scene("wave", "none", "wave-domain coordination, delayed decode", |s| s.coordination.comm = "wave"),
    scene("delayed-forward-euler", "wave", "anti-aliasing filter (passive wave)", |s| {
        s.coordination.comm = "passive-wave"
    }),
    scene("delayed-semi-implicit", "delayed-forward-euler", "semi-implicit instead of forward Euler", |s| {
        s.object.integrator = SemiImplicit
    }),
    scene("delayed-exact", "delayed-forward-euler", "exact instead of forward Euler", |s| s.object.integrator = Exact),
    scene("implicit-forward-euler", "delayed-forward-euler", "implicit instead of delayed decode", |s| {
        s.coordination.decode = Decode::Implicit
    }),
    scene("implicit-semi-implicit", "implicit-forward-euler", "semi-implicit instead of forward Euler", |s| {
        s.object.integrator = SemiImplicit
    }),
    scene("implicit-exact", "implicit-forward-euler", "exact instead of forward Euler", |s| {
        s.object.integrator = Exact
    }),
    scene("implicit-midpoint", "implicit-forward-euler", "one solve of contact, law and object (midpoint)", |s| {
        s.object.integrator = Midpoint;
        s.object.force_delay_ticks = 0.0;
    }),
    scene(
        "implicit-backward-euler",
        "implicit-midpoint",
        "the same solve, forces as the tick ends (backward Euler)",
        |s| s.object.integrator = BackwardEuler,
    ),
    scene("passive-mean", "implicit-forward-euler", "mean of a packet instead of the filter", |s| {
        s.coordination.comm = "passive-mean"
    }),
    scene("ledger", "passive-mean", "energy ledger that pays for what comes in", |s| s.coordination.ledger = true),
    scene("drift-correction", "ledger", "drift correction out of the ledger", |s| {
        s.coordination.drift_correction = true
    }),
    scene("self-timed", "implicit-midpoint", "a line with a time of its own instead of the filter", |s| {
        s.coordination.comm = "self-timed"
    }),
    scene("self-timed-backward-euler", "self-timed", "the same solve, forces as the tick ends", |s| {
        s.object.integrator = BackwardEuler
    }),
    scene("play", "implicit-forward-euler", "contact with play to both sides", |s| s.contact.gap_m = 0.002),
    scene("one-sided-gap", "implicit-forward-euler", "one-sided contact with a gap", |s| {
        s.contact.one_sided = true;
        s.contact.gap_m = 0.002;
    }),
    scene("encoder-difference", "implicit-forward-euler", "encoder, velocity by difference", |s| {
        s.axis.velocity = Difference
    }),
    scene("encoder-filtered", "encoder-difference", "filtered instead of plain difference", |s| {
        s.axis.velocity = Filtered
    }),
    scene("encoder-adaptive", "encoder-difference", "adaptive window instead of difference", |s| {
        s.axis.velocity = Adaptive
    }),
    scene("capstan", "encoder-difference", "capstan kinematics", |s| s.kinematics.model = KinematicsName::Capstan),
    scene("two-axes", "implicit-forward-euler", "second axis, held", |s| s.axis.count = 2),
    scene("two-axes-encoder", "encoder-difference", "second axis with its encoder, held", |s| s.axis.count = 2),
    scene("five-bar-micromath", "two-axes-encoder", "five-bar kinematics, micromath", |s| {
        s.kinematics.model = KinematicsName::FiveBar;
        s.kinematics.maths = Maths::Micromath;
    }),
    scene("five-bar-libm", "two-axes-encoder", "five-bar kinematics, libm", |s| {
        s.kinematics.model = KinematicsName::FiveBar;
        s.kinematics.maths = Maths::Libm;
    }),
    scene("everything", "none", "all: five-bar, adaptive, gap, implicit, exact", |s| {
        (s.coordination.comm, s.coordination.decode) = ("passive-wave", Decode::Implicit);
        (s.axis.count, s.axis.velocity) = (2, Adaptive);
        (s.kinematics.model, s.kinematics.maths) = (KinematicsName::FiveBar, Maths::Libm);
        s.object.integrator = Exact;
        (s.contact.one_sided, s.contact.gap_m) = (true, 0.002);
    }),
];

/// The scene of an image that names its law and carries no other.
pub const NAMED: Scene = scene("named-models", "delayed-forward-euler", "models named at compile time", |_| {});

/// The settings of a peer where laws are compared: one solve a tick, and the gains that the law, one of a list, declares.
pub fn of_law(law: &LawInfo, laws: &'static [LawInfo]) -> Settings {
    let mut settings = Settings::default();
    settings.coordination.decode = Decode::Implicit;
    (settings.object.integrator, settings.object.force_delay_ticks) = (Midpoint, 0.0);
    settings.coordination.comm = law.name;
    for (key, value) in law.gains.iter().filter_map(|gain| gain.split_once('=')) {
        // A key of the world (a network's) is nothing that a peer is configured with.
        let _ = Schema::new(laws).set(&mut settings, key, Value::of_text(value));
    }
    settings
}
