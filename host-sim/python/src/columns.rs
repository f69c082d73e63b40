//! Columns of a table as NumPy arrays.

use haptic_report::{Cell, Column, Columns, Values};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The unit of a column or a figure of merit, by the end of its name; empty of what has none: a count, a ratio, a flag, words.
#[pyfunction]
pub(crate) fn unit(name: &str) -> &'static str {
    Column::numbers(name, "", Vec::new()).unit()
}

/// Every column by name: numbers as float64, which take over the column's memory; counts as int64; yes and no as bool; what may be
/// missing as float64 with NaN; `texts`, and anything else, as objects, `None` where there is nothing.
pub(crate) fn to_python<'py>(py: Python<'py>, columns: Columns, texts: &[&str]) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for column in columns {
        let (name, values) = column.into_parts();
        match values {
            Values::Numbers(numbers) => all.set_item(name, numbers.into_pyarray(py))?,
            Values::Cells(cells) => {
                let array = if texts.contains(&name.as_str()) { objects(py, &cells)? } else { array(py, &cells)? };
                all.set_item(name, array)?;
            }
        }
    }
    Ok(all)
}

fn array<'py>(py: Python<'py>, cells: &[Cell]) -> PyResult<Bound<'py, PyAny>> {
    let flag = |cell: &Cell| if let Cell::Flag(flag) = cell { Some(*flag) } else { None };
    let whole = |cell: &Cell| if let Cell::Whole(count) = cell { Some(*count) } else { None };
    let number = |cell: &Cell| match cell {
        Cell::Empty => Some(f64::NAN),
        Cell::Whole(count) => Some(*count as f64),
        Cell::Number(number) => Some(*number),
        _ => None,
    };
    if let Some(flags) = cells.iter().map(flag).collect::<Option<Vec<_>>>() {
        return Ok(flags.into_pyarray(py).into_any());
    }
    if let Some(counts) = cells.iter().map(whole).collect::<Option<Vec<_>>>() {
        return Ok(counts.into_pyarray(py).into_any());
    }
    if let Some(numbers) = cells.iter().map(number).collect::<Option<Vec<_>>>() {
        return Ok(numbers.into_pyarray(py).into_any());
    }
    objects(py, cells)
}

fn objects<'py>(py: Python<'py>, cells: &[Cell]) -> PyResult<Bound<'py, PyAny>> {
    let objects: Vec<Py<PyAny>> = cells.iter().map(|cell| object(py, cell)).collect::<PyResult<_>>()?;
    Ok(PyArray1::from_vec(py, objects).into_any())
}

fn object(py: Python<'_>, cell: &Cell) -> PyResult<Py<PyAny>> {
    Ok(match cell {
        Cell::Empty => py.None(),
        Cell::Flag(flag) => flag.into_pyobject(py)?.to_owned().into_any().unbind(),
        Cell::Whole(count) => count.into_pyobject(py)?.into_any().unbind(),
        Cell::Number(number) => number.into_pyobject(py)?.into_any().unbind(),
        Cell::List(numbers) => numbers.into_pyobject(py)?.into_any().unbind(),
        Cell::Text(text) => text.into_pyobject(py)?.into_any().unbind(),
    })
}
