//! moteus motors (mjbots): one to three on a CAN bus with flexible data rate, behind an fdcanusb or SocketCAN, by the public register map.
//!
//! **A torque** is a position command (mode 10) without a position: the scales of stiffness, damping and integrator 0, a feed-forward torque,
//! the largest torque, and the watchdog. Each frame asks in return for mode, position, speed, torque, supply, temperature and fault.
//!
//! **Letting go.** Without a new command for [`DeviceOptions::lets_go_s`], which goes in every frame, a motor is in mode 11, and stays in it until it
//! is told to stop. What it does there is its own setting, `servo.timeout_mode`: one that holds its position (10) is refused, and so is one that
//! does not say. Told to let go, it is stopped (mode 0): its windings are free.
//!
//! Units: N·m of the output, revolutions of it, V, °C. At 1 and 5 Mbit/s a motor takes about 0.22 ms a tick: three go at 1 kHz.

use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use cohold_core::settings::Settings;
use cohold_sim::device::{DeviceFault, Gone};
use moteus_protocol::command::{PositionCommand, PositionFormat, StopCommand};
use moteus_protocol::diagnostic::{parse_server_to_client, write_client_poll, write_client_to_server};
use moteus_protocol::query::{QueryFormat, QueryResult};
use moteus_protocol::{CanFdFrame, HomeState, Mode, Resolution, calculate_arbitration_id, parse_arbitration_id};

use cohold_live::Error;
use cohold_live::devices::{DeviceOptions, Port};

use super::can::{self, Bus};
use super::motors::{self, Protocol, Ready, Told};

/// Until when a motor stops after the last frame, s, where nobody says: what a PC without real-time priority keeps.
pub(crate) const WATCHDOG_S: f64 = 0.05;
/// Channel of the console that the motors' own settings are read by.
const CONSOLE: u8 = 1;
/// How long a motor's console may take.
const PATIENCE: Duration = Duration::from_millis(500);
/// What a motor may do after its watchdog: stop, damp, brake.
const HARMLESS: [&str; 3] = ["0", "12", "15"];

/// The motors by their identifiers.
struct Moteus {
    ids: Vec<u8>,
    watchdog_s: f64,
    most_nm: f64,
}

/// Why a motor is in mode 1, by the code that it tells.
fn fault(code: i8) -> (DeviceFault, &'static str) {
    match code {
        32 => (DeviceFault::Motor, "its calibration failed"),
        33 => (DeviceFault::Motor, "its bridge's driver failed: often too little supply"),
        34 => (DeviceFault::Supply, "over-voltage: a hand pushes energy back"),
        35 => (DeviceFault::Motor, "its encoder"),
        36 => (DeviceFault::Motor, "it is not configured"),
        37 => (DeviceFault::Motor, "its control loop overran"),
        38 => (DeviceFault::TooWarm, "too warm"),
        39 => (DeviceFault::Motor, "outside of its own limits of position"),
        40 => (DeviceFault::Supply, "under-voltage"),
        41 => (DeviceFault::Motor, "its settings changed"),
        42 | 43 => (DeviceFault::Motor, "its angle or position is not valid"),
        44 => (DeviceFault::Motor, "its bridge's driver cannot be enabled"),
        45 => (DeviceFault::Motor, "a stop position was asked for"),
        46 => (DeviceFault::Motor, "its control loop was late"),
        47 => (DeviceFault::Motor, "feed-forward of its back-EMF needs a limit of acceleration"),
        48 => (DeviceFault::Motor, "its limits of position are not valid"),
        49 => (DeviceFault::Motor, "too far from its position"),
        50 => (DeviceFault::Motor, "too far from its speed"),
        _ => (DeviceFault::Motor, "moteus' register map says which"),
    }
}

impl Moteus {
    fn to(&self, at: usize) -> CanFdFrame {
        let mut frame = CanFdFrame::new();
        frame.arbitration_id = calculate_arbitration_id(0, self.ids[at].cast_signed(), 0, true);
        frame
    }
}

impl Protocol for Moteus {
    fn command(&mut self, at: usize, torque_nm: Option<f64>, frames: &mut Vec<CanFdFrame>) {
        let mut frame = self.to(at);
        match torque_nm {
            // What is a number in a Rust program is one on the bus; what is none lets go.
            Some(torque_nm) if torque_nm.is_finite() => {
                let mut format = PositionFormat::default();
                (format.position, format.velocity) = (Resolution::Int8, Resolution::Int8);
                (format.kp_scale, format.kd_scale) = (Resolution::Int8, Resolution::Int8);
                format.ilimit_scale = Resolution::Int8;
                PositionCommand::new()
                    .position(f32::NAN)
                    .velocity(0.0)
                    .kp_scale(0.0)
                    .kd_scale(0.0)
                    .ilimit_scale(0.0)
                    .feedforward_torque(torque_nm as f32)
                    .maximum_torque(self.most_nm as f32)
                    .watchdog_timeout(self.watchdog_s as f32)
                    .serialize(&mut frame, &format);
            }
            _ => StopCommand::serialize(&mut frame),
        }
        QueryFormat::default().serialize(&mut frame);
        frames.push(frame);
    }

    fn ask(&self, at: usize) -> CanFdFrame {
        let mut frame = self.to(at);
        QueryFormat::default().serialize(&mut frame);
        frame
    }

    fn hear(&mut self, frame: &CanFdFrame) -> Option<(usize, Told, Option<Gone>)> {
        let (from, to, _) = parse_arbitration_id(frame.arbitration_id);
        let at = self.ids.iter().position(|id| id.cast_signed() == from).filter(|_| to == 0)?;
        let told = QueryResult::parse(frame);
        let id = self.ids[at];
        let wrong = match told.mode {
            Mode::Stopped | Mode::Enabling | Mode::Position => None,
            Mode::Fault => {
                let (which, cause) = fault(told.fault);
                Some(Gone::new(which, format!("motor {id}, its fault {}: {cause}", told.fault)))
            }
            Mode::Timeout => Some(Gone::new(
                DeviceFault::LetGo,
                format!("motor {id} had no command for {} ms", 1e3 * self.watchdog_s),
            )),
            mode => Some(Gone::new(
                DeviceFault::Stopped,
                format!("motor {id} is in mode {mode:?}, which this peer did not ask for"),
            )),
        };
        let said = Told {
            angle_rad: TAU * f64::from(told.position),
            speed_rad_per_s: TAU * f64::from(told.velocity),
            torque_nm: told.torque.into(),
            supply_v: Some(told.voltage.into()),
            temperature_c: told.temperature.into(),
            // 96 to 103 of a motor that goes on.
            limited: told.mode == Mode::Position && (96..=103).contains(&told.fault),
        };
        Some((at, said, wrong))
    }
}

/// The next answer of this motor.
fn answer(bus: &mut dyn Bus, id: u8, by: Instant) -> Result<Option<CanFdFrame>, Error> {
    let of = |frame: &CanFdFrame| parse_arbitration_id(frame.arbitration_id).0 == id.cast_signed();
    can::next(bus, by, |frame| of(frame).then(|| frame.clone()))
}

/// Writes this line to a motor's console. Without a line it reads the next text, which may be empty: none if the motor does not answer.
fn console(bus: &mut dyn Bus, id: u8, line: Option<&str>, by: Instant) -> Result<Option<Vec<u8>>, Error> {
    let mut out = [0; 64];
    let len = match line {
        Some(line) => write_client_to_server(CONSOLE, line.as_bytes(), &mut out),
        None => write_client_poll(CONSOLE, 48, &mut out),
    };
    let to = calculate_arbitration_id(0, id.cast_signed(), 0, line.is_none());
    let asks = can::frame(to, &out[..usize::from(len)], true);
    bus.send(&[asks]).map_err(|cause| cause.to_string())?;
    let told = if line.is_none() { answer(bus, id, by)? } else { None };
    Ok(told.map(|frame| parse_server_to_client(frame.payload(), CONSOLE).unwrap_or_default().to_vec()))
}

/// What a motor's console answers to `conf get` of this setting.
fn setting(bus: &mut dyn Bus, id: u8, name: &str) -> Result<Option<String>, Error> {
    let by = Instant::now() + PATIENCE;
    // A viewer may have left its telemetry on.
    console(bus, id, Some("tel stop\n"), by)?;
    while console(bus, id, None, by)?.is_some_and(|text| !text.is_empty()) {}
    console(bus, id, Some(&format!("conf get {name}\n")), by)?;
    let mut text = Vec::new();
    while let Some(more) = console(bus, id, None, by)? {
        text.extend(more);
        if let Some(end) = text.iter().position(|byte| *byte == b'\n') {
            return Ok(Some(String::from_utf8_lossy(&text[..end]).trim().to_owned()));
        }
    }
    Ok(None)
}

/// The motors with these identifiers that answer on a bus, each with its supply (V) and temperature (°C).
///
/// # Errors
/// There is no such bus.
pub(super) fn found(at: &str, ids: impl IntoIterator<Item = u8>) -> Result<Vec<(u8, f64, f64)>, Error> {
    let mut bus = can::open(at)?;
    let mut found = Vec::new();
    for id in ids {
        let asks = Moteus { ids: vec![id], watchdog_s: WATCHDOG_S, most_nm: 0.0 }.ask(0);
        bus.send(&[asks]).map_err(|cause| cause.to_string())?;
        if let Some(frame) = answer(&mut *bus, id, Instant::now() + Duration::from_millis(20))? {
            let told = QueryResult::parse(&frame);
            found.push((id, told.voltage.into(), told.temperature.into()));
        }
    }
    Ok(found)
}

/// The motors at this place, which drive the mechanism of these settings.
///
/// # Errors
/// One does not answer, would hold its position after its watchdog, or has no home; or they do not fit the mechanism.
pub(super) fn open(at: &str, options: &DeviceOptions, settings: &Settings) -> Result<Box<dyn Port>, Error> {
    motors::open("moteus", (at, options, settings), |bus, ids, most_nm| {
        let mut is_homed = true;
        for id in &ids {
            let motor = Moteus { ids: vec![*id], watchdog_s: WATCHDOG_S, most_nm: 0.0 };
            let mut asks = motor.to(0);
            let mut query = QueryFormat::default();
            query.home_state = Resolution::Int8;
            query.serialize(&mut asks);
            bus.send(&[asks]).map_err(|cause| cause.to_string())?;
            let told = answer(bus, *id, Instant::now() + PATIENCE)?.ok_or_else(|| motors::silent(*id))?;
            is_homed &= QueryResult::parse(&told).home_state == HomeState::Output;
            let why = match setting(bus, *id, "servo.timeout_mode")?.as_deref() {
                Some(mode) if HARMLESS.contains(&mode) => continue,
                Some(mode) => format!(
                    "motor {id} does not let go after its watchdog: servo.timeout_mode is {mode}, and has to be 0, 12 or 15"
                ),
                None => format!(
                    "motor {id} does not say what it does after its watchdog (servo.timeout_mode): it is not armed"
                ),
            };
            return Err(why.into());
        }
        let watchdog_s = options.lets_go_s.unwrap_or(WATCHDOG_S);
        let protocol = Moteus { ids, watchdog_s, most_nm };
        Ok(Ready { protocol, name: "moteus", is_homed, lets_go_s: Some(watchdog_s), most_nm })
    })
}

#[cfg(test)]
#[path = "../tests/inside/moteus.rs"]
mod tests;
