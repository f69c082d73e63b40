//! Devices that are not there: each speaks its public protocol on the real transport, has a mechanism and a hand behind it, a watchdog of its
//! own, and faults that can be planted. Whoever has no device attaches one of these; the adapters are tested against them.
//!
//! | module | is |
//! |---|---|
//! | [`inverse3`] | Haply's service with an Inverse3: WebSocket and JSON |
//! | [`moteus`] | two moteus motors with a five-bar |
//! | [`mit`] | two Damiao motors that take MIT's frame, likewise |
//! | [`carrier`] | the ways to a bus: an fdcanusb on a pseudo-terminal, a Unix socket that carries the kernel's frames, a CAN interface |
//! | [`motors`] | what both kinds of motors share: linkage, hand and watchdog |
//! | [`hand`] | the hand that holds the handle |
//! | [`asked`] | what was asked of a device |
//!
//! **Independent.** Nothing here knows a peer, its adapters or its kinematics, so that a mistake there is not made here too: registers and frames
//! are read byte for byte, the five-bar is inverse kinematics and virtual work. What a hand does is said from outside ([`hand::Task`]).
//!
//! **Not modelled**: what no public documentation says (how long an Inverse3 holds a force is invented), gravity, friction, the mass of links,
//! the time that a bus takes.

use std::sync::{Mutex, MutexGuard};

pub mod asked;
#[cfg(unix)]
pub mod carrier;
pub mod hand;
pub mod inverse3;
#[cfg(target_os = "linux")]
mod kernel;
#[cfg(unix)]
pub mod mit;
#[cfg(unix)]
pub mod moteus;
#[cfg(unix)]
pub mod motors;

/// What is seen of an emulated device.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// Since it began, s.
    pub time_s: f64,
    /// Where the hand is along each axis of the device, m.
    pub place_m: Vec<f64>,
    /// What the device pushes the hand with, N.
    pub force_n: Vec<f64>,
    /// Forces or torques that were asked for so far.
    pub orders: u64,
    /// When one that was not zero was asked for last, s.
    pub last_push_s: Option<f64>,
}

/// An emulated device of any kind, while it serves; whoever drops it lets its place go.
pub trait Emulated {
    /// The words by which `cohold` opens it.
    fn words(&self) -> Vec<String>;

    /// Plants the fault of this name, `none` to end one; when, s. None where it has no fault of that name.
    fn plant(&self, fault: &str) -> Option<f64>;

    /// How it is now.
    fn look(&self) -> Seen;
}

/// The fault of a kind of device that has this name.
fn named<F: Copy>(faults: &[(&str, F)], name: &str) -> Option<F> {
    faults.iter().find(|(known, _)| *known == name).map(|(_, fault)| *fault)
}

/// The world of an emulator, which goes on in a thread of its own: only a test that fails while it holds it leaves it as it should not be.
fn locked<W>(world: &Mutex<W>) -> MutexGuard<'_, W> {
    world.lock().expect("the emulator goes on")
}
