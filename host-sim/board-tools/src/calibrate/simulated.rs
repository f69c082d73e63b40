//! A board with a software device and a person at it: to practise calibration on, and to test it against a known truth.
//!
//! The device is what a scene says: its mass, friction, encoder and motor are the truth. The board starts with the defaults, as
//! a new one does, and runs the peer's own tick; its current loop, of `plant.drive = "current"`, has the gains that the board's settings say, whatever
//! the winding is. Of the operator's lines it knows those that calibration and bring-up need. The person does what is asked, exactly.

use std::{cell::RefCell, rc::Rc};

use cohold_core::device::motor::Duty;
use cohold_core::device::probe::{Probe, Request, Shape};
use cohold_core::device::{AXES, Reading};
use cohold_core::settings::{Choice, Settings, Value};
use cohold_core::{
    device::velocity::VelocityName,
    num::Motion,
    safety::{Command, Mode},
};
use cohold_sim::peers::{DynPeer, Laws};
use cohold_sim::plant::Plant;
use cohold_sim::scene::{DriveName, Scene};

use super::board::{Board, Joint, Tick};
use super::{Person, Task};
use crate::Error;
use crate::bringup::VOLTMETER;

/// The board and its device.
#[derive(Debug)]
pub struct Simulated {
    truth: Scene,
    plant: Plant,
    settings: Settings,
    /// What of them the peer runs.
    applied: Settings,
    peer: Box<dyn DynPeer<f32>>,
    tick: u32,
    every: u32,
    records: Vec<Tick>,
    /// Joints that passed the check before arming.
    passed: [bool; AXES],
    /// The gauge that the hand is held against: force on it, N.
    gauge_n: Option<f64>,
    stop_pressed: bool,
    stop: Stop,
    supply_v: f64,
    /// The stop was pressed while the motors were on.
    stopped: bool,
    /// Since the cable was pulled.
    silent_s: Option<f64>,
    /// The motors went off because of that.
    let_go: bool,
    /// What was commanded in the last ticks, A, newest first; and what flowed beside the largest of them.
    commanded_a: [f64; 4],
    currents: Currents,
}

/// What flowed through the first motor's winding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Currents {
    /// With the loop closed, largest |current| less 20 mA, for ripple within a PWM period and for noise, over the largest that was commanded in
    /// the tick before it and the three before that, or 0.1 A if that is more.
    pub closed: f64,
    /// With the loop open, by a voltage, A.
    pub open_a: f64,
}

/// The emergency stop, and what it cuts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Pressed, the first contact opens: the board sees it.
    pub first_opens: bool,
    /// Pressed, the second contact opens: the bridges have no supply.
    pub second_opens: bool,
    /// Time constant by which the supply then falls, s: 1000 µF and what empties them.
    pub falls_s: f64,
}

impl Default for Stop {
    fn default() -> Self {
        Self { first_opens: true, second_opens: true, falls_s: 2.2 }
    }
}

/// A [`Simulated`] that board and person share.
#[derive(Clone, Debug)]
pub struct SharedSimulation(Rc<RefCell<Simulated>>);

impl SharedSimulation {
    /// The device that `truth` describes, on a new board.
    ///
    /// # Errors
    /// The settings of `truth` cannot be built.
    pub fn new(truth: &Scene) -> Result<Self, Error> {
        let mut truth = truth.clone();
        truth.world.plant.encoder = true;
        truth.world.plant.motor = true;
        if truth.world.plant.drive == DriveName::Current {
            truth.world.plant.winding = true;
            truth.peer.axis.velocity = VelocityName::Filtered;
            truth.check("the device")?;
        }
        let mut settings = Settings::default();
        settings.axis.velocity = VelocityName::Filtered;
        settings.axis.count = truth.peer.axis.count;
        settings.kinematics = truth.peer.kinematics;
        let peer = Laws::built_in().peer(&settings, [Motion::REST; AXES])?;
        let simulated = Simulated {
            plant: plant(&truth, &truth, &settings)?,
            peer,
            settings,
            applied: settings,
            tick: 0,
            every: 0,
            records: Vec::new(),
            passed: [false; AXES],
            gauge_n: None,
            stop_pressed: false,
            stop: Stop::default(),
            supply_v: truth.world.plant.supply_v,
            stopped: false,
            silent_s: None,
            let_go: false,
            commanded_a: [0.0; 4],
            currents: Currents::default(),
            truth,
        };
        Ok(Self(Rc::new(RefCell::new(simulated))))
    }

    /// What the board has been given so far.
    pub fn settings(&self) -> Settings {
        self.0.borrow().settings
    }

    /// Another emergency stop.
    pub fn wire_stop(&self, stop: Stop) {
        self.0.borrow_mut().stop = stop;
    }

    /// Whether the motors are on.
    pub fn is_driven(&self) -> bool {
        matches!(self.0.borrow().peer.mode(), Mode::Armed | Mode::Probing)
    }

    /// What has flowed so far.
    pub fn currents(&self) -> Currents {
        self.0.borrow().currents
    }
}

/// A device, whose current loops know of the true one what the board was told.
fn plant(device: &Scene, truth: &Scene, told: &Settings) -> Result<Plant, Error> {
    let mut plant = Plant::new(device, 0);
    plant.tune(told, &truth.world.plant)?;
    Ok(plant)
}

impl Simulated {
    /// The board sees that the stop is pressed.
    fn sees_stop(&self) -> bool {
        self.stop_pressed && self.stop.first_opens
    }

    fn step(&mut self) {
        let full_v = self.truth.world.plant.supply_v;
        if self.stop_pressed && self.stop.second_opens {
            self.supply_v *= (-self.truth.peer.timing.control_period_s / self.stop.falls_s).exp();
            self.plant.set_supply(self.supply_v);
        } else if self.supply_v != full_v {
            self.supply_v = full_v;
            self.plant.set_supply(full_v);
        }
        if self.peer.mode() == Mode::Armed {
            let silent = self.silent_s.is_some_and(|silent_s| silent_s >= self.settings.safety.operator_lost_s);
            if self.sees_stop() || silent {
                self.peer.command(Command::Disarm);
                self.stopped |= self.sees_stop();
                self.let_go |= silent;
            }
        }
        if let Some(silent_s) = &mut self.silent_s {
            *silent_s += self.truth.peer.timing.control_period_s;
        }
        let sensors = self.plant.sensors::<f32>();
        let probing = self.peer.mode() == Mode::Probing;
        let actuators = self.peer.tick(&sensors);
        if probing && self.peer.mode() != Mode::Probing && self.peer.probed().check {
            let outcome = self.peer.probed();
            self.passed[outcome.joint as usize - 1] = outcome.passed();
        }
        self.tick += 1;
        if self.every > 0
            && self.tick.is_multiple_of(self.every)
            && let Reading::Counts(counts) = sensors.reading
        {
            let (mode, duties) = (self.peer.mode().number(), actuators.duties.map(|duty| duty.0));
            let counts = counts.map(|counts| counts.0);
            let at_m = self.peer.observed()[0].device.position;
            self.records.push(Tick { number: self.tick, mode, counts, duties, at_m, stage: sensors.stage });
        }
        let before = *self.plant.free_axis().0;
        self.plant.step(f64::from(self.tick) * self.truth.peer.timing.control_period_s, &actuators);
        self.see_current(actuators.open, f64::from(actuators.duties[0].0) / f64::from(Duty::FULL_SCALE));
        if let Some(gauge_n) = &mut self.gauge_n {
            let (motion, force) = self.plant.free_axis();
            *motion = before;
            // The last force that there was stays on the dial.
            *gauge_n = if *force == 0.0 { *gauge_n } else { *force };
        }
    }

    fn see_current(&mut self, open: bool, duty: f64) {
        const SMALL_A: f64 = 0.1;
        const RIPPLE_A: f64 = 0.02;
        let peak_a = self.plant.take_peaks_a()[0];
        self.commanded_a.rotate_right(1);
        self.commanded_a[0] = if open { 0.0 } else { (duty * self.applied.motor.full_scale_a).abs() };
        if open {
            self.currents.open_a = self.currents.open_a.max(peak_a);
        } else {
            let largest_a = self.commanded_a.iter().fold(SMALL_A, |most: f64, one| most.max(*one));
            self.currents.closed = self.currents.closed.max((peak_a - RIPPLE_A) / largest_a);
        }
    }

    fn steps(&mut self, seconds: f64) {
        let ticks = (seconds / self.truth.peer.timing.control_period_s).round() as u64;
        (0..ticks).for_each(|_| self.step());
    }

    /// Moves the device by hand.
    fn carry(&mut self, metres: f64) {
        const TICKS: u32 = 1000;
        for _ in 0..TICKS {
            let motion = self.plant.free_axis().0;
            *motion = Motion::at(motion.position + metres / f64::from(TICKS));
            self.step();
        }
        *self.plant.free_axis().0 = Motion::at(self.plant.motions()[0].position);
    }

    /// Another device at the board.
    fn replace(&mut self, device: &Scene) -> Result<(), Error> {
        self.plant = plant(device, &self.truth, &self.applied)?;
        self.peer = Laws::built_in().peer(&self.settings, [Motion::REST; AXES])?;
        Ok(())
    }

    fn begin(&mut self, probe: Result<Probe<f32>, cohold_core::settings::Refused<'static>>) -> String {
        match (self.peer.mode(), probe) {
            (_, Err(refused)) => format!("error {refused}"),
            (Mode::Disarmed, Ok(probe)) => {
                self.peer.probe(probe);
                format!("ok probing joint {} for {} ticks", probe.joint(), probe.ticks())
            }
            (mode, _) => format!("error {mode:?}"),
        }
    }

    fn answer(&mut self, line: &str) -> Option<String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        Some(match words.as_slice() {
            ["get", key] => format!("ok {key} = {}", self.settings.get(key)?),
            ["set", key, text] => match self.settings.set(key, Value::of_text(text)) {
                Ok(()) => format!("ok {key} = {text}"),
                Err(error) => format!("error {error:?}"),
            },
            ["apply"] => match Laws::built_in().peer(&self.settings, [Motion::REST; AXES]) {
                Ok(peer) if self.plant.tune(&self.settings, &self.truth.world.plant).is_ok() => {
                    let device = |settings: &Settings| (settings.encoder, settings.kinematics, settings.motor);
                    if device(&self.settings) != device(&self.applied) {
                        self.passed = [false; AXES];
                    }
                    self.applied = self.settings;
                    self.peer = peer;
                    "ok applied".to_owned()
                }
                Ok(_) => "error motor: no current loop has these settings".to_owned(),
                Err(refused) => format!("error {refused}"),
            },
            ["stream", every] => {
                self.every = every.parse().unwrap_or(0);
                format!("ok every {every} ticks")
            }
            ["check", joint] => self.begin(Probe::check(&self.settings, joint.parse().ok()?)),
            ["probe", joint, shape, duty, seconds, hertz @ ..] => self.begin(Probe::build(
                &self.settings,
                &Request {
                    joint: joint.parse().ok()?,
                    shape: Shape::from_name(shape)?,
                    duty: duty.parse().ok()?,
                    duration_s: seconds.parse().ok()?,
                    frequency_hz: hertz.first().map_or(Some(0.0), |hertz| hertz.parse().ok())?,
                },
            )),
            ["status"] => {
                let mode = self.peer.mode();
                let (mode, fault) = (mode.name(), mode.fault_number());
                let silent = if self.let_go { "; motors off: the operator was silent" } else { "" };
                format!("ok board 1 {mode} fault {fault} ticks {}{silent}", self.tick)
            }
            // It steps when time passes, and so is never late.
            ["time", _] => format!("ok cycles of 1 MHz: most 0 in tick 0; from:ticks 0:{}", self.tick),
            ["arm"] if self.stopped => "error clear first: the emergency stop was pressed".to_owned(),
            ["arm"] if self.sees_stop() => "error the emergency stop is pressed, or not connected".to_owned(),
            ["arm"] if self.passed.iter().take(self.applied.axis.count as usize).any(|passed| !passed) => {
                "error check first: the signs of motor and encoder were not checked, every joint in use".to_owned()
            }
            ["arm"] => {
                self.let_go = false;
                self.peer.command(Command::Arm);
                "ok armed".to_owned()
            }
            ["disarm"] => {
                self.peer.command(Command::Disarm);
                "ok disarmed".to_owned()
            }
            ["clear"] => {
                self.stopped = false;
                self.peer.command(Command::Clear);
                "ok disarmed".to_owned()
            }
            ["home"] if self.peer.mode() != Mode::Disarmed => "error home is for motors that are off".to_owned(),
            ["home"] => {
                self.peer.command(Command::Home);
                "ok home here".to_owned()
            }
            ["probed"] => format!("ok {}", self.peer.probed()),
            _ => return None,
        })
    }
}

impl Board for SharedSimulation {
    fn ask(&mut self, line: &str) -> Result<String, Error> {
        let mut simulated = self.0.borrow_mut();
        simulated.steps(0.002);
        cohold_sim::refuse_if!(simulated.silent_s.is_some(), "no answer: the cable is out");
        Ok(simulated.answer(line).unwrap_or_else(|| "error the simulated board does not know this line".to_owned()))
    }

    fn ticks(&mut self, seconds: f64) -> Result<Vec<Tick>, Error> {
        let mut simulated = self.0.borrow_mut();
        simulated.steps(seconds);
        Ok(std::mem::take(&mut simulated.records))
    }
}

impl Person for SharedSimulation {
    fn please(&mut self, task: &Task) -> Result<(), Error> {
        let mut simulated = self.0.borrow_mut();
        let Simulated { truth, .. } = &*simulated;
        let (kinematics, mut device) = (truth.peer.kinematics, truth.clone());
        match *task {
            Task::HoldStill { .. } => simulated.carry(0.0),
            Task::MoveMetres { metres, .. } => simulated.carry(metres),
            Task::Turn { revolutions, .. } => {
                // The paddle's way for so many turns of the motor.
                let radians = revolutions * std::f64::consts::TAU;
                simulated.carry(radians * kinematics.paddle_radius_m / kinematics.capstan_ratio);
            }
            Task::Gauge { .. } => simulated.gauge_n = Some(0.0),
            Task::LetGo { .. } => {
                simulated.gauge_n = None;
                simulated.steps(1.0);
            }
            Task::PassIndex { .. } => {
                let at_m = truth.peer.encoder.index_at_m_or_rad * Joint::of(&truth.peer, 1)?.lever;
                let way_m = at_m - simulated.plant.motions()[0].position;
                simulated.carry(way_m + 0.002);
                simulated.carry(-0.004);
            }
            Task::Push { metres, .. } => simulated.carry(metres),
            Task::PressStop | Task::ReleaseStop => {
                simulated.stop_pressed = *task == Task::PressStop;
                simulated.steps(0.01);
            }
            Task::PullCable => simulated.silent_s = Some(0.0),
            Task::PlugCable => simulated.silent_s = None,
            Task::SeeLight | Task::HoldButton | Task::LetGoOfButton => {}
            Task::Fasten { kilograms, .. } => {
                device.world.device.mass_kg += kilograms;
                simulated.replace(&device)?;
            }
            Task::Unfasten { .. } => simulated.replace(&device)?,
        }
        Ok(())
    }

    fn reading(&mut self, what: &str) -> Result<f64, Error> {
        let simulated = self.0.borrow();
        Ok(if what == VOLTMETER { simulated.supply_v } else { simulated.gauge_n.unwrap_or(0.0) })
    }
}
