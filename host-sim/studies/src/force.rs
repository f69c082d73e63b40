//! Is the force that is commanded the force that is felt? One motor with its winding, behind an open-loop duty and in the current loop.
//!
//! A hand moves the joint as it likes, ±50 mm at 1 Hz ([`HAND_M`], [`HAND_HZ`]) or not at all, while the tick commands forces that have
//! nothing to do with that. Force is the mean over a control period, which is what a mass feels; the command is what the tick held
//! through it. Errors are root mean squares over two seconds, after half a second.
//!
//! **The two errors of a loop.** Against the command itself, and against the command as late as the loop says it is
//! ([`Scene::force_delay_ticks`]), so much of this tick's and the rest of the tick's before: what a delay makes is the analyser's to bound,
//! the rest is error of the force.
//!
//! **Open loop** is calibrated: full duty is taken for what the supply drives through the cold winding at rest.
//!
//! What the delay costs is the stiffest contact that is stable: `cohold stability limit --of contact.stiffness_n_per_m`.
//!
//! Units: N, Hz, degrees, N/m. Not in it: friction, cogging, an encoder.

use std::f64::consts::{PI, SQRT_2, TAU};

use cohold_core::device::current::{PWM_PERIOD_S, periods_per_tick};
use cohold_core::device::kinematics::KinematicsName;
use cohold_core::device::motor::Motor;
use cohold_report::Columns;
use cohold_sim::plant::Drive;
use cohold_sim::scene::{DriveName, Scene};
use rayon::prelude::*;

use super::Error;
use super::accuracy::rms;

/// How far the hand goes, m.
pub const HAND_M: f64 = 0.05;
/// Frequency of the hand's motion, Hz.
pub const HAND_HZ: f64 = 1.0;
/// What the loop is held to up to [`BAND_HZ`]: this share of the command,
pub const SHARE: f64 = 0.03;
/// The least error that the loop is held to, N.
pub const FLOOR_N: f64 = 0.02;
/// Highest frequency of the band, Hz.
pub const BAND_HZ: f64 = 100.0;
/// Frequencies of the response, Hz.
const RESPONSE_HZ: [f64; 9] = [1.0, 3.0, 10.0, 20.0, 50.0, 100.0, 200.0, 300.0, 400.0];
/// Before the first second that counts, and how long is counted, s: whole cycles of every whole frequency.
const SETTLE_S: f64 = 0.5;
const COUNTED_S: f64 = 2.0;

/// A force that is commanded over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// A force that is constant over time.
    Constant,
    /// A sine of one frequency, Hz.
    Sine(f64),
    /// Twenty-five sines of the same size from 0 to [`BAND_HZ`], so out of step that their peaks do not meet (Schroeder 1970).
    Band,
}

impl Command {
    /// Force at a time, N, whose root mean square over a second is 1.
    fn at(self, time_s: f64) -> f64 {
        const SINES: u32 = 25;
        match self {
            Self::Constant => 1.0,
            Self::Sine(hz) => SQRT_2 * (TAU * hz * time_s).sin(),
            Self::Band => (1..=SINES).map(f64::from).fold(0.0, |sum, sine| {
                let (hz, phase) = (sine / f64::from(SINES) * BAND_HZ, PI * sine * sine / f64::from(SINES));
                sum + (2.0 / f64::from(SINES)).sqrt() * (TAU * hz * time_s + phase).sin()
            }),
        }
    }

    /// The command in words.
    fn label(self) -> String {
        match self {
            Self::Constant => "constant".into(),
            Self::Sine(hz) => format!("{hz:.0} Hz"),
            Self::Band => format!("0-{BAND_HZ:.0} Hz, 25 sines"),
        }
    }
}

/// What one drive made of one command.
#[derive(Clone, Copy, Debug)]
pub struct DriveResponse {
    /// Root mean square of what is wrong with the force, N.
    pub error_n: f64,
    /// Root mean square of the error against the command as late as the drive says it is, N.
    pub delayed_error_n: f64,
    /// Gain of the force over the held command, at the command's frequency.
    pub gain: f64,
    /// Degrees; negative is late.
    pub phase: f64,
}

/// One command, made by both.
#[derive(Clone, Debug)]
pub struct Row {
    /// The command that both made.
    pub command: Command,
    /// Its root mean square, N.
    pub command_n: f64,
    /// The duty is a share of the supply.
    pub open: DriveResponse,
    /// The duty is the reference of the current loop.
    pub closed: DriveResponse,
}

impl Row {
    /// The most that may be wrong, N.
    pub fn allowed_n(&self) -> f64 {
        SHARE * self.command_n + FLOOR_N
    }
}

/// The response with the joint held, and errors with the hand moving.
#[derive(Clone, Debug)]
pub struct Force {
    /// One row a frequency.
    pub response: Vec<Row>,
    /// One row a command.
    pub moving: Vec<Row>,
    /// Control periods that the loop is late.
    pub delay_ticks: f64,
}

impl Force {
    /// Whether the force of the loop is right, but for its delay, in every row with the hand moving.
    pub fn within(&self) -> bool {
        self.moving.iter().all(|row| row.closed.delayed_error_n <= row.allowed_n())
    }

    /// The highest frequency of the response, the hand moving, up to which it is right in time as well, Hz.
    pub fn in_time_hz(&self) -> f64 {
        let sines = self.moving.iter().filter_map(|row| match row.command {
            Command::Sine(hz) => Some((hz, row.closed.error_n <= row.allowed_n())),
            _ => None,
        });
        sines.take_while(|(_, right)| *right).map(|(hz, _)| hz).last().unwrap_or(0.0)
    }
}

/// Measures the motor of a scene at commands of this size, N.
///
/// # Errors
/// The scene's device has no slides; a current loop that core refuses.
pub fn measure(scene: &Scene, command_n: f64) -> Result<Force, Error> {
    if scene.peer.kinematics.model != KinematicsName::Direct {
        return Err("kinematics.model must be \"direct\" here: the hand moves a slide".into());
    }
    let drives = [DriveName::Voltage, DriveName::Current].map(|drive| {
        let mut scene = scene.clone();
        let plant = &mut scene.world.plant;
        (plant.motor, plant.winding, plant.drive) = (true, true, drive);
        if drive == DriveName::Voltage {
            scene.peer.motor.full_scale_a = plant.supply_v / scene.peer.motor.resistance_ohm;
        }
        scene
    });
    drives.iter().try_for_each(|scene| scene.check("accuracy force"))?;
    let rows = |commands: Vec<(Command, f64)>, hand_m: f64| {
        let row = |(command, command_n): (Command, f64)| {
            let [open, closed] = [0, 1].map(|at: usize| run(&drives[at], command, command_n, hand_m));
            Ok(Row { command, command_n, open: open?, closed: closed? })
        };
        commands.into_par_iter().map(row).collect::<Result<Vec<_>, Error>>()
    };
    let sines = || RESPONSE_HZ.map(|hz| (Command::Sine(hz), command_n)).into_iter();
    let in_band = sines().filter(|(command, _)| !matches!(command, Command::Sine(hz) if *hz > BAND_HZ));
    let steady = [(Command::Constant, 0.0), (Command::Constant, command_n)].into_iter();
    let band = [(Command::Band, command_n), (Command::Band, THEORY_N)];
    Ok(Force {
        response: rows(sines().collect(), 0.0)?,
        moving: rows(steady.chain(in_band).chain(band).collect(), HAND_M)?,
        delay_ticks: drives[1].force_delay_ticks(),
    })
}

/// The command of THEORY §10, N.
const THEORY_N: f64 = 0.42;

/// One command of this root mean square (N) on a joint that moves by this (m).
fn run(scene: &Scene, command: Command, command_n: f64, hand_m: f64) -> Result<DriveResponse, Error> {
    let (settings, period_s) = (&scene.peer, scene.peer.timing.control_period_s);
    let motor = Motor::<f64>::build(settings);
    let mut drive = Drive::new(settings, &scene.world.plant, u64::from(scene.world.network.seed))?;
    let periods = periods_per_tick(settings)?;
    let [settle, counted] = [SETTLE_S, COUNTED_S].map(|seconds| (seconds / period_s).round() as u32);
    let late = if scene.world.plant.drive == DriveName::Current { scene.force_delay_ticks() } else { 0.0 };
    let position = |time_s: f64| hand_m * (TAU * HAND_HZ * time_s).sin();
    let omega = if let Command::Sine(hz) = command { TAU * hz } else { 0.0 };
    let (mut errors, mut before_n) = (Vec::new(), 0.0);
    // Real and imaginary part at the command's frequency, of what was held and of what came.
    let mut phasors = [[0.0; 2]; 2];
    for tick in 0..settle + counted {
        let time_s = f64::from(tick) * period_s;
        let wanted_n = command_n * command.at(time_s);
        drive.command(motor.duty(wanted_n).0, (position(time_s) - position(time_s - period_s)) / period_s);
        let mut mean_n = 0.0;
        for period in 0..periods {
            let middle_s = time_s + (f64::from(period) + 0.5) * PWM_PERIOD_S;
            let speed = hand_m * TAU * HAND_HZ * (TAU * HAND_HZ * middle_s).cos();
            let force_n = drive.period(speed);
            mean_n += force_n / f64::from(periods);
            if tick >= settle {
                let (sin, cos) = (omega * middle_s).sin_cos();
                for (phasor, force_n) in phasors.iter_mut().zip([wanted_n, force_n]) {
                    *phasor = [phasor[0] + force_n * sin, phasor[1] + force_n * cos];
                }
            }
        }
        if tick >= settle {
            errors.push([mean_n - wanted_n, mean_n - (1.0 - late) * wanted_n - late * before_n]);
        }
        before_n = wanted_n;
    }
    let [held, came] = phasors.map(|[sin, cos]| (sin.hypot(cos), cos.atan2(sin).to_degrees()));
    Ok(DriveResponse {
        error_n: rms(errors.iter().map(|error| error[0])),
        delayed_error_n: rms(errors.iter().map(|error| error[1])),
        gain: came.0 / held.0,
        phase: (came.1 - held.1 + 540.0).rem_euclid(360.0) - 180.0,
    })
}

/// The response, one row a frequency.
pub fn response_columns(rows: &[Row]) -> Columns {
    let share = |made: f64, row: &Row| 100.0 * made / row.command_n;
    Columns::of(rows)
        .value("command", |row| row.command.label())
        .means("what is commanded: constant, a sine, a band of noise")
        .number("open.gain", 3, |row| row.open.gain)
        .means("force over command with an open-loop duty")
        .number("open.phase_deg", 1, |row| row.open.phase)
        .means("phase of the force less that of the command, open loop")
        .number("loop.gain", 3, |row| row.closed.gain)
        .means("force over command with the current loop")
        .number("loop.phase_deg", 1, |row| row.closed.phase)
        .means("phase of the force less that of the command, current loop")
        .number("open.error_percent", 1, move |row| share(row.open.error_n, row))
        .means("error of the force, of the command, open loop")
        .number("loop.error_percent", 1, move |row| share(row.closed.error_n, row))
        .means("error of the force, of the command, current loop")
        .number("loop.late_error_percent", 1, move |row| share(row.closed.delayed_error_n, row))
        .means("the same against the command as late as the loop is")
        .done()
}

/// Errors with the hand moving, one row a command.
pub fn moving_columns(rows: &[Row]) -> Columns {
    Columns::of(rows)
        .value("command", |row| row.command.label())
        .means("what is commanded: constant, a sine, a band of noise")
        .number("command_n", 2, |row| row.command_n)
        .means("root mean square of the command")
        .number("open.error_n", 3, |row| row.open.error_n)
        .means("root mean square error of the force, open loop")
        .number("loop.error_n", 3, |row| row.closed.error_n)
        .means("root mean square error of the force, current loop")
        .number("loop.late_error_n", 3, |row| row.closed.delayed_error_n)
        .means("the same against the command as late as the loop is")
        .number("allowed_n", 3, |row| row.allowed_n())
        .means("the most that may be wrong")
        .done()
}
