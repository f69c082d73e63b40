//! The way in for a device that is really there, in place of the simulated one of a live peer.
//!
//! An adapter is a [`Port`]: read gives where the hand is and when that was, write takes a force, and what the device can do is asked
//! ([`Abilities`]). It knows nothing of scenes, peers or laws. [`Attached`] makes of a port what a peer drives: axes, origin and scale,
//! what happens when readings grow old, and who may not be armed at all. What is told about one's own device (`--device-…`) is in no table of
//! the scene: the other peer's device may be another one.
//!
//! | adapter | what it speaks to |
//! |---|---|
//! | none | the scene's simulated device, which a peer has by default |
//! | [`haply`] | an Inverse3 behind Haply's local WebSocket service, 3.5 or newer |

mod attached;
pub mod haply;

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use haptic_sim::device::{Device, Gone};
use haptic_sim::{plant::Plant, scene::Scene};

use crate::Error;
pub use attached::Attached;

/// Axes of a device: none that is attached has more.
pub const AXES: usize = 3;

/// A device of up to [`AXES`] axes in SI units of its own frame. Neither method blocks: who must wait does so in a thread of its own.
/// Whoever is dropped lets go first.
pub trait Port {
    /// What it can do, as it said itself.
    fn abilities(&self) -> &Abilities;

    /// The newest that it has told; none before the first.
    ///
    /// # Errors
    /// It has stopped, is no longer calibrated, or its line is closed.
    fn read(&mut self) -> Result<Option<Sensed>, Gone>;

    /// The force of this tick along each of its axes, N; none lets go.
    fn write(&mut self, force_n: Option<[f64; AXES]>);
}

/// What a device can do.
#[derive(Clone, Debug, PartialEq)]
pub struct Abilities {
    /// Who it is, for people.
    pub name: String,
    /// Number of axes that it senses and drives, 1 to [`AXES`].
    pub axes: usize,
    /// Largest distance along each axis between two places that it reaches, m; none if it does not say.
    pub workspace_m: Option<[f64; AXES]>,
    /// Largest force along an axis, N; none if it does not say.
    pub max_force_n: Option<f64>,
    /// Its positions are of its own frame, and not of where it was switched on.
    pub is_homed: bool,
    /// Number of buttons.
    pub buttons: usize,
    /// How long after the last force it lets go by itself, s; none if it never does, or if nobody knows.
    pub lets_go_s: Option<f64>,
}

/// Where a device was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensed {
    /// Along each axis, m.
    pub position_m: [f64; AXES],
    /// Along each axis, m/s.
    pub velocity_m_per_s: [f64; AXES],
    /// Earliest time that it may have been there, and the latest: when it was asked, and when it was heard.
    pub between: [Instant; 2],
    /// Buttons that are down, a bit for each.
    pub buttons: u8,
}

/// What kind of device a peer has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// The scene's, simulated.
    #[default]
    Simulated,
    /// An Inverse3, whose service listens there.
    Haply(SocketAddr),
}

/// The device that a peer is to have, and what is told about it.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceOptions {
    /// What kind.
    pub kind: Kind,
    /// Which one of several; the first without it.
    pub id: Option<String>,
    /// Axis of the device, from 0, that each axis of the scene is, and +1 or −1 where it points the other way.
    pub axes: [(usize, f64); AXES],
    /// Where the scene's start is in the device's frame, m; without it where the device is first read.
    pub origin_m: Option<[f64; AXES]>,
    /// A reading may be this old, s.
    pub silent_s: f64,
    /// How long a force of this device stands after the last command, as somebody has measured, s: for one that does not say.
    pub lets_go_s: Option<f64>,
    /// The button, from 0, that holds the clutch open.
    pub clutch: Option<usize>,
}

impl Default for DeviceOptions {
    fn default() -> Self {
        Self {
            kind: Kind::default(),
            id: None,
            axes: [(0, 1.0), (1, 1.0), (2, 1.0)],
            origin_m: None,
            silent_s: 0.05,
            lets_go_s: None,
            clutch: None,
        }
    }
}

impl DeviceOptions {
    /// The device of peer `number` (1 or 2), ready to be driven along the axes of its scene.
    ///
    /// # Errors
    /// It is not there, not fit, or must not be armed in this scene, and why.
    pub fn open<const N: usize>(&self, scene: &Scene, number: u8) -> Result<Box<dyn Device<f32, N>>, Error> {
        let index = usize::from(number == 2);
        let Kind::Haply(at) = self.kind else { return Ok(Box::new(Plant::build(scene, index))) };
        let silent = Duration::from_secs_f64(self.silent_s);
        let port = haply::Haply::open(at, self.id.as_deref(), self.lets_go_s, silent)?;
        Ok(Box::new(Attached::new(port, self, scene, index)?))
    }
}
