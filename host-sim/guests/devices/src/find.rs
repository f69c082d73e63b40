//! What is attached to this machine: Haply's service, serial ports with an fdcanusb and the moteus motors behind them, CAN interfaces.
//!
//! Only what asks and commands nothing is sent: a query to each of the identifiers `IDS`, which a motor answers as it stands. Motors with MIT's
//! frame answer commands alone, so they are not looked for.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use cohold_live::devices::Found;

use super::{haply, moteus};

/// Identifiers that are asked for on a bus.
const IDS: std::ops::RangeInclusive<u8> = 1..=8;
/// Where the system names serial ports by what they say of themselves.
const SERIAL: &str = "/dev/serial/by-id";
const INTERFACES: &str = "/sys/class/net";
/// Type of a CAN interface (ARPHRD_CAN).
const CAN_INTERFACE: &str = "280";

fn children(folder: &str) -> Vec<PathBuf> {
    let mut all: Vec<_> = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    all.sort();
    all
}

/// The motors on a bus, or why they cannot be asked.
fn on_bus(at: &str) -> Found {
    let what = match moteus::found(at, IDS) {
        Ok(motors) if motors.is_empty() => {
            format!("a bus on which no moteus from {} to {} answers", IDS.start(), IDS.end())
        }
        Ok(motors) => {
            let each =
                motors.iter().map(|(id, supply_v, warm_c)| format!("moteus {id} ({supply_v:.1} V, {warm_c:.0} °C)"));
            each.collect::<Vec<_>>().join(", ")
        }
        Err(cause) => cause.to_string(),
    };
    Found { device: format!("moteus:{at}"), what }
}

fn is_can(interface: &Path) -> bool {
    std::fs::read_to_string(interface.join("type")).is_ok_and(|kind| kind.trim() == CAN_INTERFACE)
}

/// Whether a place beside is an address of a service.
fn is_service(place: &str) -> bool {
    place.parse::<SocketAddr>().is_ok()
}

/// What Haply's service lists, where it usually listens and at these addresses.
pub(super) fn services(beside: &[String]) -> Vec<Found> {
    let others = beside.iter().map(String::as_str).filter(|place| is_service(place));
    let of_service = |at: &str| {
        let listed = at.parse().ok().and_then(|address| haply::found(address).ok());
        listed.into_iter().flatten().map(|what| Found { device: format!("haply:{at}"), what }).collect::<Vec<_>>()
    };
    std::iter::once(haply::LISTENS).chain(others).flat_map(of_service).collect()
}

/// The moteus motors on the buses of this machine, and at these serial ports, sockets and interfaces.
pub(super) fn buses(beside: &[String]) -> Vec<Found> {
    let serial = children(SERIAL).into_iter().filter(|path| path.to_string_lossy().contains("fdcanusb"));
    let interfaces = children(INTERFACES).into_iter().filter(|path| is_can(path));
    let names = interfaces.filter_map(|path| path.file_name().map(|name| name.to_string_lossy().into_owned()));
    let others = beside.iter().filter(|place| !is_service(place)).cloned();
    serial.map(|path| path.display().to_string()).chain(names).chain(others).map(|at| on_bus(&at)).collect()
}
