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
//! | [`board`] | a board of this project, as the other peer of its sealed line |
//! | [`slow`] | what a program gives that asks a device in plain calls, 200 times a second at most |
//!
//! Another device is added by a name of its own ([`Adapter`]).

mod attached;
pub mod board;
pub mod slow;
pub mod steps;
pub mod threaded;

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use cohold_sim::device::{Device, DeviceFault};
use cohold_sim::{plant::Plant, scene::Scene};
use serde::Serialize;

use crate::Error;
use crate::quantiles::{Quantiles, Times};
pub use attached::Attached;
pub use cohold_core::settings::Settings;
pub use cohold_sim::device::Gone;
pub use threaded::{Threaded, stopped};

/// Axes of a device: none that is attached has more.
pub const AXES: usize = 3;
/// Buttons of a device, in the order of their bits.
pub const BUTTONS: [&str; 3] = ["a", "b", "c"];

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

    /// How it is, as far as it says; none where that is being written.
    fn health(&self) -> Option<Health> {
        Some(Health::default())
    }

    /// Says nothing at all to the device for so long, as a process that is killed would, and then asks it for the largest force or torque that
    /// acts, N or N·m; none if it does not say. For bring-up: this one blocks.
    ///
    /// # Errors
    /// It has stopped, or nobody can try this.
    fn stay_silent(&mut self, _time: Duration) -> Result<Option<f64>, Gone> {
        Err(Gone::new(DeviceFault::Stopped, "this adapter cannot fall silent to try it"))
    }
}

/// How a device is, as far as it says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Health {
    /// Least and largest supply voltage so far, V.
    pub supply_v: Option<[f64; 2]>,
    /// Largest temperature so far, °C.
    pub warmest_c: Option<f64>,
    /// Answers in which a motor gave less torque than it was asked for, by its own word.
    pub limited: u64,
}

/// What was seen of a device while a peer drove it.
#[derive(Clone, Debug, Serialize)]
pub struct DeviceReport {
    name: String,
    /// From asking to hearing, µs.
    round_trip: Quantiles,
    /// How long before its tick a reading was asked for, of every tick, µs: what lies between sensing and force where a command takes as long to
    /// get there as a question.
    age: Quantiles,
    /// How many round trips took up to so long, µs, and longer than the one before.
    histogram: Vec<(f64, u64)>,
    #[serde(flatten)]
    health: Health,
}

/// What is seen of a device while somebody drives it.
#[derive(Clone, Debug, Default)]
pub struct Seen(Arc<Mutex<SoFar>>);

#[derive(Debug, Default)]
struct SoFar {
    name: String,
    round_trips: Times,
    ages: Times,
    /// The newest ages, up to [`WINDOW`] of them, and what nine in ten did not exceed, µs.
    newest: Times,
    newest_us: Option<f64>,
    health: Health,
}

/// Ages that a delay is taken from: those of the last 1 to 4 s, and at the start of every 100 so far.
const WINDOW: u64 = 4_000;
const ENOUGH: u64 = 1_000;
const STEP: u64 = 100;
/// What an age may be above whole ticks, of a tick: the tick's own jitter.
const JITTER: f64 = 0.1;

impl Seen {
    fn name(&self, name: &str) {
        if let Ok(mut seen) = self.0.lock() {
            name.clone_into(&mut seen.name);
        }
    }

    /// A reading took so long, and that is how the device is.
    fn see(&self, took: Duration, health: Option<Health>) {
        // Nobody else holds it before the end.
        if let Ok(mut seen) = self.0.try_lock() {
            seen.round_trips.add(took.as_nanos() as u64);
            seen.health = health.unwrap_or(seen.health);
        }
    }

    /// A tick acts on a reading of this age.
    pub(crate) fn act(&self, age: Duration) {
        let Ok(mut seen) = self.0.try_lock() else { return };
        let age_ns = age.as_nanos() as u64;
        seen.ages.add(age_ns);
        seen.newest.add(age_ns);
        let (so_far, newest) = (seen.ages.samples(), seen.newest.samples());
        if newest % STEP == 0 && (newest >= ENOUGH || so_far == newest) {
            seen.newest_us = Some(seen.newest.quantiles().p90_us);
        }
        if newest == WINDOW {
            seen.newest.clear();
        }
    }

    /// Whole ticks of this period (s) from sensing to force, 1 at least, that nine in ten of the newest readings did not exceed; none before there
    /// were enough.
    pub fn delay_ticks(&self, period_s: f64) -> Option<u32> {
        let newest_us = self.0.lock().ok()?.newest_us?;
        Some((1e-6 * newest_us / period_s - JITTER).ceil().max(1.0) as u32)
    }

    /// As a report has it.
    pub fn report(&self) -> Option<DeviceReport> {
        let seen = self.0.lock().ok()?;
        let (name, times, health) = (seen.name.clone(), &seen.round_trips, seen.health);
        let (round_trip, age) = (times.quantiles(), seen.ages.quantiles());
        Some(DeviceReport { name, round_trip, age, histogram: times.histogram(), health })
    }
}

/// A device that a peer may drive, and what is seen of it; nothing of a simulated one.
pub type Opened<const N: usize> = (Box<dyn Device<f32, N>>, Option<Seen>);

/// Opens a device at a place, with what is told of it, for the peer of these settings.
pub type Opens = fn(at: &str, options: &DeviceOptions, peer: &Settings) -> Result<Box<dyn Port>, Error>;

/// What was found at a place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found {
    /// As `--device` takes it.
    pub device: String,
    /// What it says it is.
    pub what: String,
}

/// An adapter: it is opened with what stands after its name and a colon, and with what is told of the device.
#[derive(Clone, Copy, Debug)]
pub struct Adapter {
    /// As `--device` has it.
    pub name: &'static str,
    /// How a place stands behind the name: `:PLACE`, or `[:PLACE]` where there may be none.
    pub place: &'static str,
    /// Says why it cannot be opened there, or with what is told of it, as far as that is seen before anything is opened.
    pub check: fn(at: &str, options: &DeviceOptions) -> Result<(), String>,
    /// Opens it.
    pub open: Opens,
    /// Looks for such devices where they usually are, and at these places beside.
    pub look: fn(beside: &[String]) -> Vec<Found>,
}

/// Opens a device that a program in this process has, with what else is told of it.
#[derive(Clone)]
pub struct Own(pub Arc<Makes>);

/// Makes the port of such a device.
pub type Makes = dyn Fn(&DeviceOptions) -> Result<Box<dyn Port>, Error> + Send + Sync;

impl std::fmt::Debug for Own {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a device of the program")
    }
}

/// What a device can do; by default nothing that it may be armed with.
#[derive(Clone, Debug, Default, PartialEq)]
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
#[derive(Clone, Debug, Default)]
pub enum Kind {
    /// The scene's, simulated.
    #[default]
    Simulated,
    /// A board that was told so.
    Board(Box<board::Told>),
    /// That of an adapter, and where its device is.
    Adapted(Adapter, String),
    /// A device that a program in this process has.
    Own(Own),
}

/// The device that a peer is to have, and what is told about it.
#[derive(Clone, Debug)]
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
    /// How long a force of this device stands after the last command, s: as somebody has measured, for one that does not say; as it is
    /// told, for one that is.
    pub lets_go_s: Option<f64>,
    /// The button, from 0, that holds the clutch open.
    pub clutch: Option<usize>,
    /// Motors: the identifier of each joint's, and −1 of one that turns against its joint.
    pub motors: Vec<(u8, f64)>,
    /// Motors: the largest torque of each, N·m.
    pub max_torque_nm: Option<f64>,
    /// The motors' type.
    pub model: Option<String>,
    /// It is homed by somebody's word, for one that does not say.
    pub is_homed: bool,
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
            motors: vec![(1, 1.0)],
            max_torque_nm: None,
            model: None,
            is_homed: false,
        }
    }
}

impl DeviceOptions {
    /// The device of peer `number` (1 or 2) in its own frame; none if it is the scene's.
    ///
    /// # Errors
    /// It is not there, or not fit, and why.
    pub fn port(&self, scene: &Scene, number: u8) -> Result<Option<Box<dyn Port>>, Error> {
        let peers = scene.peers();
        let settings = &peers[usize::from(number == 2)];
        let silent = Duration::from_secs_f64(self.silent_s);
        Ok(Some(match &self.kind {
            Kind::Simulated => return Ok(None),
            Kind::Board(told) => board::open(told, silent)?,
            Kind::Adapted(adapter, at) => (adapter.open)(at, self, settings)?,
            Kind::Own(Own(make)) => make(self)?,
        }))
    }

    /// The device of peer `number` (1 or 2), ready to be driven along the axes of its scene.
    ///
    /// # Errors
    /// It is not there, not fit, or must not be armed in this scene, and why.
    pub fn open<const N: usize>(&self, scene: &Scene, number: u8) -> Result<Opened<N>, Error> {
        let index = usize::from(number == 2);
        let Some(port) = self.port(scene, number)? else { return Ok((Box::new(Plant::build(scene, index)), None)) };
        let seen = Seen::default();
        Ok((Box::new(Attached::new(port, self, scene, index)?.seen_by(seen.clone())), Some(seen)))
    }
}
