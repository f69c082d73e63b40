//! What the users of a pair push with, as Python gives it: of each user a number in a tick, or as many as there are shared axes.

use cohold_sim::run::AXIS_NAMES;
use numpy::ndarray::{Axis, Ix3};
use numpy::{PyArrayDyn, PyArrayMethods as _, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

use crate::run::MOST_ROWS;
use crate::work::refused;

/// Most axes along which an object is shared.
pub(crate) const MOST_AXES: usize = AXIS_NAMES.len();
/// Ticks whose forces are taken over before Ctrl-C is looked for.
const PART: usize = 1 << 16;

/// As far as `user.1.push_n` goes, too.
const LARGEST_N: f64 = 1000.0;

/// A force that is no number is refused, and none that no hand has.
pub(crate) fn check(forces: &[f64]) -> PyResult<()> {
    let wrong = forces.iter().find(|force| force.is_nan() || force.abs() > LARGEST_N);
    wrong.map_or(Ok(()), |force| {
        let must = format!("it must be a number from -{LARGEST_N} to {LARGEST_N} N");
        Err(refused(format!("force = {force} is not allowed: {must}")))
    })
}

/// A quantity along the shared axes in a tick as Python gives it: a number, or so many.
pub(crate) enum Along {
    One(f64),
    Several([f64; MOST_AXES], usize),
}

impl<'py> FromPyObject<'_, 'py> for Along {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let not_one = match given.extract() {
            Ok(force) => return Ok(Self::One(force)),
            Err(not_one) => not_one,
        };
        let Ok(count) = given.len() else { return Err(not_one) };
        let mut forces = [0.0; MOST_AXES];
        for (at, force) in forces.iter_mut().enumerate().take(count) {
            *force = given.get_item(at)?.extract()?;
        }
        Ok(Self::Several(forces, count))
    }
}

impl Along {
    /// What it is along each of these shared axes.
    pub(crate) fn along(self, name: &str, axes: &mut [f64]) -> PyResult<()> {
        let given = match self {
            Self::One(force) if axes.len() == 1 => {
                axes[0] = force;
                return Ok(());
            }
            Self::Several(forces, count) if axes.len() > 1 && count == axes.len() => {
                axes.copy_from_slice(&forces[..count]);
                return Ok(());
            }
            Self::One(force) => format!("= {force}"),
            Self::Several(_, count) => format!("of shape ({count},)"),
        };
        let must = match axes.len() {
            1 => "it must be a number".to_owned(),
            several => format!("it must have shape ({several},), a number for each shared axis"),
        };
        Err(refused(format!("{name} {given} is not allowed: {must}")))
    }
}

/// A shape as Python writes it.
pub(crate) fn written(shape: &[usize]) -> String {
    let sizes = shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    if shape.len() == 1 { format!("({sizes},)") } else { format!("({sizes})") }
}

/// An empty vector with room for so many.
pub(crate) fn room<T>(count: Option<usize>) -> PyResult<Vec<T>> {
    let mut room = Vec::new();
    let made = count.and_then(|count| room.try_reserve_exact(count).ok());
    made.map(|()| room).ok_or_else(|| PyMemoryError::new_err("there is no room for so many numbers"))
}

/// Forces of a tick along so many axes, user 1's first; the rest of the array is nothing.
pub(crate) fn of_tick(pushes: [Along; 2], axes: usize) -> PyResult<[f64; 2 * MOST_AXES]> {
    let mut forces = [0.0; 2 * MOST_AXES];
    let named = pushes.into_iter().zip(["force_1_n", "force_2_n"]);
    for ((push, name), along) in named.zip(forces.chunks_exact_mut(axes)) {
        push.along(name, along)?;
    }
    check(&forces)?;
    Ok(forces)
}

/// Refuses an array whose numbers do not lie where numbers may lie in memory.
pub(crate) fn aligned(name: &str, array: &Bound<'_, PyArrayDyn<f64>>) -> PyResult<()> {
    let off = array
        .strides()
        .iter()
        .map(|stride| stride.unsigned_abs())
        .fold(array.data().addr(), |off, stride| off | stride);
    if off % align_of::<f64>() == 0 {
        return Ok(());
    }
    Err(refused(format!(
        "{name} is not aligned in memory: numpy.require({name}, requirements=\"A\") makes an array that is"
    )))
}

/// The same of many ticks, one after the other, from an array whose rows they are.
pub(crate) fn of_ticks(py: Python<'_>, forces_n: &PyReadonlyArrayDyn<'_, f64>, axes: usize) -> PyResult<Vec<f64>> {
    let row = [2, axes];
    let row = if axes == 1 { &row[..1] } else { &row };
    let Some((&rows, _)) = forces_n.shape().split_first().filter(|(_, given)| *given == row) else {
        let given = written(forces_n.shape());
        let must = match axes {
            1 => "(ticks, 2), user 1 and user 2".to_owned(),
            several => format!("(ticks, 2, {several}), user 1 and user 2 along each shared axis"),
        };
        return Err(refused(format!("forces_n of shape {given} is not allowed: it must have shape {must}")));
    };
    aligned("forces_n", forces_n)?;
    // A view may have many more rows than there is memory.
    if rows > MOST_ROWS {
        let must = format!("it must have at most {MOST_ROWS}");
        return Err(refused(format!("forces_n of {rows} rows is not allowed: {must}")));
    }
    let mut own = room(rows.checked_mul(2 * axes))?;
    let forces = forces_n.as_array();
    let forces = if axes == 1 { forces.insert_axis(Axis(2)) } else { forces };
    let forces = forces.into_dimensionality::<Ix3>().map_err(refused)?;
    for part in forces.axis_chunks_iter(Axis(0), PART) {
        // However it lies in memory.
        match part.as_slice() {
            Some(numbers) => own.extend_from_slice(numbers),
            None => own.extend(part.iter()),
        }
        check(&own[own.len() - part.len()..])?;
        py.check_signals()?;
    }
    Ok(own)
}
