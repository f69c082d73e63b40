//! Stability, as `cohold stability` computes it from the code that flies.

use cohold_analysis::{Effort, Range};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::run::html;
use crate::scene::meant;
use crate::work::{here, refused};

/// The verdict on a scene in every mode that it can enter.
#[pyclass(module = "cohold", frozen, get_all)]
pub(crate) struct Stability {
    /// Every mode is stable.
    stable: bool,
    /// The largest absolute eigenvalue over a packet period, of the worst mode.
    spectral_radius: f64,
    /// The spectral radius by who has hands on: both, one, none.
    modes: Py<PyDict>,
    /// What the scene has and the verdict leaves out, in words.
    not_judged: Vec<String>,
}

#[pymethods]
impl Stability {
    /// From what it holds.
    #[staticmethod]
    fn _of(stable: bool, spectral_radius: f64, modes: Py<PyDict>, not_judged: Vec<String>) -> Self {
        Self { stable, spectral_radius, modes, not_judged }
    }

    /// Pickled as what it holds.
    fn __reduce__<'py>(slf: &Bound<'py, Self>, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let held = ["stable", "spectral_radius", "modes", "not_judged"].map(|name| slf.getattr(name));
        let held = held.into_iter().collect::<PyResult<Vec<_>>>()?;
        (slf.get_type().getattr("_of")?, PyTuple::new(py, held)?).into_pyobject(py)
    }

    /// Every mode with its spectral radius, as a table for notebooks.
    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        let mut rows = vec![("stable".to_owned(), if self.stable { "yes" } else { "NO" }.to_owned())];
        for (mode, radius) in self.modes.bind(py) {
            rows.push((format!("hands on: {mode}"), format!("{:.9}", radius.extract::<f64>()?)));
        }
        rows.extend(self.not_judged.iter().map(|left_out| ("not judged".to_owned(), left_out.clone())));
        Ok(html("Stability", &rows))
    }

    fn __repr__(&self) -> String {
        format!("<Stability: {}stable, spectral radius {}>", if self.stable { "" } else { "un" }, self.spectral_radius)
    }
}

/// Is this scene stable, and by how much? Of the linear scene behind it: both hands on, one, none.
#[pyfunction]
pub(crate) fn stability(py: Python<'_>, #[pyo3(from_py_with = meant)] scene: cohold_sim::Scene) -> PyResult<Stability> {
    let judged = here(py, move |_| cohold_analysis::judge(&scene).map_err(refused))?;
    let modes = PyDict::new(py);
    for mode in &judged.modes {
        modes.set_item(mode.name(), mode.verdict.spectral_radius)?;
    }
    Ok(Stability {
        stable: judged.worst.stable,
        spectral_radius: judged.worst.spectral_radius,
        modes: modes.unbind(),
        not_judged: judged.not_judged.into_iter().map(str::to_owned).collect(),
    })
}

/// What to change in a scene that is unstable, in one sentence.
#[pyfunction]
pub(crate) fn advice(py: Python<'_>, #[pyo3(from_py_with = meant)] scene: cohold_sim::Scene) -> PyResult<String> {
    here(py, move |_| cohold_analysis::advice(&scene).map_err(refused))
}

/// The values of a key between two ends at which the scene becomes stable or unstable, every mode considered.
#[pyfunction]
pub(crate) fn limit(
    py: Python<'_>,
    #[pyo3(from_py_with = meant)] scene: cohold_sim::Scene,
    key: &str,
    first: f64,
    last: f64,
) -> PyResult<Vec<f64>> {
    let range = Range { key: key.to_owned(), from: first, to: last };
    here(py, move |_| {
        let effort = Effort { hands: None, ..Effort::default() };
        let found = cohold_analysis::limit(&scene, range, effort).map_err(refused)?;
        Ok(found.crossings)
    })
}
