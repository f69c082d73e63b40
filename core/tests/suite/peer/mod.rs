//! A peer through its entries alone: what makes it stop, what makes it start again, and what its forces do meanwhile.

mod at_device;
mod backward_euler;
mod clutch;
mod encoders;
mod envelope;
mod fixture;
mod letting_go;
mod limits;
mod midpoint;
mod parting;
mod safety;
mod scale;
mod self_timed;
mod shared;
mod silence;
mod stage;

use cohold_core::device::Reading;
use cohold_core::law::AnyLaw;
use cohold_core::num::{Motion, Scalar};
use cohold_core::peer::{Actuators, Peer, Sensors};
use cohold_core::safety::Command;
use cohold_core::settings::Settings;

/// A peer without device or network.
struct Bench<S: Scalar> {
    peer: Peer<S, AnyLaw<S>>,
}

impl<S: Scalar> Bench<S> {
    /// Disarmed, its device here.
    fn at_rest(settings: &Settings, device: Motion<S>) -> Self {
        Self { peer: Peer::new(settings, [device, Motion::REST]).expect("a good scene") }
    }

    /// Armed, its device at the origin.
    fn armed(settings: &Settings) -> Self {
        let mut bench = Self::at_rest(settings, Motion::REST);
        bench.command(Command::Arm);
        bench
    }

    fn command(&mut self, command: Command) {
        self.peer.command(command);
    }

    /// A tick with this reading.
    fn read(&mut self, reading: Reading<S>) -> Actuators<S> {
        self.peer.tick(&Sensors::of(reading))
    }

    /// A tick with the device here, moving like this.
    fn at(&mut self, position: S, velocity: S) -> Actuators<S> {
        self.read(Reading::Exact([Motion { position, velocity }, Motion::REST]))
    }
}
