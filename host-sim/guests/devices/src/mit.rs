//! Motors that take the 8-byte frame of MIT's Mini Cheetah: Damiao's (OpenArm's) and T-Motor's AK series, one to three on a CAN bus.
//!
//! **A torque** is position, speed and both gains zero, and the torque: p 16 bits, v 12, kp 12, kd 12, t 12, big-endian, each a share of the
//! motor's own range. So a frame of eight zeros asks for full torque backward, and one for another model's ranges for another torque. A Damiao is
//! asked for its ranges. The model `damiao` takes them, and every other one refuses ranges that differ. Numbers are rounded; no torque is
//! half a step, 2.4 mN·m of a DM4310.
//!
//! **A frame** is classical. OpenArm sets its motors up for flexible data rate: if a Damiao answers no classical frame, it is asked by such a
//! frame, and all later frames are of the kind that it answers.
//!
//! **Letting go.** A Damiao disables itself when it hears nothing for its register TIMEOUT (9), in units of 50 µs; 0, never, is not armed. T-Motor's
//! do not say, so it has to be measured, and told. Whoever lets go disables the motor; what is asked of one that is disabled moves nothing.
//!
//! Sources: LeRobot's and OpenArm's drivers (ranges, registers), CubeMars' AK manual 1.0.15 (ranges). The package
//! damiao-motor 1.0.6 has the unit of TIMEOUT and the control modes.

use std::time::{Duration, Instant};

use cohold_core::settings::Settings;
use cohold_sim::device::{DeviceFault, Gone};
use moteus_protocol::CanFdFrame;

use cohold_live::Error;
use cohold_live::devices::{DeviceOptions, Port};

use super::can::{self, Bus};
use super::motors::{self, Protocol, Ready, Told};

/// What a Damiao answers is sent to its own identifier and this, as OpenArm's are set up.
const ANSWERS: u32 = 0x10;
/// Whoever asks for registers writes here.
const REGISTERS: u32 = 0x7ff;
/// A question there for a register, and for the state.
const REGISTER: u8 = 0x33;
const STATE: u8 = 0xcc;
/// Registers: TIMEOUT; the control mode, which is 1 where MIT's frame is heard; the ends of position, speed and torque.
const TIMEOUT: u8 = 9;
const CONTROL_MODE: u8 = 10;
const ENDS: [u8; 3] = [21, 22, 23];
/// What TIMEOUT counts, s.
const TIMEOUT_S: f64 = 50e-6;
/// Ends of the two gains, N·m/rad and N·m·s/rad.
const GAINS: [f64; 2] = [500.0, 5.0];
const ENABLE: u8 = 0xfc;
const DISABLE: u8 = 0xfd;
const CLEAR: u8 = 0xfb;
/// How long a motor may take to say a register.
const PATIENCE: Duration = Duration::from_millis(200);

/// A motor's type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Model {
    /// As `--device-model` has it.
    pub name: &'static str,
    /// Ends of position, speed and torque, either way: rad, rad/s, N·m. Not a number: the motor's register.
    ends: [f64; 3],
    /// Damiao's: it has registers and tells its state.
    is_damiao: bool,
}

const fn damiao(name: &'static str, speed: f64, torque: f64) -> Model {
    Model { name, ends: [12.5, speed, torque], is_damiao: true }
}

const fn t_motor(name: &'static str, speed: f64, torque: f64) -> Model {
    Model { name, ends: [12.5, speed, torque], is_damiao: false }
}

/// The types that are known.
const MODELS: [Model; 13] = [
    Model { name: "damiao", ends: [f64::NAN; 3], is_damiao: true },
    damiao("dm4310", 30.0, 10.0),
    damiao("dm4340", 8.0, 28.0),
    damiao("dm6006", 45.0, 20.0),
    damiao("dm8006", 45.0, 40.0),
    damiao("dm8009", 45.0, 54.0),
    t_motor("ak10-9", 50.0, 65.0),
    t_motor("ak60-6", 45.0, 15.0),
    t_motor("ak70-10", 50.0, 25.0),
    t_motor("ak80-6", 76.0, 12.0),
    t_motor("ak80-9", 50.0, 18.0),
    t_motor("ak80-64", 8.0, 144.0),
    t_motor("ak80-80", 8.0, 144.0),
];

/// A number within ±`end` as a share of so many bits, to the nearest.
fn bits(number: f64, end: f64, count: u32) -> u64 {
    let most = f64::from((1_u32 << count) - 1);
    (((number / end).clamp(-1.0, 1.0) + 1.0) * 0.5 * most).round() as u64
}

/// The number that those bits are.
fn number(bits: u64, end: f64, count: u32) -> f64 {
    (2.0 * bits as f64 / f64::from((1_u32 << count) - 1) - 1.0) * end
}

impl Model {
    /// The frame for this torque, N·m; position, speed and gains are zero.
    fn torque(&self, torque_nm: f64) -> [u8; 8] {
        let [position, speed, torque] = self.ends;
        let none = |end: f64| bits(-end, end, 12);
        let [stiffness, damping] = GAINS.map(none);
        let word = bits(0.0, position, 16) << 48 | bits(0.0, speed, 12) << 36 | stiffness << 24 | damping << 12;
        (word | bits(torque_nm, torque, 12)).to_be_bytes()
    }

    /// Torque that one step is, N·m.
    fn step_nm(&self) -> f64 {
        2.0 * self.ends[2] / 4095.0
    }

    /// Position (rad), speed (rad/s) and torque (N·m) of an answer.
    fn told(&self, data: [u8; 8]) -> [f64; 3] {
        let word = u64::from_be_bytes(data);
        let [position, speed, torque] = self.ends;
        [
            number(word >> 40 & 0xffff, position, 16),
            number(word >> 28 & 0xfff, speed, 12),
            number(word >> 16 & 0xfff, torque, 12),
        ]
    }
}

/// The motors by their identifiers, and which of them are to be enabled.
struct Mit {
    models: Vec<Model>,
    ids: Vec<u8>,
    /// Frames have flexible data rate.
    fd: bool,
    enabled: Vec<bool>,
    /// Of a Damiao, whether it said that it is enabled since it was told to be.
    confirmed: Vec<bool>,
    /// Of a Damiao, that its last state was a fault.
    faulty: Vec<bool>,
}

impl Mit {
    /// Motors of one model, all disabled.
    fn new(model: Model, ids: &[u8], fd: bool) -> Self {
        let off = vec![false; ids.len()];
        let (models, ids) = (vec![model; ids.len()], ids.to_vec());
        Self { models, ids, fd, enabled: off.clone(), confirmed: off.clone(), faulty: off }
    }
}

/// What a Damiao's state says.
fn wrong(id: u8, state: u8) -> Option<Gone> {
    let (fault, cause) = match state {
        0 | 1 => return None,
        5 => (DeviceFault::Motor, "its sensor"),
        6 => (DeviceFault::Motor, "its parameters cannot be read"),
        8 => (DeviceFault::Supply, "over-voltage"),
        9 => (DeviceFault::Supply, "under-voltage"),
        0xa => (DeviceFault::Motor, "too much current"),
        0xb => (DeviceFault::TooWarm, "its bridge"),
        0xc => (DeviceFault::TooWarm, "its winding"),
        0xd => (DeviceFault::LetGo, "it heard nothing for its TIMEOUT"),
        0xe => (DeviceFault::Motor, "overload"),
        _ => (DeviceFault::Motor, "a state that is not in its manual"),
    };
    Some(Gone::new(fault, format!("motor {id}, its state {state:x}: {cause}")))
}

impl Protocol for Mit {
    fn command(&mut self, at: usize, torque_nm: Option<f64>, frames: &mut Vec<CanFdFrame>) {
        let id = u32::from(self.ids[at]);
        let order = |what: u8| can::frame(id, &[0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, what], self.fd);
        match torque_nm.filter(|torque_nm| torque_nm.is_finite()) {
            Some(torque_nm) => {
                if !self.enabled[at] {
                    frames.push(order(ENABLE));
                }
                self.enabled[at] = true;
                frames.push(can::frame(id, &self.models[at].torque(torque_nm), self.fd));
            }
            None => {
                if self.faulty[at] {
                    frames.push(order(CLEAR));
                }
                frames.push(order(DISABLE));
                (self.enabled[at], self.confirmed[at]) = (false, false);
            }
        }
    }

    /// A Damiao is asked for its state as for a register. A T-Motor knows no question: a torque of zero, by which it lets go as well.
    fn ask(&self, at: usize) -> CanFdFrame {
        let id = self.ids[at];
        match self.models[at].is_damiao {
            true => can::frame(REGISTERS, &[id, 0, STATE, 0, 0, 0, 0, 0], self.fd),
            false => can::frame(id.into(), &self.models[at].torque(0.0), self.fd),
        }
    }

    fn hear(&mut self, frame: &CanFdFrame) -> Option<(usize, Told, Option<Gone>)> {
        let is_damiao = self.models.iter().any(|model| model.is_damiao);
        let payload = frame.payload();
        let head = *payload.first()?;
        // A Damiao's first byte has its state above its identifier.
        let from = if is_damiao { head & 0x0f } else { head };
        let at = self.ids.iter().position(|id| if is_damiao { id & 0x0f == from } else { *id == from })?;
        let expected = if is_damiao { ANSWERS + u32::from(self.ids[at]) } else { 0 };
        if frame.arbitration_id & 0x7ff != expected || payload.len() < 6 {
            return None;
        }
        let mut data = [0; 8];
        data[..payload.len().min(8)].copy_from_slice(&payload[..payload.len().min(8)]);
        let [angle_rad, speed_rad_per_s, torque_nm] = self.models[at].told(data);
        // What rounding leaves of no torque is none.
        let torque_nm = if torque_nm.abs() <= self.models[at].step_nm() { 0.0 } else { torque_nm };
        let id = self.ids[at];
        let (mut trouble, temperature_c) = match is_damiao {
            true => (wrong(id, head >> 4), f64::from(data[6].max(data[7]))),
            false => {
                let code = data[7];
                let cause = || Gone::new(DeviceFault::Motor, format!("motor {id} tells error {code}"));
                ((code != 0).then(cause), f64::from(data[6]))
            }
        };
        self.faulty[at] = is_damiao && trouble.is_some();
        if is_damiao && self.enabled[at] {
            let is_enabled = head >> 4 == 1;
            if self.confirmed[at] && head >> 4 == 0 {
                trouble = trouble.or_else(|| {
                    Some(Gone::new(DeviceFault::LetGo, format!("motor {id} is disabled, and was not told to be")))
                });
            }
            self.confirmed[at] |= is_enabled;
        }
        Some((
            at,
            Told { angle_rad, speed_rad_per_s, torque_nm, supply_v: None, temperature_c, limited: false },
            trouble,
        ))
    }
}

/// The four bytes of a Damiao's register.
fn register(bus: &mut dyn Bus, id: u8, register: u8, fd: bool) -> Result<Option<[u8; 4]>, Error> {
    let ask = [id, 0, REGISTER, register, 0, 0, 0, 0];
    bus.send(&[can::frame(REGISTERS, &ask, fd)]).map_err(|cause| cause.to_string())?;
    can::next(bus, Instant::now() + PATIENCE, |frame| match frame.payload() {
        [who, _, REGISTER, which, value @ ..] if (*who, *which) == (id, register) => value.try_into().ok(),
        _ => None,
    })
}

/// Damiaos of this model after their checks, and how long they hold a force after the last frame, s: none if one holds it indefinitely.
fn checked(bus: &mut dyn Bus, model: Model, ids: &[u8]) -> Result<(Mit, Option<f64>), Error> {
    // An interface that carries no such frames refuses them.
    let mut answers = |fd| ids.first().is_some_and(|id| matches!(register(bus, *id, TIMEOUT, fd), Ok(Some(_))));
    let fd = !answers(false) && answers(true);
    let mut said = |id: u8, which: u8| register(bus, id, which, fd)?.ok_or_else(|| Error::from(motors::silent(id)));
    let mut motors = Mit::new(model, ids, fd);
    let mut longest_s: Option<f64> = Some(0.0);
    for (id, own) in ids.iter().zip(&mut motors.models) {
        let mode = u32::from_le_bytes(said(*id, CONTROL_MODE)?);
        cohold_sim::refuse_if!(
            mode != 1,
            "motor {id} is in control mode {mode}, and has to be in 1, MIT's: set its register {CONTROL_MODE}"
        );
        for (which, end) in ENDS.into_iter().zip(&mut own.ends) {
            let wanted = std::mem::replace(end, f32::from_le_bytes(said(*id, which)?).into());
            cohold_sim::refuse_if!(
                (*end / wanted - 1.0).abs() > 1e-3,
                "motor {id} is no {}, or set up differently: its register {which} is {end}, and has to be {wanted}",
                model.name
            );
            cohold_sim::refuse_if!(!(1e-3..1e4).contains(end), "motor {id}: its register {which} is {end}, no range");
        }
        let units = u32::from_le_bytes(said(*id, TIMEOUT)?);
        longest_s = longest_s.filter(|_| units > 0).map(|longest_s| longest_s.max(TIMEOUT_S * f64::from(units)));
    }
    Ok((motors, longest_s))
}

/// The motors' type, where it is said.
pub(super) fn model(options: &DeviceOptions) -> Result<Option<Model>, String> {
    let Some(name) = options.model.as_deref() else { return Ok(None) };
    let known = || MODELS.map(|model| model.name).join(", ");
    let found = MODELS.into_iter().find(|model| model.name == name);
    found.map(Some).ok_or_else(|| format!("--device-model {name}: it is one of {}", known()))
}

/// The motors at this place, which drive the mechanism of these settings.
///
/// # Errors
/// One does not answer, or has other ranges than its model; or they do not fit the mechanism.
pub(super) fn open(at: &str, options: &DeviceOptions, settings: &Settings) -> Result<Box<dyn Port>, Error> {
    motors::open("MIT motors", (at, options, settings), |bus, ids, most_nm| {
        let model = model(options)?.ok_or("their type is not said: --device-model")?;
        let (protocol, lets_go_s) = match model.is_damiao {
            true => checked(bus, model, &ids)?,
            false => (Mit::new(model, &ids, false), options.lets_go_s),
        };
        let most_nm = protocol.models.iter().fold(most_nm, |most_nm, model| most_nm.min(model.ends[2]));
        // No motor of these says that it has a home.
        Ok(Ready { protocol, name: model.name, is_homed: false, lets_go_s, most_nm })
    })
}

#[cfg(test)]
#[path = "../tests/inside/mit.rs"]
mod tests;
