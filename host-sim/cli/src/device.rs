//! The flags of a device that is really there: what is told about it, which is in no table of the scene.

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{Args, Parser};
use cohold_live::devices::{AXES, Adapter, BUTTONS, DeviceOptions, Kind, board};
use cohold_live::key_file;
use cohold_protocol::key::Role;

use super::address::endpoint;
use super::flags::{SceneArgs, number};
use super::{Failure, Ui, refusal};
use crate::live_peer::OF_A_HAND;

/// Names of a device's axes.
const NAMES: [&str; AXES] = ["x", "y", "z"];

/// The device of a peer, and what is told about it.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Device")]
pub struct DeviceArgs {
    /// The device of this peer: `simulated`, the scene's; `board:ADDRESS:PORT`, a board that was told the scene `board-device`; or an adapter with
    /// its place: `haply[:ADDRESS:PORT]`, an Inverse3 behind its local service; `moteus:BUS` or `mit:BUS`, motors on a CAN bus: a serial port with
    /// an fdcanusb, as /dev/ttyACM0, or an interface, as can0.
    #[arg(long, value_name = "KIND[:PLACE]", default_value = "simulated")]
    device: String,
    /// Which of several devices, by its own name; the first without it.
    #[arg(long, value_name = "ID")]
    device_id: Option<String>,
    /// Axes of the device that the scene's x, y and z are, `-` before one that points the other way.
    #[arg(long, value_name = "AXIS,AXIS,AXIS", default_value = "x,y,z", value_parser = axes, allow_hyphen_values = true)]
    device_axes: Axes,
    /// Where the scene's start is in the device's frame, along its x, y and z, m; without it where the hand is at first.
    #[arg(long, value_name = "M,M,M", value_parser = place, allow_hyphen_values = true)]
    device_origin_m: Option<Place>,
    /// After so long without a new reading the motors are off, s; from half of it on the force fades.
    #[arg(long, value_name = "S", default_value_t = 0.05, value_parser = number(0.005..=1.0, "s"))]
    device_silent_s: f64,
    /// How long the device holds a force after the last command, s: as it was measured, without which a device that does not say is not
    /// armed; as moteus motors are told, 0.05 without it.
    #[arg(long, value_name = "S", value_parser = number(0.001..=0.25, "s"))]
    device_lets_go_s: Option<f64>,
    /// The button that holds the clutch open while it is down.
    #[arg(long, value_name = "BUTTON", value_parser = BUTTONS)]
    device_clutch: Option<String>,
    /// Motors: the identifier of each joint's, in the order of the joints, `-` before one that turns against its joint.
    #[arg(long, value_name = "ID,…", default_value = "1", value_parser = motors, allow_hyphen_values = true)]
    device_motors: Motors,
    /// Motors: the largest torque of each, N·m.
    #[arg(long, value_name = "N·M", value_parser = number(0.001..=200.0, "N·m"))]
    device_max_torque_nm: Option<f64>,
    /// Motors with MIT's frame: their type.
    #[arg(long, value_name = "TYPE")]
    device_model: Option<String>,
    /// A board: the file of the key that it shares with its peer.
    #[arg(long, value_name = "FILE")]
    device_key_file: Option<PathBuf>,
    /// A board: where its flow is listened to, and so where it sends it.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint, default_value = "0.0.0.0:7701")]
    device_listen: SocketAddr,
    /// A board: the scene that it was told.
    #[arg(long, value_name = "NAME|FILE", default_value = board::SCENE)]
    device_scene: PathBuf,
    /// The device is homed, by your word: for one that does not say so itself.
    #[arg(long)]
    device_homed: bool,
}

/// Identifier of each joint's motor, and its sign.
#[derive(Clone, Debug)]
struct Motors(Vec<(u8, f64)>);
/// Axis of the device, and its sign, for each of the scene's.
type Axes = [(usize, f64); AXES];
/// Along the device's axes, m.
type Place = [f64; AXES];

fn motors(text: &str) -> Result<Motors, String> {
    let one = |word: &str| {
        let (id, sign) = word.strip_prefix('-').map_or((word, 1.0), |id| (id, -1.0));
        id.parse().ok().filter(|id: &u8| (1..=126).contains(id)).map(|id| (id, sign))
    };
    let found: Option<Vec<_>> = text.split(',').map(one).collect();
    let differ = |all: &Vec<(u8, _)>| all.iter().map(|(id, _)| id).collect::<BTreeSet<_>>().len() == all.len();
    let fit = found.filter(|all| all.len() <= AXES && differ(all)).map(Motors);
    fit.ok_or_else(|| "one to three different identifiers from 1 to 126, as 1,-2".to_owned())
}

fn axes(text: &str) -> Result<Axes, String> {
    let allowed = || "three different ones of x, y and z, as x,z,-y".to_owned();
    let axis = |word: &str| {
        let (name, sign) = word.strip_prefix('-').map_or((word, 1.0), |name| (name, -1.0));
        NAMES.iter().position(|known| *known == name).map(|at| (at, sign))
    };
    let found: Option<Vec<_>> = text.split(',').map(axis).collect();
    let found: Axes = found.and_then(|found| found.try_into().ok()).ok_or_else(allowed)?;
    let mut seen = found.map(|(axis, _)| axis);
    seen.sort_unstable();
    if seen == [0, 1, 2] { Ok(found) } else { Err(allowed()) }
}

fn place(text: &str) -> Result<Place, String> {
    let number = |word: &str| word.parse().ok().filter(|place: &f64| place.abs() <= 10.0);
    let found: Option<Vec<f64>> = text.split(',').map(number).collect();
    found.and_then(|found| found.try_into().ok()).ok_or_else(|| "three numbers within ±10, as 0,-0.1,0.15".to_owned())
}

/// These flags alone.
#[derive(Debug, Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct Alone {
    #[command(flatten)]
    device: DeviceArgs,
}

/// A device by the words that follow `peer`, from `--device` on, that one of these adapters may open: for a face that has no command line.
///
/// # Errors
/// A word that is not known, or a value that is not allowed.
pub fn device_options(words: &[String], adapters: &[Adapter]) -> Result<DeviceOptions, Failure> {
    let alone = Alone::try_parse_from(words).map_err(|error| refusal(&error))?;
    alone.device.wanted(&Ui { devices: adapters.to_vec(), ..Ui::new() })
}

impl DeviceArgs {
    fn refused(&self, why: &dyn std::fmt::Display) -> Failure {
        format!("--device {} is not allowed: {why}", self.device).into()
    }

    fn kind(&self, ui: &Ui) -> Result<Kind, Failure> {
        let (name, at) = self.device.split_once(':').unwrap_or((&self.device, ""));
        if let Some(adapter) = ui.devices.iter().find(|adapter| adapter.name == name) {
            return Ok(Kind::Adapted(*adapter, at.to_owned()));
        }
        match name {
            "simulated" if at.is_empty() => Ok(Kind::Simulated),
            "board" => {
                let at = endpoint(at).map_err(|cause| self.refused(&cause))?;
                let file = self.device_key_file.as_ref().ok_or_else(|| self.refused(&"it needs --device-key-file"))?;
                let key = key_file::read(file, Role::Peers)?;
                let scene = Box::new(SceneArgs::of(&self.device_scene).load(ui)?);
                Ok(Kind::Board(Box::new(board::Told { at, listen: self.device_listen, key, scene })))
            }
            _ => {
                let others = ui.devices.iter().map(|Adapter { name, place, .. }| format!(", {name}{place}"));
                Err(self.refused(&format!("it is simulated, board:ADDRESS:PORT{}", others.collect::<String>())))
            }
        }
    }

    /// As a peer takes it.
    pub fn wanted(&self, ui: &Ui) -> Result<DeviceOptions, Failure> {
        let clutch = self.device_clutch.as_deref();
        let options = DeviceOptions {
            kind: self.kind(ui)?,
            id: self.device_id.clone(),
            axes: self.device_axes,
            origin_m: self.device_origin_m,
            silent_s: self.device_silent_s,
            lets_go_s: self.device_lets_go_s,
            clutch: clutch.and_then(|name| BUTTONS.iter().position(|known| *known == name)),
            motors: self.device_motors.0.clone(),
            max_torque_nm: self.device_max_torque_nm,
            model: self.device_model.clone(),
            is_homed: self.device_homed,
        };
        if let Kind::Adapted(adapter, at) = &options.kind {
            (adapter.check)(at, &options).map_err(|why| self.refused(&why))?;
        }
        Ok(options)
    }

    /// What peer `number` of a scene is set to for the hand at its device, under what is said; nothing of a simulated one.
    pub fn beneath(&self, number: u8) -> Vec<(&'static str, String)> {
        if self.device == "simulated" {
            return Vec::new();
        }
        OF_A_HAND.iter().map(|(key, most)| (*key, format!("peer.{number}.{key}={most}"))).collect()
    }
}
