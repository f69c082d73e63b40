//! A device that is written in Python, for slow ones: asked 200 times a second at most, in a thread of its own ([`cohold_live::devices::slow`]).
//!
//! It has `read`, which gives where the hand is along each axis (m), or that and how fast it moves (m/s), and `write`, which takes as many
//! forces (N). What it can do it says by its own attributes; what it does not say it is refused for as any other device.

use std::time::Duration;

use cohold_live::devices::slow::{Asked, Row, open};
use cohold_live::devices::{AXES, Abilities, DeviceOptions, Port};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::work::refused;

/// The object, and what it says of itself.
pub(crate) struct PythonDevice {
    object: Py<PyAny>,
    abilities: Abilities,
}

/// An attribute, if it is there.
fn told<T>(object: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<T>>
where
    T: for<'a, 'py> FromPyObject<'a, 'py, Error = PyErr>,
{
    let value = object.getattr_opt(name)?.filter(|value| !value.is_none());
    value.map(|value| value.extract::<T>()).transpose()
}

/// One number for each axis, from a sequence of them.
fn row(given: &Bound<'_, PyAny>, axes: usize) -> PyResult<Row> {
    let numbers: Vec<f64> = given.try_iter()?.map(|number| number?.extract::<f64>()).collect::<PyResult<_>>()?;
    if numbers.len() != axes {
        let many = numbers.len();
        return Err(refused(format!("read gave {many} numbers: it must give {axes}, one for each axis of the device")));
    }
    Ok(std::array::from_fn(|axis| numbers.get(axis).copied().unwrap_or_default()))
}

impl PythonDevice {
    /// This object as a device.
    pub(crate) fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        let calls = |name: &str| object.getattr_opt(name).is_ok_and(|method| method.is_some_and(|it| it.is_callable()));
        if let Some(missing) = ["read", "write"].into_iter().find(|name| !calls(name)) {
            let kind = object.get_type().name()?;
            let must = "a device is a name, as simulated, or an object with read() and write(force_n)";
            return Err(refused(format!("device of type {kind} has no method {missing}: {must}")));
        }
        let kind = object.get_type().name()?.to_string();
        let axes = told::<usize>(object, "axes")?.unwrap_or(1);
        if !(1..=AXES).contains(&axes) {
            return Err(refused(format!("axes = {axes} of the device is not allowed: it must be from 1 to {AXES}")));
        }
        let workspace_m = object.getattr_opt("workspace_m")?.filter(|given| !given.is_none());
        let abilities = Abilities {
            name: told::<String>(object, "name")?.unwrap_or(kind),
            axes,
            workspace_m: workspace_m.map(|given| row(&given, axes)).transpose()?,
            max_force_n: told(object, "max_force_n")?,
            is_homed: told(object, "is_homed")?.unwrap_or_default(),
            buttons: 0,
            lets_go_s: told(object, "lets_go_s")?,
        };
        Ok(Self { object: object.clone().unbind(), abilities })
    }

    /// Begins to ask it; what its own attributes leave open may have been told beside it.
    pub(crate) fn open(&self, options: &DeviceOptions) -> Result<Box<dyn Port>, cohold_live::Error> {
        let gone = "the interpreter has ended";
        let object = Python::try_attach(|py| self.object.clone_ref(py)).ok_or(gone)?;
        let mut abilities = self.abilities.clone();
        abilities.is_homed |= options.is_homed;
        abilities.lets_go_s = abilities.lets_go_s.or(options.lets_go_s);
        let (axes, silent) = (abilities.axes, Duration::from_secs_f64(options.silent_s));
        Ok(Box::new(open(abilities, silent, Asks { object, axes })?))
    }
}

/// What the device's thread has of it.
struct Asks {
    object: Py<PyAny>,
    axes: usize,
}

impl Asks {
    /// What a call gives; what it raises in words.
    fn call<T>(&self, call: impl FnOnce(Python<'_>, &Bound<'_, PyAny>) -> PyResult<T>) -> Result<T, String> {
        let answer = Python::try_attach(|py| {
            call(py, self.object.bind(py)).map_err(|error| {
                let kind = error.get_type(py).name().map_or_else(|_| "an error".to_owned(), |name| name.to_string());
                format!("{kind}: {}", error.value(py))
            })
        });
        answer.unwrap_or_else(|| Err("the interpreter has ended".to_owned()))
    }
}

impl Asked for Asks {
    fn read(&mut self) -> Result<(Row, Option<Row>), String> {
        let axes = self.axes;
        self.call(|_, object| {
            let given = object.call_method0("read")?;
            let first = given.try_iter()?.next().transpose()?;
            // Two rows, and not one.
            if first.is_some_and(|first| first.try_iter().is_ok()) {
                let rows: Vec<Bound<'_, PyAny>> = given.try_iter()?.collect::<PyResult<_>>()?;
                let [places, speeds] = rows.as_slice() else {
                    return Err(refused(format!(
                        "read gave {} rows: they must be places, or places and speeds",
                        rows.len()
                    )));
                };
                return Ok((row(places, axes)?, Some(row(speeds, axes)?)));
            }
            Ok((row(&given, axes)?, None))
        })
    }

    fn write(&mut self, force_n: Row) -> Result<(), String> {
        let axes = self.axes;
        self.call(|py, object| {
            object.call_method1("write", (PyTuple::new(py, &force_n[..axes])?,))?;
            Ok(())
        })
    }
}
