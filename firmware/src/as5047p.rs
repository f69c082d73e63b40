//! An AS5047P (ams OSRAM), an absolute magnetic encoder on SPI: its frames, what they say of where a joint is, and what they say against it.
//!
//! **A frame** has 16 bits each way: even parity, then in a command "read" and an address, in an answer the error flag and 14 bits. What is asked
//! for in a frame is sampled as that ends, and answered in the next one.
//!
//! **A reading** is two frames a tick. The first asks for the angle, and brings the answer to what the second frame of the tick before asked for:
//! the diagnosis, in which one bit is always set, or after anything wrong the errors, which reading clears. The second brings the angle, some
//! microseconds old. So a line that stands at either level shows in every tick, although an angle of 0 is all zeros, too.
//!
//! **What is not a whole reading** keeps the joint where it was; the [`BAD`]th in a row is a fault. A single wrong bit, whichever way it went,
//! costs two readings at the most. Parity misses an even number of wrong bits: what those make of an angle, the limit of a step sees or nobody.
//!
//! Units: counts of 2⁻¹⁴ of a revolution, as `encoder.counts_per_rev` or `encoder.counts_per_m` have to say. The place where it was heard first is
//! 0 counts: turns of 14 bits add up in 16, the shorter way round is the one that was moved, and [`Design::build`] sees to it that it is, across
//! readings that are missing, too.

use cohold_core::device::encoder::{self, Counts};
use cohold_core::safety::Fault;
use cohold_core::settings::{Refused, Settings};

use crate::signals::Coded;

/// Readings in a row that were not whole, after which the motors are off: a position is at most two ticks old.
pub const BAD: u32 = 3;
/// Counts of half a revolution.
const HALF: u16 = 1 << 13;
/// Encoders that there are at the most.
const MOST: usize = 2;

/// Command to read the angle, compensated for its own delay.
pub const ANGLE: u16 = 0xFFFF;
/// Command to read the diagnosis.
pub const DIAGNOSIS: u16 = 0xFFFC;
/// Command to read the errors, and to clear them.
pub const ERRORS: u16 = 0x4001;

/// Of an answer.
const ERROR_FLAG: u16 = 1 << 14;
const DATA: u16 = ERROR_FLAG - 1;
/// Of a diagnosis: the field is too weak, too strong, out of what can be computed; offsets are compensated for.
const TOO_WEAK: u16 = 1 << 11;
const TOO_STRONG: u16 = 1 << 10;
const OVERFLOW: u16 = 1 << 9;
const READY: u16 = 1 << 8;

/// What stands against an encoder's reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reason {
    /// Nothing.
    #[default]
    None,
    /// It does not answer, or is not ready.
    Silent,
    /// Parity is wrong, or it reports that what it heard was.
    Garbled,
    /// Its magnet's field is too weak.
    Weak,
    /// Its magnet's field is too strong.
    Strong,
}

/// What stands against driving, and of which encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Trouble {
    /// From 0.
    pub joint: u8,
    /// What it is.
    pub reason: Reason,
}

/// Eight to an encoder.
impl Coded for Trouble {
    #[inline]
    fn code(self) -> u32 {
        8 * u32::from(self.joint) + self.reason as u32
    }
    fn decode(code: u32) -> Self {
        let reason = match code % 8 {
            1 => Reason::Silent,
            2 => Reason::Garbled,
            3 => Reason::Weak,
            4 => Reason::Strong,
            _ => Reason::None,
        };
        Self { joint: (code / 8) as u8, reason }
    }
}

impl Trouble {
    /// The fault that it is.
    #[inline]
    pub fn fault(self) -> Option<Fault> {
        match self.reason {
            Reason::None => None,
            Reason::Silent | Reason::Garbled => Some(Fault::EncoderSilent),
            Reason::Weak | Reason::Strong => Some(Fault::EncoderMagnet),
        }
    }

    /// One sentence for a person; none if nothing is wrong.
    pub fn explain(self) -> Option<&'static str> {
        let each: [&'static str; MOST] = match self.reason {
            Reason::None => return None,
            Reason::Silent => [
                "encoder 1 does not answer: look at its supply, its chip select (PA4) and its wires",
                "encoder 2 does not answer: look at its supply, its chip select (PA15) and its wires",
            ],
            Reason::Garbled => [
                "encoder 1 and the board do not understand each other: look at the wires of its clock and data",
                "encoder 2 and the board do not understand each other: look at the wires of its clock and data",
            ],
            Reason::Weak => [
                "encoder 1 sees too weak a field: its magnet is off, or too far away",
                "encoder 2 sees too weak a field: its magnet is off, or too far away",
            ],
            Reason::Strong => [
                "encoder 1 sees too strong a field: its magnet is too near, or another one is",
                "encoder 2 sees too strong a field: its magnet is too near, or another one is",
            ],
        };
        each.get(usize::from(self.joint)).copied()
    }
}

/// What the settings make of the encoders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Design {
    /// Those that have to be there, from the first on.
    used: usize,
}

impl Design {
    /// From the tables `axis`, `encoder`, `timing` and `kinematics`.
    ///
    /// # Errors
    /// encoder.max_speed_m_per_s allows for half a revolution, or more, between one whole reading and the next.
    pub fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        encoder::check_step(settings, (u32::from(HALF) - 1) / BAD)?;
        Ok(Self { used: settings.axis.count as usize })
    }

    /// Whether a joint's encoder has to be there.
    #[inline]
    fn uses(&self, joint: usize) -> bool {
        joint < self.used
    }
}

/// What the last command asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    Nothing,
    Diagnosis,
    Errors,
}

/// An encoder from tick to tick.
#[derive(Clone, Copy, Debug)]
pub struct Sensor {
    asked: Asked,
    /// What is wrong with this reading; after it, with the last one that was not whole.
    reason: Reason,
    /// Readings that were not whole, in a row.
    bad: u32,
    /// It was read.
    heard: bool,
    counts: u16,
    /// From its angle to the counts.
    offset: u16,
}

impl Default for Sensor {
    fn default() -> Self {
        Self { asked: Asked::Nothing, reason: Reason::Silent, bad: BAD, heard: false, counts: 0, offset: 0 }
    }
}

/// Whether a frame has an even number of ones.
#[inline]
fn is_even(frame: u16) -> bool {
    frame.count_ones() & 1 == 0
}

/// What an answer carries, or what is wrong with it. A line that nobody drives is pulled up: all ones.
#[inline]
fn data(answer: Option<u16>) -> Result<u16, Reason> {
    match answer {
        None | Some(0xFFFF) => Err(Reason::Silent),
        Some(frame) if !is_even(frame) || frame & ERROR_FLAG != 0 => Err(Reason::Garbled),
        Some(frame) => Ok(frame & DATA),
    }
}

impl Sensor {
    /// After the first frame, which was [`ANGLE`]: what came in it, if anything did, and what is to be sent in the second.
    #[inline]
    pub fn first(&mut self, answer: Option<u16>) -> u16 {
        self.reason = match (self.asked, answer) {
            (Asked::Nothing, _) | (_, None | Some(0 | 0xFFFF)) => Reason::Silent,
            (Asked::Diagnosis, _) => match data(answer) {
                Err(reason) => reason,
                Ok(seen) if seen & READY == 0 => Reason::Silent,
                Ok(seen) if seen & TOO_WEAK != 0 => Reason::Weak,
                Ok(seen) if seen & (TOO_STRONG | OVERFLOW) != 0 => Reason::Strong,
                Ok(_) => Reason::None,
            },
            // Whatever errors there were, the flag among them, are over: it has told them.
            (Asked::Errors, Some(frame)) => {
                if is_even(frame) {
                    Reason::None
                } else {
                    Reason::Garbled
                }
            }
        };
        let understood = !matches!(self.reason, Reason::Silent | Reason::Garbled);
        self.asked = if understood || self.asked == Asked::Errors { Asked::Diagnosis } else { Asked::Errors };
        if self.asked == Asked::Diagnosis { DIAGNOSIS } else { ERRORS }
    }

    /// After the second frame: the angle that came in it, if anything did.
    #[inline]
    pub fn second(&mut self, answer: Option<u16>) {
        let angle = match (self.reason, data(answer)) {
            (Reason::None, Ok(angle)) => angle,
            (Reason::None, Err(reason)) => return self.miss(reason),
            (reason, _) => return self.miss(reason),
        };
        if self.bad >= BAD {
            // Where it is now is where it was left.
            self.offset = self.counts.wrapping_sub(angle);
        }
        let ahead = angle.wrapping_add(self.offset).wrapping_sub(self.counts) & DATA;
        // As a signed number of 14 bits.
        let step = (ahead ^ HALF).wrapping_sub(HALF);
        self.counts = self.counts.wrapping_add(step);
        (self.bad, self.heard) = (0, true);
    }

    #[inline]
    fn miss(&mut self, reason: Reason) {
        self.reason = reason;
        self.bad = self.bad.saturating_add(1);
    }

    /// Where the joint is.
    #[inline]
    pub fn counts(&self) -> Counts {
        Counts(self.counts)
    }

    /// What stands against driving it.
    #[inline]
    fn against(&self) -> Reason {
        if self.bad >= BAD { self.reason } else { Reason::None }
    }
}

/// Of the encoders that have to be there: what stands against driving, of the first that has anything, and the fault that it is of motors that
/// are on, or of an encoder that was read before and may have lost count of its turns.
#[inline]
pub fn judge<const N: usize>(design: &Design, sensors: &[Sensor; N], driving: bool) -> (Trouble, Option<Fault>) {
    let mut found = (Trouble::default(), None);
    for (joint, sensor) in sensors.iter().enumerate().rev() {
        let reason = sensor.against();
        if design.uses(joint) && reason != Reason::None {
            let trouble = Trouble { joint: joint as u8, reason };
            found = (trouble, trouble.fault().filter(|_| driving || sensor.heard));
        }
    }
    found
}
