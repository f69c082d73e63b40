//! What the users do: forces on their devices, N, positive **toward the other peer**.
//!
//! The cooperation paper's profiles (§5: a steady push, pulses, a sine), any CSV trace, and a person: a minimum-jerk
//! reach with tremor, pulled through the impedance of an arm. All of them add up. Forces are sampled at the start of a
//! tick and held for it; the arm's impedance belongs to the plant and acts continuously ([`crate::plant`]).

use std::path::{Path, PathBuf};

use cohold_core::settings::number;
use cohold_io::Most;

use crate::Error;

cohold_core::settings! {
    /// The settings of a user, apart from a trace.
    pub struct UserSettings;

    /// Profile of one user: forces on the device, a reach through the arm, a wall in the room, and the clutch.
    user: Profile {
        push_n: f64 = 0.0, number(-1000.0, 1000.0), "N", "Steady push.";
        pulse_n: f64 = 0.0, number(-1000.0, 1000.0), "N", "Height of a pulse, repeated from time 0.";
        pulse_s: f64 = 0.025, number(0.0, 1e6), "s", "Length of a pulse.";
        pulse_every_s: f64 = 2.5, number(1e-3, 1e6), "s", "Time from one pulse to the next.";
        sine_n: f64 = 0.0, number(-1000.0, 1000.0), "N", "Amplitude of a sine.";
        sine_rad_per_s: f64 = 3.0, number(0.0, 1e4), "rad/s", "Angular frequency of the sine.";
        side_push_n: f64 = 0.0, number(-100.0, 100.0), "N", "Push along every axis but the first.";
        direction_rad: f64 = 0.0, number(-6.3, 6.3), "rad",
            "Where the user's forces and reaches point, from the first axis toward the second; peer 2's point the opposite way.";
        elevation_rad: f64 = 0.0, number(-1.6, 1.6), "rad", "And up from there, toward the third axis.";
        arm_stiffness_n_per_m: f64 = 0.0, number(0.0, 1e4), "N/m",
            "Stiffness of the arm that pulls the device to where the user wants it; 0 is no arm.";
        arm_damping_n_s_per_m: f64 = 0.0, number(0.0, 1e3), "N·s/m", "Damping of the arm.";
        arm_mass_kg: f64 = 0.0, number(0.0, 100.0), "kg", "Mass of the arm that moves with the device.";
        reach_m: f64 = 0.0, number(-1.0, 1.0), "m",
            "Distance of a minimum-jerk reach toward the other peer, through the arm.";
        reach_s: f64 = 1.0, number(0.01, 1e4), "s", "Duration of the reach.";
        tremor_m: f64 = 0.0, number(0.0, 0.1), "m", "Amplitude of the tremor of the reach.";
        tremor_hz: f64 = 9.0, number(0.0, 100.0), "Hz", "Frequency of the tremor.";
        wall_m: f64 = 0.0, number(-10.0, 10.0), "m",
            "How far away from the other peer the device meets a wall, as a follower's tool does.";
        wall_stiffness_n_per_m: f64 = 0.0, number(0.0, 1e6), "N/m", "Stiffness of that wall; 0 is none.";
        wall_damping_n_s_per_m: f64 = 0.0, number(0.0, 1e4), "N·s/m", "Damping of that wall.";
        clutch_at_s: f64 = 0.0, number(0.0, 1e6), "s", "When the user opens the clutch for the first time.";
        clutch_for_s: f64 = 0.0, number(0.0, 1e6), "s", "How long it then stays open; 0 is never opened.";
        clutch_every_s: f64 = 1e6, number(1e-3, 1e6), "s", "Time from one opening to the next.";
    }
}

/// Largest file of a force or network trace that is read: 128 MiB.
pub const TRACE: Most = Most::new(1 << 27, "a trace");

/// A simulated user: the profile of forces and arm, and a recorded force.
#[derive(Clone, Debug, Default)]
pub struct User {
    /// Forces, arm, wall and clutch of the user.
    pub settings: UserSettings,
    /// A recorded force, if any.
    pub trace: Option<Trace>,
}

impl User {
    /// Whether the user ever does anything.
    pub fn acts(&self) -> bool {
        let profile = &self.settings.user;
        let has_arm = profile.arm_stiffness_n_per_m != 0.0 || profile.arm_damping_n_s_per_m != 0.0;
        let forces = [profile.push_n, profile.pulse_n, profile.sine_n, profile.side_push_n];
        let reaches = [profile.reach_m, profile.tremor_m];
        self.trace.is_some() || forces.iter().any(|n| *n != 0.0) || has_arm && reaches.iter().any(|m| *m != 0.0)
    }

    /// Whether there is a wall in the room of the device.
    pub fn has_wall(&self) -> bool {
        self.settings.user.wall_stiffness_n_per_m > 0.0
    }

    /// Whether the clutch is held open at `time_s`.
    pub fn clutches(&self, time_s: f64) -> bool {
        let user = &self.settings.user;
        let since_s = time_s - user.clutch_at_s + 1e-9;
        // Asked of every tick, and mostly of users without one: the remainder comes last.
        user.clutch_for_s > 0.0 && since_s >= 0.0 && since_s % user.clutch_every_s < user.clutch_for_s
    }

    /// Force at `time_s`, N toward the other peer.
    #[inline]
    pub fn force_n(&self, time_s: f64) -> f64 {
        let user = &self.settings.user;
        let mut force = user.push_n;
        // A nanosecond forward: 2.5 s in ticks of 1 ms must not fall a rounding short of the next pulse.
        if user.pulse_n != 0.0 && (time_s + 1e-9) % user.pulse_every_s < user.pulse_s {
            force += user.pulse_n;
        }
        if user.sine_n != 0.0 {
            force += user.sine_n * libm::sin(user.sine_rad_per_s * time_s);
        }
        if let Some(trace) = &self.trace {
            force += trace.force_n(time_s);
        }
        force
    }

    /// The most that the user ever pushes with, by hand and arm, N.
    pub fn most_n(&self) -> f64 {
        let user = &self.settings.user;
        let traced =
            self.trace.iter().flat_map(|trace| &trace.samples).fold(0.0, |most, (_, n)| f64::max(most, n.abs()));
        let arm = user.arm_stiffness_n_per_m * (user.reach_m.abs() + user.tremor_m);
        let pushes = [user.push_n, user.pulse_n, user.sine_n, user.side_push_n];
        pushes.iter().map(|n| n.abs()).sum::<f64>() + traced + arm
    }

    /// The direction of what the user does, as parts along the axes; exactly the first one where no key says otherwise.
    pub fn direction(&self) -> [f64; 3] {
        let (sine, cosine) = libm::sincos(self.settings.user.direction_rad);
        let (up, level) = libm::sincos(self.settings.user.elevation_rad);
        [cosine * level, sine * level, up]
    }

    /// Where the arm wants the device (m) and how fast it wants it there (m/s), toward the other peer: a reach of minimum
    /// jerk with a sinusoidal tremor on top.
    pub fn wanted(&self, time_s: f64) -> (f64, f64) {
        let user = &self.settings.user;
        let (position, velocity) = minimum_jerk(user.reach_m, user.reach_s, time_s);
        let angular = core::f64::consts::TAU * user.tremor_hz;
        let (sine, cosine) = libm::sincos(angular * time_s);
        (position + user.tremor_m * sine, velocity + user.tremor_m * angular * cosine)
    }
}

/// Position (m) and velocity (m/s) after `time_s` of a reach over `distance_m` that takes `duration_s`, of minimum jerk:
/// x = d·(10s³ − 15s⁴ + 6s⁵), s = t/T up to 1 (Flash & Hogan 1985).
pub fn minimum_jerk(distance_m: f64, duration_s: f64, time_s: f64) -> (f64, f64) {
    let s = (time_s / duration_s).min(1.0);
    let position = distance_m * s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
    (position, distance_m / duration_s * 30.0 * s * s * (1.0 - s) * (1.0 - s))
}

/// A force recorded over time, interpolated linearly, constant before its first and after its last sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// The file it was read from; empty for none.
    pub file: PathBuf,
    samples: Vec<(f64, f64)>,
}

impl Trace {
    /// Reads a CSV file with the header `time_s,force_n` and increasing times.
    ///
    /// # Errors
    /// The file cannot be read, or the first row that is wrong.
    pub fn read(file: &Path) -> Result<Self, Error> {
        let path = file.display();
        let read = Error::cannot::<csv::Error>("read", &path);
        let bytes = cohold_io::read(file, TRACE).map_err(Error::cannot("read", &path))?;
        let mut reader = csv::ReaderBuilder::new().flexible(true).trim(csv::Trim::All).from_reader(bytes.as_slice());
        let header = reader.headers().map_err(&read)?;
        if *header != ["time_s", "force_n"][..] {
            return Err(Error::at(&path, "the first line must be time_s,force_n"));
        }
        let mut samples: Vec<(f64, f64)> = Vec::new();
        for (row, record) in (1..).zip(reader.records()) {
            let wrong = |what: &str| Error::at(&path, format!("row {row}: {what}"));
            let record = record.map_err(&read)?;
            let numbers: Option<Vec<f64>> =
                record.iter().map(|field| field.parse().ok().filter(|number: &f64| number.is_finite())).collect();
            match numbers.as_deref() {
                Some(&[time_s, _]) if samples.last().is_some_and(|last| last.0 >= time_s) => {
                    return Err(wrong(&format!("time {time_s} s is not after the row before")));
                }
                Some(&[time_s, force_n]) => samples.push((time_s, force_n)),
                // Not what it is: a scene of somebody else's may name any file of whoever runs it.
                _ => return Err(wrong("expected a time and a force as two finite numbers")),
            }
        }
        if samples.is_empty() {
            return Err(Error::at(&path, "no samples"));
        }
        Ok(Self { file: std::path::absolute(file).unwrap_or_else(|_| file.to_owned()), samples })
    }

    /// A straight line from 0 N at 0 s to `force_n` at `until_s`.
    pub fn line(until_s: f64, force_n: f64) -> Self {
        Self { file: PathBuf::default(), samples: vec![(0.0, 0.0), (until_s, force_n)] }
    }

    /// No force before `at_s` (s), then `force_n` (N).
    pub fn step(at_s: f64, force_n: f64) -> Self {
        Self { file: PathBuf::default(), samples: vec![(at_s, 0.0), (at_s, force_n)] }
    }

    /// Force at `time_s`, N.
    pub fn force_n(&self, time_s: f64) -> f64 {
        let after = self.samples.partition_point(|sample| sample.0 <= time_s);
        match (after.checked_sub(1).map(|at| self.samples[at]), self.samples.get(after)) {
            (Some((t0, f0)), Some(&(t1, f1))) => f0 + (f1 - f0) * (time_s - t0) / (t1 - t0),
            (Some((_, force)), None) | (None, Some(&(_, force))) => force,
            (None, None) => 0.0,
        }
    }
}
