//! A moteus motor controller (mjbots) at the other end of a CAN bus: the bytes of its command and of its answer, and what each answer means for
//! the motors.
//!
//! **A command** is a position command (mode 10) without a position: scales of stiffness, damping and integrator 0, a feed-forward torque,
//! the largest torque, and the controller's own watchdog, [`WATCHDOG_MS`]. It asks in return for mode, position, velocity, torque, supply,
//! temperature and fault. [`STOP`] asks for the same, and stops: the windings are free.
//!
//! **One a tick.** The answer of the tick before is heard first ([`Motor::hear`]). A missing one keeps the joint where it was, and the torque
//! fades: three quarters, a half, a quarter, then nothing ([`LOST`] ticks without an answer), motors off. What a controller that hears
//! nothing does is its own watchdog's work, and never to hold a position: `servo.timeout_mode` has to be 0, 12 or 15.
//!
//! Units: N·m and revolutions of the controller's output, V, °C; the joint in counts, `encoder.counts_per_rev` to a revolution. The place
//! where it was heard first is 0 counts; exact to a count within a thousand revolutions.
//!
//! Byte by byte as the public register map has it (tests/parts/moteus.rs compares it with the crate `moteus-protocol`). Little-endian words,
//! as they lie in the CAN controller's memory; floats where words begin.

use cohold_core::device::encoder::Counts;
use cohold_core::device::{kinematics::Joints, motor::Duty};
use cohold_core::names::MotorDrive;
use cohold_core::num::Scalar;
use cohold_core::safety::{Fault, Patience};
use cohold_core::settings::{Refused, Settings};

use crate::rate::Rate;
use crate::signals::Coded;

/// Until when a controller stops by itself after the last command, ms.
pub const WATCHDOG_MS: u8 = 5;
/// Ticks without an answer after which the motors are off.
pub const LOST: u32 = 4;
/// Ticks that a controller may take from its first command to its mode 10: it looks at its current sensors first.
pub const WAKE_TICKS: u32 = 50;
/// Ticks over which the torque comes in then.
const RISE_TICKS: u32 = 8;
/// Highest temperature of a controller, °C: below the 75 at which it stops by itself.
pub const MOST_C: i8 = 70;
/// Ticks for which the torque may be another one than was asked for, by more than an eighth of the largest.
const ASTRAY_TICKS: u32 = 10;

/// Words of a command: 48 bytes.
pub const COMMAND_WORDS: usize = 12;
/// Words of an answer: 24 bytes, of which 22 are used.
pub const ANSWER_WORDS: usize = 6;

/// No operation, four of them.
const NOPS: u32 = u32::from_le_bytes([0x50; 4]);
/// Reads: mode as 8 bits; three floats from register 1; 8 bits of supply, temperature and fault, from register 13.
const QUERY: [u8; 6] = [0x11, 0x00, 0x1F, 0x01, 0x13, 0x0D];

/// Mode 0, and the query.
pub const STOP: [u32; COMMAND_WORDS] = {
    let mut words = [NOPS; COMMAND_WORDS];
    words[0] = u32::from_le_bytes([0x01, 0x00, 0x00, QUERY[0]]);
    words[1] = u32::from_le_bytes([QUERY[1], QUERY[2], QUERY[3], QUERY[4]]);
    words[2] = u32::from_le_bytes([QUERY[5], 0x50, 0x50, 0x50]);
    words
};

/// A command of so much torque, N·m, and no more than `most_nm` whatever happens.
#[inline]
pub fn command(torque_nm: f32, most_nm: f32) -> [u32; COMMAND_WORDS] {
    let bytes = u32::from_le_bytes;
    [
        // Mode 10, limit of the integrator 0, feed-forward torque.
        bytes([0x01, 0x00, 0x0A, 0x01]),
        bytes([0x2B, 0x00, 0x0D, 0x22]),
        torque_nm.to_bits(),
        // Stiffness 0, damping 0, largest torque.
        bytes([0x01, 0x23, 0x00, 0x01]),
        bytes([0x24, 0x00, 0x0D, 0x25]),
        most_nm.to_bits(),
        // No position, velocity 0; watchdog.
        bytes([0x02, 0x20, 0x80, 0x00]),
        bytes([0x05, 0x27, WATCHDOG_MS, 0x00]),
        bytes([QUERY[0], QUERY[1], QUERY[2], QUERY[3]]),
        bytes([QUERY[4], QUERY[5], 0x50, 0x50]),
        NOPS,
        NOPS,
    ]
}

/// What a controller told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// Its mode: 0 stopped, 1 fault, 10 as commanded, 11 let go by its watchdog.
    pub mode: u8,
    /// Position of the output, revolutions.
    pub position_rev: f32,
    /// Its velocity, revolutions per second.
    pub velocity_rev_per_s: f32,
    /// Torque at the output, N·m.
    pub torque_nm: f32,
    /// Supply, half volts.
    pub supply: i8,
    /// Temperature, °C.
    pub temperature_c: i8,
    /// Its own number of what is wrong; of a controller that goes on, 96 to 103 say what limits its torque.
    pub fault: u8,
}

impl Told {
    /// An answer to a command or a stop; none if it is not one.
    #[inline]
    pub fn read(words: &[u32; ANSWER_WORDS]) -> Option<Self> {
        let [w0, w1, w2, w3, w4, w5] = *words;
        let is_answer = w0 & 0xFF00_FFFF == 0x2F00_0021 && w1 & 0xFF == 0x01 && w4 >> 8 & 0xFFFF == 0x0D23;
        let float = |low: u32, high: u32| f32::from_bits(low >> 8 | high << 24);
        is_answer.then(|| Self {
            mode: (w0 >> 16) as u8,
            position_rev: float(w1, w2),
            velocity_rev_per_s: float(w2, w3),
            torque_nm: float(w3, w4),
            supply: (w4 >> 24) as u8 as i8,
            temperature_c: w5 as u8 as i8,
            fault: (w5 >> 8) as u8,
        })
    }
}

/// What stands against driving a motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trouble {
    /// Nothing.
    #[default]
    None,
    /// It does not answer.
    Silent,
    /// The board's own CAN controller is off the bus.
    BusOff,
    /// It stopped by itself, or is in a mode that nobody asked for.
    LetGo,
    /// Its position or velocity is not a number.
    NotANumber,
    /// It is too warm.
    TooWarm,
    /// Its supply is out of range.
    Supply,
    /// Its torque is not the one that was asked for.
    Astray,
    /// A fault of its own, by its number.
    Own(u8),
}

/// 0 to 7; 256 and its own number.
impl Coded for Trouble {
    #[inline]
    fn code(self) -> u32 {
        match self {
            Self::None => 0,
            Self::Silent => 1,
            Self::BusOff => 2,
            Self::LetGo => 3,
            Self::NotANumber => 4,
            Self::TooWarm => 5,
            Self::Supply => 6,
            Self::Astray => 7,
            Self::Own(number) => 256 + u32::from(number),
        }
    }
    fn decode(code: u32) -> Self {
        match code {
            1 => Self::Silent,
            2 => Self::BusOff,
            3 => Self::LetGo,
            4 => Self::NotANumber,
            5 => Self::TooWarm,
            6 => Self::Supply,
            7 => Self::Astray,
            256..512 => Self::Own(code as u8),
            _ => Self::None,
        }
    }
}

impl Trouble {
    /// The fault that it is of motors that are on.
    #[inline]
    pub fn fault(self) -> Option<Fault> {
        Some(match self {
            Self::None => return None,
            Self::Silent => Fault::DriveSilent,
            Self::BusOff => Fault::DriveBusOff,
            Self::LetGo => Fault::DriveLetGo,
            Self::NotANumber => Fault::NonFiniteInput,
            Self::TooWarm => Fault::DriveTooWarm,
            Self::Supply => Fault::SupplyOutOfRange,
            Self::Astray => Fault::CurrentNotFollowed,
            Self::Own(_) => Fault::DriveFailed,
        })
    }

    /// One sentence for a person; none if nothing is wrong.
    pub fn explain(self) -> Option<&'static str> {
        Some(match self {
            Self::None => return None,
            Self::Silent => "the motor's controller does not answer: look at its supply, its bus, its identifier (1)",
            Self::BusOff => "the board is off the motor's bus: look at its wires and at the resistors of its ends",
            Self::LetGo => "the motor's controller let go by itself",
            Self::NotANumber => "the motor's controller told a position that is not a number",
            Self::TooWarm => "the motor's controller is above 70 °C",
            Self::Supply => "the motor's controller has less than motor.min_supply_v, or more than motor.max_supply_v",
            Self::Astray => "the motor's torque was not the one that was asked for",
            Self::Own(32) => "the motor's controller, its fault 32: calibration failed",
            Self::Own(33) => "the motor's controller, its fault 33: its bridge's driver, often too little supply",
            Self::Own(34) => "the motor's controller, its fault 34: over-voltage, a hand pushed energy back",
            Self::Own(35) => "the motor's controller, its fault 35: its encoder",
            Self::Own(36) => "the motor's controller, its fault 36: it is not configured",
            Self::Own(37) => "the motor's controller, its fault 37: its control loop overran",
            Self::Own(38) => "the motor's controller, its fault 38: too warm",
            Self::Own(39) => "the motor's controller, its fault 39: outside of its own limits of position",
            Self::Own(40) => "the motor's controller, its fault 40: under-voltage",
            Self::Own(41) => "the motor's controller, its fault 41: its settings changed",
            Self::Own(42 | 43) => "the motor's controller, its fault 42 or 43: its angle or position is not valid",
            Self::Own(_) => "the motor's controller has a fault of its own: its register map says which",
        })
    }
}

/// What the settings make of the motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Design {
    nm_per_code: f32,
    most_nm: f32,
    counts_per_rev: f32,
    /// The least and the most supply, half volts.
    supply: [i8; 2],
}

impl Design {
    /// From the tables `motor`, `encoder` and `kinematics`. A slide is moved by a drum of which a turn is `counts_per_rev` of its counts.
    ///
    /// # Errors
    /// More axes than the one that is driven, a drive that asks for a current loop, or a faster tick.
    pub fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let only_one = "1, because the image for a moteus drives one motor";
        let only_amplifier = "amplifier, because a moteus makes the current of its torque by itself";
        let only_khz_1 = "0.001, as long as a question and its answer take on the bus";
        settings.all_fit(&[
            ("axis.count", settings.axis.count == 1, only_one),
            ("motor.drive", settings.motor.drive == MotorDrive::Amplifier, only_amplifier),
            ("timing.control_period_s", Rate::of(&settings.timing) == Some(Rate::Khz1), only_khz_1),
        ])?;
        let (motor, counts_per_rev) = (&settings.motor, settings.encoder.counts_per_rev);
        // N·m per N of a slide; of a joint that turns 1.
        let drum = counts_per_rev / (core::f64::consts::TAU * Joints::of(settings).counts_per_unit);
        let full_scale_nm = motor.newton_or_newton_metre_per_a * motor.full_scale_a * drum;
        // A cast saturates.
        let half_volts = |volts: f64| (2.0 * volts) as i8;
        Ok(Self {
            nm_per_code: (full_scale_nm / f64::from(Duty::FULL_SCALE)) as f32,
            most_nm: (motor.max_duty * full_scale_nm) as f32,
            counts_per_rev: counts_per_rev as f32,
            supply: [half_volts(motor.min_supply_v), half_volts(motor.max_supply_v)],
        })
    }
}

/// A motor from tick to tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motor {
    /// It has answered.
    heard: bool,
    /// Where 0 counts are, revolutions.
    zero_rev: f32,
    counts: u16,
    /// Ticks without an answer in a row.
    missing: u32,
    /// Ticks since it was first commanded; 0: it is stopped.
    driven: u32,
    /// Ticks in mode 10 since then.
    awake: u32,
    asked_nm: f32,
    astray: Patience,
    trouble: Trouble,
}

impl Motor {
    /// One tick: the answer that has come since the last, if one has, and whether the board's own controller is off the bus. The fault, if
    /// the motors have to be off for it.
    #[inline]
    pub fn hear(&mut self, design: &Design, answer: Option<Told>, bus_off: bool) -> Option<Fault> {
        self.trouble = match answer {
            Some(told) => self.judge(design, &told),
            None => {
                self.missing = self.missing.saturating_add(1);
                if self.missing >= LOST { Trouble::Silent } else { Trouble::None }
            }
        };
        if bus_off {
            self.trouble = Trouble::BusOff;
        }
        // Whoever was silent may have lost count of its turns: that is a fault of a motor that is off, too.
        let lost = self.heard && self.missing >= LOST;
        if self.driven > 0 || lost { self.trouble.fault() } else { None }
    }

    #[inline]
    fn judge(&mut self, design: &Design, told: &Told) -> Trouble {
        let [least, most] = design.supply;
        let is_new = !self.heard || self.missing >= LOST;
        self.missing = 0;
        if !told.position_rev.is_finite() || !told.velocity_rev_per_s.is_finite() {
            return Trouble::NotANumber;
        }
        if is_new {
            // Where it is now is where it was left.
            self.zero_rev = told.position_rev - f32::from(self.counts.cast_signed()) / design.counts_per_rev;
            self.heard = true;
        }
        self.counts = ((told.position_rev - self.zero_rev) * design.counts_per_rev).round_to_i32() as u16;
        let waking = self.driven <= WAKE_TICKS && self.awake == 0;
        let astray = (told.torque_nm - self.asked_nm).abs() > 0.125 * design.most_nm;
        if self.driven > 0 && told.mode == 10 {
            self.awake = self.awake.saturating_add(1);
        }
        match told.mode {
            1 => return Trouble::Own(told.fault),
            10 if self.driven > 0 => {}
            // Stopped, or on its way to mode 10.
            0 | 2..=4 if waking => {}
            _ if self.driven == 0 => {}
            _ => return Trouble::LetGo,
        }
        if told.temperature_c > MOST_C {
            Trouble::TooWarm
        } else if told.supply < least || told.supply > most {
            Trouble::Supply
        } else if self.astray.spent(self.awake > 0 && astray, ASTRAY_TICKS) {
            Trouble::Astray
        } else {
            Trouble::None
        }
    }

    /// Where the joint is.
    #[inline]
    pub fn counts(&self) -> Counts {
        Counts(self.counts)
    }

    /// What stands against driving it.
    #[inline]
    pub fn trouble(&self) -> Trouble {
        self.trouble
    }

    /// The command of a tick that gives this duty as a share of full torque, as far as answers come and it is awake.
    #[inline]
    pub fn drive(&mut self, design: &Design, duty: Duty) -> [u32; COMMAND_WORDS] {
        self.driven = self.driven.saturating_add(1);
        let left = LOST.saturating_sub(self.missing);
        let share = if left < LOST {
            // A quarter of it for each tick that is left.
            left as f32 * (1.0 / LOST as f32)
        } else {
            self.awake.min(RISE_TICKS) as f32 * (1.0 / RISE_TICKS as f32)
        };
        self.asked_nm = f32::from(duty.0) * design.nm_per_code * share;
        command(self.asked_nm, design.most_nm)
    }

    /// The command of a tick that wants nothing of it.
    #[inline]
    pub fn stop(&mut self) -> &'static [u32; COMMAND_WORDS] {
        (self.driven, self.awake, self.asked_nm, self.astray) = (0, 0, 0.0, Patience::default());
        &STOP
    }
}
