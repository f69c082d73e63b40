//! The flags of a device that is really there: what is told about it, which is in no table of the scene.

use std::net::SocketAddr;

use clap::Args;
use haptic_live::devices::{AXES, DeviceOptions, Kind, haply};

use super::flags::number;

/// Names of a device's axes.
const NAMES: [&str; AXES] = ["x", "y", "z"];

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Device")]
pub(super) struct DeviceArgs {
    /// The device of this peer: `simulated`, the scene's, or `haply[:ADDRESS:PORT]`, an Inverse3 behind its local service.
    #[arg(long, value_name = "KIND", default_value = "simulated", value_parser = kind)]
    device: Kind,
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
    /// How long the device holds a force after the last command, as it was measured, s: without it a device that does not say is not armed.
    #[arg(long, value_name = "S", value_parser = number(0.001..=0.25, "s"))]
    device_lets_go_s: Option<f64>,
    /// The button that holds the clutch open while it is down.
    #[arg(long, value_name = "BUTTON", value_parser = haply::BUTTONS)]
    device_clutch: Option<String>,
}

/// Axis of the device, and its sign, for each of the scene's.
type Axes = [(usize, f64); AXES];
/// Along the device's axes, m.
type Place = [f64; AXES];

fn kind(text: &str) -> Result<Kind, String> {
    let (name, at) = text.split_once(':').unwrap_or((text, haply::LISTENS));
    match name {
        "simulated" if text == name => Ok(Kind::Simulated),
        "haply" => at
            .parse::<SocketAddr>()
            .map(Kind::Haply)
            .map_err(|cause| format!("{at}: {cause}, as 127.0.0.1:10001 is one")),
        _ => Err("it is simulated or haply[:ADDRESS:PORT]".to_owned()),
    }
}

fn axes(text: &str) -> Result<Axes, String> {
    let allowed = || "three different ones of x, y and z, as x,z,-y".to_owned();
    let axis = |word: &str| {
        let name = word.trim_start_matches('-');
        let sign = if word.starts_with('-') { -1.0 } else { 1.0 };
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

impl DeviceArgs {
    /// As a peer takes it.
    pub(super) fn wanted(&self) -> DeviceOptions {
        DeviceOptions {
            kind: self.device,
            id: self.device_id.clone(),
            axes: self.device_axes,
            origin_m: self.device_origin_m,
            silent_s: self.device_silent_s,
            lets_go_s: self.device_lets_go_s,
            clutch: self.device_clutch.as_ref().and_then(|name| haply::BUTTONS.iter().position(|known| known == name)),
        }
    }
}
