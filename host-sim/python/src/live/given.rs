//! What a live peer is given, in the command line's words.

use std::net::SocketAddr;
use std::sync::Arc;

use cohold_cli::live_peer::{self, OF_A_HAND};
use cohold_live::devices::{DeviceOptions, Kind, Own};
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::device::PythonDevice;
use crate::scene::{Named, Scene};
use crate::work::refused;

/// The words of a device's flags as Python's own names: `--device-axes` is `device_axes`.
fn in_python(said: &str) -> String {
    let word = |word: &str| word.strip_prefix("--").map_or_else(|| word.to_owned(), |name| name.replace('-', "_"));
    said.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

/// A value of a flag as the command line has it.
fn word(value: &Bound<'_, PyAny>) -> PyResult<String> {
    let is_row = !value.is_instance_of::<PyString>() && value.try_iter().is_ok();
    if !is_row {
        return Ok(value.str()?.to_string());
    }
    let parts: PyResult<Vec<String>> = value.try_iter()?.map(|part| Ok(part?.str()?.to_string())).collect();
    Ok(parts?.join(","))
}

/// The device that is meant: by the command line's name, or an object of Python's.
pub(super) fn device_of(given: &Bound<'_, PyAny>, settings: Option<Named<'_>>) -> PyResult<DeviceOptions> {
    let name = given.extract::<String>().ok();
    let mut words = vec![format!("--device={}", name.as_deref().unwrap_or("simulated"))];
    for (key, value) in settings.into_iter().flat_map(|all| all.0) {
        let flag = key.strip_prefix("device_").map(|rest| format!("--device-{}", rest.replace('_', "-")));
        let flag = flag.ok_or_else(|| {
            refused(format!("{key} is not known: what is told of a device begins with device_, as device_axes"))
        })?;
        match value.extract::<bool>() {
            Ok(true) => words.push(flag),
            Ok(false) => {}
            Err(_) => words.push(format!("{flag}={}", word(&value)?)),
        }
    }
    let options = live_peer::device_options(&words, &cohold_devices::ADAPTERS)
        .map_err(|why| refused(in_python(&why.to_string())))?;
    if name.is_some() {
        return Ok(options);
    }
    let device = PythonDevice::of(given)?;
    Ok(DeviceOptions { kind: Kind::Own(Own(Arc::new(move |options| device.open(options)))), ..options })
}

/// Limits peer `number` for the hand at its device, where the scene says nothing of its own.
pub(super) fn limit(scene: &mut Scene, number: u8) -> PyResult<()> {
    let says = scene.to_toml();
    let named = |key: &str| says.lines().any(|line| line.starts_with(&format!("{key} = ")));
    for (key, most) in OF_A_HAND {
        let own = format!("peer.{number}.{key}");
        if !named(key) && !named(&own) {
            scene.scene.set(&own, &toml::Value::Float(most), "scene", None).map_err(refused)?;
        }
    }
    Ok(())
}

pub(super) fn address(name: &str, text: &str) -> PyResult<SocketAddr> {
    text.parse().map_err(|_| {
        refused(format!("{name} = \"{text}\" is not allowed: it must be an address and a port, as 127.0.0.1:7001"))
    })
}
