//! What turns a duty into a motor's current: a bridge alone, or core's current loop around it.
//!
//! One [`Drive`] a joint. The tick says [`Drive::command`] once, then [`Drive::period`] runs as often as there are PWM periods in a
//! control period; a virtual board's power stage, whose voltage comes from its timer, calls what that calls ([`Drive::flow`]).
//!
//! **Time**: what the tick computes is there when its first PWM period ends. The bridge alone takes it for the second; the loop
//! compares it with the current that the second period begins with, and the voltage that comes of it acts in the third.
//!
//! **Samples**: at the start of each period and in its middle. The sensor rides on the first leg and is wrong for a while after each of its
//! edges ([`SETTLES_S`]). Of the two samples the loop takes the one that is farther from them, as the board does.
//! After a negative voltage that is the older one, of the middle.
//!
//! Off, a bridge lets go: the current is gone at once. [`Drive::fail`] breaks one of motor, bridge and sensor.

use cohold_core::device::current::{Controller, CurrentLoop, Gains, PWM_PERIOD_S, Sensor};
use cohold_core::device::motor::Duty;
use cohold_core::device::stage::{self, Measured};
use cohold_core::settings::{Refused, Settings};

use super::winding::{Flow, Winding};
use crate::rng::Rng;
use crate::scene::{DriveName, PlantFault, PlantSettings};

/// Supply of the current sensor's amplifier and of the converter, V, and what the amplifier reaches at either end (TI SBOS808E, INA240).
const SUPPLY_V: f64 = 3.3;
const AMPLIFIER_V: [f64; 2] = [0.05, SUPPLY_V - 0.2];

/// Share of the supply that a bridge gives which conducts although it is off.
const LEAKS: f64 = 0.2;

/// The analogue-to-digital converter that reads a motor's current, with its noise.
#[derive(Clone, Debug)]
pub struct Converter {
    /// Steps of either half.
    half: f64,
    sense_a: f64,
    noise_a: f64,
    zero_a: f64,
    rng: Rng,
}

impl Converter {
    /// As `motor.sense_a` and the table `plant` say; its noise is a stream of its own for each seed.
    pub fn new(settings: &Settings, plant: &PlantSettings, seed: u64) -> Self {
        Self {
            half: f64::from(1_u32 << (plant.current_bits - 1)),
            sense_a: settings.motor.sense_a,
            noise_a: plant.current_noise_a,
            zero_a: plant.current_zero_a,
            rng: Rng::new(seed),
        }
    }

    /// Reading of the converter at this current (A).
    pub fn read(&mut self, current_a: f64) -> u16 {
        let noise_a = if self.noise_a > 0.0 { self.noise_a * self.rng.normal() } else { 0.0 };
        let steps = self.half + (current_a + self.zero_a + noise_a) / self.sense_a * self.half;
        let [least, most] = AMPLIFIER_V.map(|volts| volts / SUPPLY_V * 2.0 * self.half);
        // At most 16 bits.
        steps.round().clamp(least, most) as u16
    }
}

/// Core's loop around a bridge.
#[derive(Clone, Debug)]
struct Closed {
    design: CurrentLoop,
    gains: Gains,
    controller: Controller,
    sensor: Sensor,
    converter: Converter,
    supply_mv: u32,
    /// Since the last command: sums of what was read (codes) and given (counts), the last that was read, and of how many.
    codes: i32,
    volts: i32,
    last: i32,
    periods: i32,
    /// What was read in the middle of the period before.
    middle: u16,
}

impl Closed {
    /// Another tick's periods begin.
    fn begin(&mut self) {
        (self.codes, self.volts, self.periods) = (0, 0, 0);
    }

    /// Means of the periods since.
    fn flow(&self) -> Option<stage::Flow> {
        (self.periods > 0).then(|| stage::Flow::of(self.codes, self.volts, self.last, self.periods))
    }
}

/// What the power stage of a device measured since the last tick; none without a current loop.
pub(super) fn measured<const N: usize>(drives: &[Drive; N], supply_counts: u16) -> Option<Measured<N>> {
    let flows = drives.each_ref().map(Drive::measured);
    if flows.iter().any(Option::is_none) {
        return None;
    }
    let supply_mv = (1e3 * drives.first()?.winding.supply_v).round() as u16;
    Some(Measured { motors: flows.map(Option::unwrap_or_default), supply_mv, supply_counts, thermistor: 0 })
}

/// What a tick wants of a drive.
#[derive(Clone, Copy, Debug)]
enum Order {
    /// A current, and the back-EMF that is expected, counts.
    Current(Duty, i32),
    /// A voltage, as a share of the supply.
    Voltage(Duty),
}

/// The order for zero current.
const OFF: Order = Order::Current(Duty::OFF, 0);
/// How long the sensor is wrong after an edge of its leg, s: TI gives 9.6 to 9.8 µs until an INA240 is within 0.5 % (e2e.ti.com 796955).
const SETTLES_S: f64 = 9.8e-6;

/// The part of its range by which the sensor is wrong so long after an edge, s: all of it at first, and e times less after each 1.85 µs.
fn unsettled(since_s: f64) -> f64 {
    if since_s < SETTLES_S { libm::exp(since_s / SETTLES_S * libm::log(0.005)) } else { 0.0 }
}

/// Ω and H of a motor whose wires touch.
const SHORTED: [f64; 2] = [0.02, 1e-5];

/// The power stage and the motor of one joint.
#[derive(Clone, Debug)]
pub struct Drive {
    winding: Winding,
    /// Newtons or newton metres per ampere along the joint: also volts per metre or radian per second.
    force_per_a: f64,
    /// Counts of the timer that are all of the supply.
    counts: f64,
    closed: Option<Closed>,
    /// The bridge conducts.
    on: bool,
    /// What acts, and what does from the next period on.
    now: Order,
    next: Order,
    /// Voltages of this period and of the one before, counts.
    voltage: i32,
    before: i32,
    current_a: f64,
    /// Largest |current| since it was asked for.
    peak_a: f64,
    fault: PlantFault,
}

impl Drive {
    /// The stage that the tables `motor` and `plant` describe.
    ///
    /// # Errors
    /// What [`CurrentLoop::build`] refuses, where there is a loop.
    pub fn new(settings: &Settings, plant: &PlantSettings, seed: u64) -> Result<Self, Refused<'static>> {
        let motor = &settings.motor;
        let counts = plant.timer_counts();
        let supply_mv = (1e3 * plant.supply_v).round() as u32;
        let closed = match plant.drive {
            DriveName::Voltage => None,
            DriveName::Current => {
                let design = CurrentLoop::build(settings, counts)?;
                Some(Closed {
                    gains: design.gains(supply_mv),
                    design,
                    controller: Controller::default(),
                    sensor: Sensor::build(settings, plant.current_bits),
                    converter: Converter::new(settings, plant, seed),
                    supply_mv,
                    codes: 0,
                    volts: 0,
                    last: 0,
                    periods: 0,
                    middle: 0,
                })
            }
        };
        Ok(Self {
            winding: Winding {
                resistance_ohm: motor.resistance_ohm * plant.resistance_ratio,
                inductance_h: motor.inductance_h,
                supply_v: plant.supply_v,
                dead_time_s: plant.dead_time_s,
            },
            force_per_a: motor.newton_or_newton_metre_per_a * if motor.reversed { -1.0 } else { 1.0 },
            counts: f64::from(counts),
            closed,
            on: false,
            now: OFF,
            next: OFF,
            voltage: 0,
            before: 0,
            current_a: 0.0,
            peak_a: 0.0,
            fault: PlantFault::None,
        })
    }

    /// Gives the current loop the gains and the sensor's scale that these settings say, whatever winding there is; without a loop nothing
    /// changes.
    ///
    /// # Errors
    /// What [`CurrentLoop::build`] refuses.
    pub fn tune(&mut self, settings: &Settings, plant: &PlantSettings) -> Result<(), Refused<'static>> {
        if let Some(closed) = &mut self.closed {
            closed.design = CurrentLoop::build(settings, plant.timer_counts())?;
            closed.gains = closed.design.gains(closed.supply_mv);
            closed.sensor = Sensor::build(settings, plant.current_bits);
        }
        Ok(())
    }

    /// Largest |current| through the winding since it was last asked for, A.
    pub fn take_peak_a(&mut self) -> f64 {
        std::mem::take(&mut self.peak_a)
    }

    /// Makes motor, bridge or sensor fail in this way from now on.
    pub fn fail(&mut self, fault: PlantFault) {
        self.fault = fault;
        match fault {
            PlantFault::LowSupply => self.set_supply(0.6 * self.winding.supply_v),
            PlantFault::HighSupply => self.set_supply(1.4 * self.winding.supply_v),
            _ => {}
        }
        if fault == PlantFault::ShortedMotor {
            // What does not reach the motor neither moves it nor is moved by it.
            [self.winding.resistance_ohm, self.winding.inductance_h] = SHORTED;
            self.force_per_a = 0.0;
        }
    }

    /// Turns the bridge off and resets the current loop.
    pub fn off(&mut self) {
        (self.now, self.next, self.voltage, self.before) = (OFF, OFF, 0, 0);
        if self.fault != PlantFault::ConductingBridge {
            self.current_a = 0.0;
        }
        self.on = false;
        if let Some(closed) = &mut self.closed {
            closed.controller = Controller::default();
            closed.begin();
        }
    }

    /// Takes the duty that a tick has computed, and the speed of the joint as the peer knows it (m/s or rad/s).
    pub fn command(&mut self, duty: Duty, joint_speed: f64) {
        let forward = |closed: &Closed| closed.design.forward(joint_speed as f32, closed.supply_mv);
        self.take(Order::Current(duty, self.closed.as_ref().map_or(0, forward)), true);
    }

    /// A tick that closes no loop: a voltage for the bridge's inputs, as a share of the supply, whether or not it is enabled.
    pub fn open(&mut self, duty: Duty, enable: bool) {
        self.take(Order::Voltage(duty), enable);
    }

    fn take(&mut self, order: Order, enable: bool) {
        if !enable && !self.ignores_enable() {
            return self.off();
        }
        (self.next, self.on) = (order, true);
        if let Some(closed) = &mut self.closed {
            closed.begin();
        }
    }

    /// What the stage measured since the last command; none without a current loop, or before the first period.
    pub fn measured(&self) -> Option<stage::Flow> {
        self.closed.as_ref().and_then(Closed::flow)
    }

    /// One PWM period of a voltage (counts; none, where the bridge is off) on a joint that moves at this speed (m/s or rad/s): what the converter
    /// reads at its start and in its middle, 0 without one, and the mean force, N or N·m.
    pub fn flow(&mut self, voltage: Option<i32>, joint_speed: f64) -> ([u16; 2], f64) {
        let conducts = voltage.is_some() || self.fault == PlantFault::ConductingBridge;
        let share = voltage.map_or(LEAKS, |voltage| f64::from(voltage) / self.counts);
        let (begins_a, Flow { sampled_a, mean_a, end_a }) = if conducts && self.fault != PlantFault::OpenMotor {
            let emf_v = self.force_per_a * joint_speed;
            (self.current_a, self.winding.period(self.current_a, share, emf_v, 0.5 * PWM_PERIOD_S))
        } else {
            Default::default()
        };
        self.current_a = end_a;
        self.peak_a = self.peak_a.max(end_a.abs()).max(sampled_a.abs());
        let seen = |current_a: f64| match self.fault {
            PlantFault::DeadSense => 0.0,
            PlantFault::ReversedSense => -current_a,
            PlantFault::SenseAtEnd => f64::INFINITY,
            _ => current_a,
        };
        // The first leg has risen in the period before, and falls in this one.
        let edges = [f64::from(self.before) / self.counts, -share].map(|share| 0.25 * (1.0 + share) * PWM_PERIOD_S);
        self.before = voltage.unwrap_or(0);
        let reads = self.closed.as_mut().map_or([0; 2], |Closed { converter, .. }| {
            let [rose, fell] = edges.map(|since_s| converter.sense_a * unsettled(since_s));
            [begins_a + rose, sampled_a - fell].map(|current_a| converter.read(seen(current_a)))
        });
        (reads, self.force_per_a * mean_a)
    }

    /// Whether the bridge gives what its inputs say even while it is not enabled.
    pub fn ignores_enable(&self) -> bool {
        self.fault == PlantFault::IgnoredEnable
    }

    /// The bridge's supply, V.
    pub fn supply_v(&self) -> f64 {
        self.winding.supply_v
    }

    /// The bridge's supply is this from now on, V.
    pub fn set_supply(&mut self, volts: f64) {
        self.winding.supply_v = volts;
        if let Some(closed) = &mut self.closed {
            closed.supply_mv = (1e3 * volts).round() as u32;
            closed.gains = closed.design.gains(closed.supply_mv);
        }
    }

    /// One PWM period of a joint that moves at this speed (m/s or rad/s): its mean force, N or N·m.
    pub fn period(&mut self, joint_speed: f64) -> f64 {
        let before = self.before;
        let ([start, middle], force) = self.flow(self.on.then_some(self.voltage), joint_speed);
        let order = self.now;
        self.now = self.next;
        let volts = |Duty(duty)| (f64::from(duty) / f64::from(Duty::FULL_SCALE) * self.counts).round() as i32;
        self.voltage = match &mut self.closed {
            Some(closed) => {
                let read = if before < 0 { closed.middle } else { start };
                (closed.last, closed.middle) = (closed.sensor.codes(read), middle);
                closed.codes += closed.last;
                closed.volts += self.voltage;
                closed.periods += 1;
                match order {
                    _ if !self.on => 0,
                    Order::Current(duty, forward) => closed.controller.step(&closed.gains, duty, closed.last, forward),
                    Order::Voltage(duty) => volts(duty),
                }
            }
            None => match self.now {
                Order::Current(duty, _) | Order::Voltage(duty) => volts(duty),
            },
        };
        force
    }
}
