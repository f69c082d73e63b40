//! Columns of a table as NumPy arrays.

use cohold_report::{Cell, Column, Columns, Holds, Values};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The unit of a column or a figure of merit, by the end of its name; empty of what has none: a count, a ratio, a flag, words.
#[pyfunction]
pub(crate) fn unit(name: &str) -> &'static str {
    Column::numbers(name, "", Vec::new()).unit()
}

/// Every column by name, as what it was declared as: numbers as float64, NaN where there is none, a column of nothing else without a
/// copy; counts as int64, yes and no as bool; texts and lists as objects, `None` where there is none. NumPy has no count and no flag
/// that is missing: a column that lacks some has float64 for counts and objects for flags, as pandas reads them from Parquet.
pub(crate) fn to_python(py: Python<'_>, columns: Columns) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for column in columns {
        let (name, values) = column.into_parts();
        match values {
            Values::Numbers(numbers) => all.set_item(name, numbers.into_pyarray(py))?,
            Values::Cells(holds, cells) => all.set_item(name, array(py, holds, &cells)?)?,
        }
    }
    Ok(all)
}

fn array<'py>(py: Python<'py>, holds: Holds, cells: &[Cell]) -> PyResult<Bound<'py, PyAny>> {
    let flag = |cell: &Cell| if let Cell::Flag(flag) = cell { Some(*flag) } else { None };
    let whole = |cell: &Cell| if let Cell::Whole(count) = cell { Some(*count) } else { None };
    let number = |cell: &Cell| match cell {
        Cell::Whole(count) => *count as f64,
        Cell::Number(number) => *number,
        _ => f64::NAN,
    };
    let numbers = || cells.iter().map(number).collect::<Vec<f64>>().into_pyarray(py).into_any();
    Ok(match holds {
        Holds::Flags => match cells.iter().map(flag).collect::<Option<Vec<_>>>() {
            Some(flags) => flags.into_pyarray(py).into_any(),
            None => objects(py, cells)?,
        },
        Holds::Counts => match cells.iter().map(whole).collect::<Option<Vec<_>>>() {
            Some(counts) => counts.into_pyarray(py).into_any(),
            None => numbers(),
        },
        Holds::Numbers => numbers(),
        Holds::Lists | Holds::Texts => objects(py, cells)?,
    })
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
