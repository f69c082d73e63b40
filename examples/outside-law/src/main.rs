//! A coordination law from outside: the paper's power-domain law, with the remote copy carried on along its velocity.
//!
//! The law, its name and its own key are the first part of this file; the last lines give it to every command of cohold:
//!
//! ```text
//! cargo run -- cooperate --set coordination.comm=predict
//! cargo run -- stability limit --of coordination.stiffness_n_per_m --from 0 --to 2000 --set coordination.comm=predict
//! cargo run -- stability point --set coordination.comm=predict --set predict.ahead_s=0.01
//! cargo run -- study networks
//! ```
//!
//! In cohold-core or cohold-laws the same law would be this file and a line in each list that has it.

use cohold_core::configured;
use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Spring};
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::Solve;
use cohold_core::settings::{Key, Refused, Settings};

/// Name, default, range, unit and meaning: scene files, `--set`, `--keys`, sweeps and error messages go by this.
const AHEAD: Key =
    Key::number("predict.ahead_s", 0.008, [0.0, 0.2], "s").means("How far the remote copy is carried on.");

/// A spring to where the remote copy will be.
#[derive(Clone, Copy, Debug)]
struct Predict<S> {
    spring: Spring<S>,
    ahead: S,
}

configured!([S: Scalar] Predict<S> { spring, ahead });

impl<S: Scalar> Law<S> for Predict<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "predict",
        keys: &[AHEAD],
        gains: &["coordination.stiffness_n_per_m=310"],
        ..LawInfo::MOTION
    }];
    /// The remote copy's motion, carried on.
    type State = Motion<S>;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self { spring: Spring::build(settings), ahead: S::from_f64(settings.own(&AHEAD)) })
    }

    fn start(&self, local: Motion<S>) -> Motion<S> {
        local
    }

    fn receive(&self, desired: &mut Motion<S>, packet: Packet<S>) {
        let Motion { position, velocity } = packet.motion;
        *desired = Motion { position: position + self.ahead * velocity, velocity };
    }

    fn couple(&self, desired: &mut Motion<S>, seen: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        Coupled::toward(*desired, self.spring.force(*desired, seen.local, solve))
    }

    fn send(&self, _: &Motion<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, ..Packet::default() }
    }
}

/// The law in every number type.
struct Outside;

impl cohold_sim::Family for Outside {
    type Of<S: Scalar> = Predict<S>;
}

fn main() -> std::process::ExitCode {
    cohold::command_line().with_laws(|laws| laws.with::<Outside>()).main()
}
