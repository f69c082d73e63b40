//! What stands at a peer where a board has its encoders and bridges: a simulated plant, or what somebody attaches.
//!
//! Whoever steps a peer ([`crate::Pair`], or a node behind a sealed link) does so by [`Device`] alone. In memory a device is stepped in virtual
//! time and never fails. One that is really there goes on by itself: it is asked once a tick for what it has told by now
//! ([`Device::look`]), and may be [`Gone`]. No method blocks; who has to wait, for a socket or a bus, does so in a thread of its own.

use cohold_core::device::{AXES, Reading};
use cohold_core::num::{Motion, Scalar};
use cohold_core::numbered;
use cohold_core::peer::{Actuators, Sensors};

numbered! {
    /// Why a device that is really there must not be driven. The numbers go on where those of a peer's own faults
    /// ([`cohold_core::safety::Fault`]) end, and are never reused either.
    pub enum DeviceFault {
        23 Silent: "the device said nothing new for too long",
        24 Stopped: "the device stopped, or its socket or bus is closed",
        25 Implausible: "the device told a place that it cannot have come to, or that is not a number",
        26 Motor: "a motor of the device reports a fault of its own",
        27 TooWarm: "a motor of the device, or its driver, is too warm",
        28 Supply: "the supply voltage of a motor of the device is too low or too high",
        29 LetGo: "the device's own watchdog let go: it heard nothing from this end for too long",
        30 Singular: "the hand is where the motors of the device cannot push it along every axis",
    }
}

/// Why a device is driven no more, until the program is started again.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("fault {}: {}: {cause}", *fault as u8, fault.explain())]
pub struct Gone {
    /// What is wrong.
    pub fault: DeviceFault,
    /// What was seen of it.
    pub cause: String,
}

impl Gone {
    /// For this reason, with what was seen of it.
    pub fn new(fault: DeviceFault, cause: impl ToString) -> Self {
        Self { fault, cause: cause.to_string() }
    }
}

/// A device that a peer reads and drives: a simulated plant, several side by side in lanes, or a caller's own.
///
/// Lengths, speeds and forces are of the shared world ([`cohold_core::device::scale`]): m, m/s, N.
pub trait Device<S: Scalar, const N: usize = AXES> {
    /// Takes what the device has told by now; a node asks at every tick, armed or not, before it reads. Never blocks.
    ///
    /// # Errors
    /// It must not be driven any more, and why: the motors go off in this tick.
    fn look(&mut self) -> Result<(), Gone> {
        Ok(())
    }
    /// Readings of the peer's sensors now.
    fn sensors(&self) -> Sensors<S, N>;
    /// Moves the device by one control period from `time_s` (s) on, under the forces or duties that the peer commands.
    fn step(&mut self, time_s: f64, actuators: &Actuators<S, N>);
    /// [`Device::step`] of an armed peer that waits for the other one to begin: a simulated hand does nothing yet.
    fn wait(&mut self, actuators: &Actuators<S, N>) {
        self.step(0.0, actuators);
    }
    /// A control period of a peer that is not armed: a simulated device stands still, one that is really there lets go.
    fn idle(&mut self) {}
    /// Whether the clutch is held open at `time_s`.
    fn clutches(&self, _time_s: f64) -> bool {
        false
    }
    /// Where each axis is now, for who looks on, m and m/s: what the sensors say, or zero with encoders.
    fn motions(&self) -> [Motion<f64>; N] {
        match self.sensors().reading {
            Reading::Exact(axes) => axes.map(|axis| Motion::new(axis.position.to_f64(), axis.velocity.to_f64())),
            Reading::Counts(_) => [Motion::REST; N],
        }
    }
    /// Lets other forces act beside the simulated user's from the next tick on: along each axis, N toward positive x, y, z. A device that is
    /// really there has a hand of its own.
    fn pull(&mut self, _forces_n: [f64; N]) {}
    /// Motion of each axis before the first tick, at rest: as the sensors read, or zero with encoders.
    fn start(&self) -> [Motion<S>; N] {
        match self.sensors().reading {
            Reading::Exact(axes) => axes.map(|axis| Motion::at(axis.position)),
            Reading::Counts(_) => [Motion::REST; N],
        }
    }
    /// Force of a wall in the device's own room that is known to push it, N; 0 without one.
    fn wall_n(&self) -> f64 {
        0.0
    }
}
