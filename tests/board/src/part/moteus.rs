//! A moteus controller at the board's CAN bus: what it makes of a frame, byte by byte of the public register map, its modes, its watchdog, and its
//! faults. What it turns (inertia, friction and a hand) is the bench's device; where that is comes in as counts, and its torque goes out.
//!
//! Left out: everything that the image does not ask for, which gets no answer, and its own current loop: the torque is the one asked for.

use serde::{Deserialize, Serialize};

use super::fdcan::Frame;

/// Its identifier.
const OWN: u32 = 1;
/// From the end of a question to the beginning of its answer, ns.
const THINKS_NS: u64 = 30_000;
/// From its first command to its mode 10, ns: it looks at its current sensors first.
const WAKES_NS: u64 = 8_000_000;
/// Where its encoder is as it is first turned on, revolutions.
const BEGINS_REV: f64 = 0.25;

/// Modes.
const STOPPED: u8 = 0;
const FAULT: u8 = 1;
const CALIBRATING: u8 = 3;
const POSITION: u8 = 10;
const TIMEOUT: u8 = 11;

/// What it does wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Planted {
    /// Nothing.
    #[default]
    None,
    /// It has no supply: it neither hears nor says anything.
    Dead,
    /// It hears, and answers nothing.
    Mute,
    /// A fault of its own, by its number: it stops.
    Fails(u8),
    /// It is so warm, °C.
    Warm(i8),
    /// Its supply, half volts.
    Supply(i8),
    /// Its position is not a number.
    NotANumber,
    /// Its watchdog finds that it heard nothing, though it did.
    LetsGo,
}

/// Model of the controller.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Controller {
    /// What it does wrong.
    pub planted: Planted,
    /// Counts of the joint for a revolution of its output.
    pub counts_per_rev: f64,
    /// Where the joint is, counts.
    pub counts: i64,
    mode: u8,
    torque_nm: f64,
    /// When it lets go by itself, and is awake, ns.
    until_ns: u64,
    awake_ns: u64,
    /// It was asked to pull by itself, by gains or an integrator, or to know no watchdog: never.
    pub pulled: bool,
}

impl Default for Controller {
    fn default() -> Self {
        Self {
            planted: Planted::None,
            counts_per_rev: 8192.0,
            counts: 0,
            mode: STOPPED,
            torque_nm: 0.0,
            until_ns: u64::MAX,
            awake_ns: 0,
            pulled: false,
        }
    }
}

/// The next bytes.
fn next<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (own, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*own)
}

/// A number of a register: 8, 16 or 32 bits that count steps, or a float.
fn number(kind: u8, register: u32, bytes: &mut &[u8]) -> Option<f64> {
    // Steps of 8 and 16 bits of what a command has: torques, scales, times; positions and velocities are only ever 0 or none.
    let [small, middle] = match register {
        0x22 | 0x25 => [0.5, 0.01],
        0x27 => [0.01, 0.001],
        0x23 | 0x24 | 0x2B => [1.0 / 127.0, 1.0 / 32767.0],
        _ => [1.0, 1.0],
    };
    match kind {
        0 => {
            let [count] = next::<1>(bytes)?.map(u8::cast_signed);
            Some(if count == i8::MIN { f64::NAN } else { f64::from(count) * small })
        }
        1 => {
            let count = i16::from_le_bytes(next(bytes)?);
            Some(if count == i16::MIN { f64::NAN } else { f64::from(count) * middle })
        }
        3 => next(bytes).map(|own| f32::from_le_bytes(own).into()),
        _ => None,
    }
}

/// What a frame asks for.
#[derive(Default)]
struct Asked {
    written: Vec<(u32, f64)>,
    /// How each register that is read is to be told, in runs as they were asked for.
    read: Vec<(u8, u32, u32)>,
}

/// Reads a frame; none of one that has anything else in it.
fn asked(mut bytes: &[u8]) -> Option<Asked> {
    let mut asked = Asked::default();
    while let Some([kind]) = next(&mut bytes) {
        let low = u32::from(kind & 3);
        let count = |bytes: &mut &[u8]| if low == 0 { next(bytes).map(|[count]| count.into()) } else { Some(low) };
        match kind {
            0x00..=0x0F => {
                let (count, [first]) = (count(&mut bytes)?, next(&mut bytes)?);
                for register in u32::from(first)..u32::from(first) + count {
                    asked.written.push((register, number(kind >> 2 & 3, register, &mut bytes)?));
                }
            }
            0x10..=0x1F => {
                let (count, [first]) = (count(&mut bytes)?, next(&mut bytes)?);
                asked.read.push((kind >> 2 & 3, first.into(), count));
            }
            0x50 => {}
            _ => return None,
        }
    }
    Some(asked)
}

impl Controller {
    /// Whether it acknowledges what is on the bus.
    pub fn hears(&self) -> bool {
        self.planted != Planted::Dead
    }

    /// The torque at its output at an instant, N·m; none while its windings are free.
    pub fn torque_nm(&mut self, now_ns: u64) -> Option<f64> {
        self.settle(now_ns);
        (self.mode == POSITION).then_some(self.torque_nm)
    }

    /// Brings it to now.
    fn settle(&mut self, now_ns: u64) {
        if self.mode == CALIBRATING && now_ns >= self.awake_ns {
            self.mode = POSITION;
        }
        let runs = matches!(self.mode, CALIBRATING | POSITION);
        match self.planted {
            Planted::Dead => self.mode = STOPPED,
            Planted::Fails(_) if runs => self.mode = FAULT,
            Planted::LetsGo if runs => self.mode = TIMEOUT,
            _ if runs && now_ns >= self.until_ns => self.mode = TIMEOUT,
            _ => {}
        }
    }

    /// Takes a frame that has come; its answer, and how long it takes over it, ns.
    pub fn hear(&mut self, now_ns: u64, (identifier, _, bytes): &Frame) -> Option<(Frame, u64)> {
        self.settle(now_ns);
        if !self.hears() || identifier & 0x7F != OWN {
            return None;
        }
        let Asked { written, read } = asked(bytes)?;
        let of = |register: u32| written.iter().find(|(known, _)| *known == register).map(|(_, value)| *value);
        match of(0).map(|mode| mode as u8) {
            Some(STOPPED) => (self.mode, self.torque_nm) = (STOPPED, 0.0),
            // Out of a fault or a timeout leads a stop alone.
            Some(POSITION) if matches!(self.mode, STOPPED | CALIBRATING | POSITION) => self.command(now_ns, of),
            Some(POSITION) | None => {}
            Some(_) => return None,
        }
        self.settle(now_ns);
        let source = identifier >> 8 & 0x7F;
        let wants = identifier & 0x8000 != 0 && !read.is_empty() && self.planted != Planted::Mute;
        wants.then(|| ((OWN << 8 | source, false, self.answer(&read)), THINKS_NS))
    }

    fn command(&mut self, now_ns: u64, of: impl Fn(u32) -> Option<f64>) {
        let free = |register| of(register) == Some(0.0);
        let watchdog_s = of(0x27).unwrap_or(f64::NAN);
        let place = of(0x20).unwrap_or(0.0);
        self.pulled |=
            ![0x23, 0x24, 0x2B].into_iter().all(free) || watchdog_s.is_nan() || watchdog_s <= 0.0 || !place.is_nan();
        let most = of(0x25).unwrap_or(f64::INFINITY);
        self.torque_nm = of(0x22).unwrap_or(0.0).clamp(-most, most);
        self.until_ns = now_ns + (1e9 * watchdog_s) as u64;
        if self.mode == STOPPED {
            (self.mode, self.awake_ns) = (CALIBRATING, now_ns + WAKES_NS);
        }
    }

    /// What it tells of these registers, padded to a length that there is.
    fn answer(&self, read: &[(u8, u32, u32)]) -> Vec<u8> {
        let runs = self.mode == POSITION;
        let rev = BEGINS_REV + self.counts as f64 / self.counts_per_rev;
        let told = |register: u32| match (register, self.planted) {
            (0x01, Planted::NotANumber) => f64::NAN,
            (0x00, _) => self.mode.into(),
            (0x01, _) => rev,
            (0x03, _) if runs => self.torque_nm,
            (0x0D, Planted::Supply(half_volts)) => half_volts.into(),
            (0x0D, _) => 48.0,
            (0x0E, Planted::Warm(celsius)) => celsius.into(),
            (0x0E, _) => 31.0,
            (0x0F, Planted::Fails(number)) if self.mode == FAULT => number.into(),
            _ => 0.0,
        };
        let mut bytes = Vec::new();
        for (kind, first, count) in read {
            bytes.extend([0x20 | kind << 2 | *count as u8, *first as u8]);
            for register in *first..first + count {
                match kind {
                    0 => bytes.push((told(register) as i8).cast_unsigned()),
                    _ => bytes.extend((told(register) as f32).to_le_bytes()),
                }
            }
        }
        let length = [8, 12, 16, 20, 24, 32, 48, 64].into_iter().find(|length| *length >= bytes.len());
        bytes.resize(length.expect("an answer fits"), 0x50);
        bytes
    }
}
