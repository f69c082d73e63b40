//! A picture with a scene of its own: two simulated hands on one object, and one setting that a person moves.
//!
//! The peers are those of a pair ([`super::session`]). The hands are the scene's users; a person's hand is added to them, and a partner is
//! nobody's. When a peer has faulted everything stands as it was; another setting starts it anew, as *Start* does.

use cohold_sim::{AXES, Laws, scene::Scene, scenes};

use super::environment::{Command, Environment, Sample, Standing};
use super::partner::Model;
use super::session::Session;
use cohold_cli::Failure;

/// A scene, and what it is called with.
pub(super) type Told = (&'static str, &'static [&'static str]);

/// Both pull with 1.5 N, one of them now more and now less, over the recommended law, whose line is not taut here: how far apart the copies
/// then are is nearly proportional to the delay. A person's arm holds each device.
pub(super) const DELAY: Told = (
    "any-network",
    &[
        "coordination.tautness=0",
        "network.one_way_delay_packets=0",
        "network.extra_delay_s=0.06",
        "user.1.push_n=-1.5",
        "user.2.push_n=-1.5",
        "user.2.sine_n=0.4",
        "user.2.sine_rad_per_s=2",
        "user.1.arm_stiffness_n_per_m=20",
        "user.2.arm_stiffness_n_per_m=20",
        "user.1.arm_damping_n_s_per_m=1",
        "user.2.arm_damping_n_s_per_m=1",
    ],
);

/// The cooperation paper's §5.2 in the power domain, whose coupling is stable at 310 N/m and a round trip of 16 ms; arms hold the devices
/// about the middle.
pub(super) const TOO_STIFF: Told =
    ("paper-5.2-power-16ms", &["user.1.arm_stiffness_n_per_m=10", "user.2.arm_stiffness_n_per_m=10"]);

/// The scene of a story.
pub(super) fn scene(laws: Laws, (name, keys): &Told) -> Result<Scene, Failure> {
    let mut scene = scenes::load(laws, name)?;
    keys.iter().try_for_each(|text| scene.apply_override(text))?;
    scene.check("this story")?;
    Ok(scene)
}

/// Two peers with simulated hands.
pub(super) struct Story {
    session: Session<1, AXES>,
    model: Model,
}

impl Story {
    /// Both at rest, in this scene.
    pub(super) fn new(scene: &Scene) -> Result<Self, Failure> {
        scene.check_one_axis("this story")?;
        Ok(Self { session: Session::new(scene.clone(), Model::Absent)?, model: Model::default() })
    }
}

impl Environment for Story {
    fn command(&mut self, command: Command) -> Result<(), Failure> {
        if let Command::Partner(model) = command {
            self.model = model;
            return Ok(());
        }
        self.session.command(command)
    }

    fn set(&mut self, scene: Scene) -> Result<(), Failure> {
        let faulted = self.session.fault().is_some();
        self.session.set(scene)?;
        if faulted { self.session.command(Command::Start) } else { Ok(()) }
    }

    fn point(&mut self, hand: usize, at: Option<[f64; 3]>, restarts: u32) {
        self.session.point(hand, at, restarts);
    }

    fn step(&mut self) -> Result<Sample, Failure> {
        self.session.step()
    }

    fn stands(&self) -> bool {
        self.session.stands()
    }

    fn standing(&self) -> Standing {
        Standing { partner: self.model.number(), ..self.session.standing() }
    }
}

#[cfg(test)]
#[path = "../tests/inside/story.rs"]
mod tests;
