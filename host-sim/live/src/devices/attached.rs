//! A device behind a [`Port`] as a peer reads and drives it.
//!
//! **Frames.** x of the scene's axis = start + ±(x_device − origin), then the scene's `scale`; a force goes the same way back. With the
//! origin where the device is first read, it begins where the scene's simulated one does, clear of the object.
//!
//! **Age.** A reading is as old as the moment it was asked for. From half of the silence that is allowed on the force fades, in proportion,
//! to nothing at its end; then the device is [`Gone`], and the motors are off. It does not come back by itself. A reading that says of a device
//! that it moves, faster than [`STILL_M_PER_S`] and with the very numbers of the one before, is that one, and as old: no device moves at one
//! place. A state that is frozen at rest looks like a hand at rest.
//!
//! **At rest** it has to be to begin: under [`STILL_M_PER_S`] for [`STILL`], within [`FIRST`]; and within `safety.workspace_m` of its origin.
//!
//! **A jump** further than [`safety::fastest_m_per_s`] allows in the time between two readings, and 2 mm, is no motion of a hand.
//!
//! **Not armed at all** is a device that is not homed, whose own time to let go is not known, that has fewer axes than the scene uses, or
//! that gives less force than the scene may ask for.

use std::array::from_fn;
use std::time::{Duration, Instant};

use cohold_core::device::Reading;
use cohold_core::num::Motion;
use cohold_core::peer::{Actuators, Sensors};
use cohold_core::safety;
use cohold_core::settings::Scale;
use cohold_sim::device::{Device, DeviceFault, Gone};
use cohold_sim::scene::Scene;

use super::{AXES, Abilities, DeviceOptions, Port, Seen, Sensed};
use crate::Error;

/// How long a device may take to be read for the first time, and to come to rest.
const FIRST: Duration = Duration::from_secs(5);
/// What is slower than this for so long is at rest: hands tremble.
const STILL_M_PER_S: f64 = 0.05;
const STILL: Duration = Duration::from_millis(100);
/// What a place may be off by between two readings beside what the device moves, m.
const SLACK_M: f64 = 2e-3;

/// A device that a peer reads and drives.
pub struct Attached<const N: usize> {
    port: Box<dyn Port>,
    axes: [(usize, f64); N],
    /// Where the origin of the device is on the scene's axes, m.
    start_m: [f64; N],
    origin_m: [f64; AXES],
    scale: Scale,
    silent: Duration,
    fastest_m_per_s: f64,
    clutch: u8,
    newest: Sensed,
    /// When this end last looked.
    looked: Option<Instant>,
    /// Share of the force that is left of it, from the age of the newest reading.
    share: f64,
    seen: Option<Seen>,
}

/// Why this device must not be armed in this scene, if so.
fn refusal(can: &Abilities, options: &DeviceOptions, scene: &Scene, index: usize) -> Option<String> {
    let settings = &scene.peers()[index];
    let (name, used) = (&can.name, settings.axis.count as usize);
    let safety = &settings.safety;
    if !can.is_homed {
        return Some(format!("{name} is not calibrated: it must be before it may be armed"));
    }
    if can.lets_go_s.is_none() {
        return Some(format!(
            "nobody knows how long {name} holds a force after the last command: measure it (docs/guides/devices/index.md) and say so, or it is not armed"
        ));
    }
    if options.axes[..used.min(AXES)].iter().any(|(axis, _)| *axis >= can.axes) {
        return Some(format!(
            "{name} has {} axes; the scene uses {used} (axis.count), and they are mapped to others",
            can.axes
        ));
    }
    if let Some(most_n) = can.max_force_n.filter(|most_n| *most_n < safety.max_force_n) {
        let (number, asked_n) = (index + 1, safety.max_force_n);
        return Some(format!(
            "{name} gives {most_n} N at most, and the scene may ask for {asked_n} N: set peer.{number}.safety.max_force_n={most_n}"
        ));
    }
    let mapped = options.axes.iter().take(used);
    let narrow = can.workspace_m.and_then(|reach_m| mapped.map(|(axis, _)| reach_m[*axis]).reduce(f64::min));
    narrow
        .filter(|reach_m| *reach_m < safety.workspace_m)
        .map(|reach_m| format!("{name} reaches {reach_m} m: set peer.{}.safety.workspace_m to that or less", index + 1))
}

/// How fast it moves along the axis along which it is fastest.
fn speed_m_per_s(sensed: &Sensed) -> f64 {
    sensed.velocity_m_per_s.iter().fold(0.0, |most, speed| most.max(speed.abs()))
}

/// The reading of a device once it is at rest, with its motors off.
fn at_rest(port: &mut dyn Port) -> Result<Sensed, Error> {
    let by = Instant::now() + FIRST;
    let (mut newest, mut still_since) = (None, None);
    loop {
        port.write(None);
        newest = port.read().map_err(|gone| gone.to_string())?.or(newest);
        let now = Instant::now();
        if let Some(sensed) = newest {
            still_since = (speed_m_per_s(&sensed) < STILL_M_PER_S).then(|| still_since.unwrap_or(now));
            if still_since.is_some_and(|since| now >= since + STILL) {
                return Ok(sensed);
            }
        }
        if now >= by {
            let name = &port.abilities().name;
            let why = if newest.is_none() { "has told no place" } else { "is not at rest: hold it still" };
            return Err(format!("{name} {why}").into());
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

impl<const N: usize> Attached<N> {
    /// This device as peer `index` (0 or 1) of a scene has it, once it has been read.
    ///
    /// # Errors
    /// It must not be armed, or was not read in time.
    pub fn new(mut port: Box<dyn Port>, options: &DeviceOptions, scene: &Scene, index: usize) -> Result<Self, Error> {
        if let Some(why) = refusal(port.abilities(), options, scene, index) {
            return Err(why.into());
        }
        let newest = at_rest(&mut *port)?;
        let peers = scene.peers();
        let settings = &peers[index];
        let (name, reach_m) = (&port.abilities().name, settings.safety.workspace_m);
        let used = || options.axes.iter().take(settings.axis.count as usize);
        if let Some(origin_m) = options.origin_m
            && let Some((axis, _)) =
                used().find(|(axis, _)| (newest.position_m[*axis] - origin_m[*axis]).abs() > reach_m)
        {
            let off_m = newest.position_m[*axis] - origin_m[*axis];
            return Err(format!(
                "{name} is {off_m:.3} m from its origin, and may be {reach_m} m from it (safety.workspace_m)"
            )
            .into());
        }
        let clutch = options.clutch.map_or(0, |button| 1 << button);
        Ok(Self {
            port,
            axes: from_fn(|axis| options.axes[axis]),
            start_m: scene.start::<N>(index).map(|motion| motion.position),
            origin_m: options.origin_m.unwrap_or(newest.position_m),
            scale: settings.scale,
            silent: Duration::from_secs_f64(options.silent_s),
            fastest_m_per_s: safety::fastest_m_per_s(settings),
            clutch,
            newest,
            share: 0.0,
            looked: None,
            seen: None,
        })
    }

    /// This device; what is seen of it is kept there too.
    #[must_use]
    pub fn seen_by(self, seen: Seen) -> Self {
        seen.name(&self.port.abilities().name);
        Self { seen: Some(seen), ..self }
    }

    /// Takes in a reading.
    fn take(&mut self, sensed: Sensed) -> Result<(), Gone> {
        let implausible = |cause: String| Err(Gone::new(DeviceFault::Implausible, cause));
        let used = || self.axes.iter().map(|(axis, _)| *axis);
        if used().any(|axis| !(sensed.position_m[axis].is_finite() && sensed.velocity_m_per_s[axis].is_finite())) {
            return implausible("a place or a speed is not a number".to_owned());
        }
        let told = |of: &Sensed| (of.position_m, of.velocity_m_per_s);
        if told(&sensed) == told(&self.newest) && speed_m_per_s(&sensed) > STILL_M_PER_S {
            self.newest.buttons = sensed.buttons;
            return Ok(());
        }
        let took = sensed.between[1].saturating_duration_since(self.newest.between[0]);
        let allowed_m = SLACK_M + self.fastest_m_per_s * took.as_secs_f64();
        let moved_m = used().map(|axis| (sensed.position_m[axis] - self.newest.position_m[axis]).abs());
        let moved_m = moved_m.fold(0.0, f64::max);
        if moved_m > allowed_m {
            let (moved_mm, ms) = (1e3 * moved_m, 1e3 * took.as_secs_f64());
            return implausible(format!("it moved by {moved_mm:.1} mm in {ms:.1} ms"));
        }
        if let Some(seen) = self.seen.as_ref().filter(|_| sensed.between != self.newest.between) {
            seen.see(sensed.between[1].saturating_duration_since(sensed.between[0]), self.port.health());
        }
        self.newest = sensed;
        Ok(())
    }

    /// The fault, with what the milliseconds are of, where a time is longer than readings may be old.
    fn within(&self, time: Duration, fault: DeviceFault, of: impl FnOnce(String) -> String) -> Result<(), Gone> {
        if time <= self.silent {
            return Ok(());
        }
        let [ms, allowed] = [time, self.silent].map(|time| format!("{:.0}", 1e3 * time.as_secs_f64()));
        Err(Gone::new(fault, format!("{}, of {allowed} allowed", of(ms))))
    }
}

/// What is left of a force at this age of the reading that it is from.
fn share(age: Duration, silent: Duration) -> f64 {
    (2.0 * (1.0 - age.as_secs_f64() / silent.as_secs_f64())).clamp(0.0, 1.0)
}

impl<const N: usize> Device<f32, N> for Attached<N> {
    fn look(&mut self) -> Result<(), Gone> {
        // An end that stood still would go on with a fresh reading and with forces of before, at a device that has let go meanwhile.
        let before = self.looked.replace(Instant::now());
        let stood = before.map_or(Duration::ZERO, |before| before.elapsed());
        self.within(stood, DeviceFault::LetGo, |ms| format!("this end stood still for {ms} ms"))?;
        if let Some(sensed) = self.port.read()? {
            self.take(sensed)?;
        }
        let age = self.newest.between[0].elapsed();
        self.share = share(age, self.silent);
        self.seen.iter().for_each(|seen| seen.act(age));
        let name = &self.port.abilities().name;
        self.within(age, DeviceFault::Silent, |ms| format!("the newest reading of {name} is {ms} ms old"))
    }

    fn sensors(&self) -> Sensors<f32, N> {
        Sensors::of(Reading::Exact(from_fn(|at| {
            let (axis, sign) = self.axes[at];
            let along_m = self.start_m[at] + sign * (self.newest.position_m[axis] - self.origin_m[axis]);
            Motion {
                position: (self.scale.position * along_m) as f32,
                velocity: (self.scale.position * sign * self.newest.velocity_m_per_s[axis]) as f32,
            }
        })))
    }

    fn step(&mut self, _: f64, actuators: &Actuators<f32, N>) {
        let share = self.share / self.scale.force;
        let force_n = actuators.enable.then(|| {
            let mut force_n = [0.0; AXES];
            for ((axis, sign), force) in self.axes.iter().zip(actuators.forces) {
                force_n[*axis] += sign * share * f64::from(force);
            }
            force_n
        });
        self.port.write(force_n);
    }

    fn idle(&mut self) {
        self.port.write(None);
    }

    fn clutches(&self, _: f64) -> bool {
        self.newest.buttons & self.clutch != 0
    }
}

#[cfg(test)]
#[path = "../../tests/inside/attached.rs"]
mod tests;
