//! A run: what `cohold cooperate` does.

use cohold_analysis::{Conclusion, conclude};
use cohold_core::num::Fixed;
use cohold_sim::run::{Options, Outcome, Verdict, run_while};
use cohold_studies::sweep::METRICS;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::columns::to_python;
use crate::scene::meant;
use crate::work::{Progress, here_telling, refused};

/// Most rows of a table: five hours at 1 kHz.
pub(crate) const MOST_ROWS: usize = 20_000_000;
/// Longest run, s.
const LONGEST_S: f64 = 86_400.0;

/// What Python says of a number type that there is not.
pub(crate) fn unknown_scalar(name: &str) -> PyErr {
    refused(format!("scalar = \"{name}\" is not allowed: it must be one of \"f32\", \"f64\", \"i32f32\""))
}

/// A run has a tick at least, and an end.
pub(crate) fn check_seconds(seconds: f64, scene: &cohold_sim::Scene) -> PyResult<()> {
    let period_s = scene.peer.timing.control_period_s;
    if seconds >= period_s && seconds <= LONGEST_S {
        return Ok(());
    }
    let must = format!("it must be a number from {period_s} (one control period) to {LONGEST_S} s");
    Err(refused(format!("seconds = {seconds} is not allowed: {must}")))
}

/// Names and what they are, as a table of HTML.
pub(crate) fn html(title: &str, rows: &[(String, String)]) -> String {
    let escape = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let row = |(name, is): &(String, String)| format!("<tr><th>{}</th><td>{}</td></tr>", escape(name), escape(is));
    let rows: String = rows.iter().map(row).collect();
    format!("<table><caption>{title}</caption>{rows}</table>")
}

/// What a run gave, as `cohold cooperate` tells it.
#[pyclass(module = "cohold", frozen, get_all)]
pub(crate) struct Run {
    /// Every recorded column by name (the unit is its end), a row a recorded tick: what stands in the command's CSV.
    columns: Py<PyDict>,
    /// The columns of each shared axis, the first one first; `columns` are those of the first.
    axes: Vec<Py<PyDict>>,
    /// Figures of merit by name; None where there is none, as of a run that failed.
    merits: Py<PyDict>,
    /// Nothing failed.
    stable: bool,
    /// `stable`, `apart` or `NO`.
    verdict: &'static str,
    /// Why it is not stable.
    reason: Option<String>,
    /// The peer (1 or 2) that stopped first, and its fault.
    fault: Option<(usize, String)>,
    /// When, s.
    fault_time_s: Option<f64>,
    /// Largest absolute eigenvalue of the scene over a packet period, both hands on.
    spectral_radius: f64,
    /// The modes of the scene that are not stable, whatever the run showed: whose hands are on (both, one, none).
    unstable_modes: Vec<String>,
    /// Ticks done.
    ticks: u64,
    /// Hash of both peers' states over every tick, the same bits wherever it is computed.
    state_hash: String,
}

/// What a run holds, beside its first columns.
const HELD: [&str; 11] = [
    "axes",
    "merits",
    "stable",
    "verdict",
    "reason",
    "fault",
    "fault_time_s",
    "spectral_radius",
    "unstable_modes",
    "ticks",
    "state_hash",
];

/// What a pickled run says under this name.
fn of<'py, T: FromPyObjectOwned<'py>>(held: &Bound<'py, PyDict>, name: &str) -> PyResult<T> {
    held.as_any().get_item(name)?.extract().map_err(Into::into)
}

#[pymethods]
impl Run {
    /// From what it holds.
    #[staticmethod]
    fn _of(held: &Bound<'_, PyDict>) -> PyResult<Self> {
        let axes: Vec<Py<PyDict>> = of(held, "axes")?;
        let columns = axes.first().ok_or_else(|| refused("a run has an axis".to_owned()))?.clone_ref(held.py());
        let said: String = of(held, "verdict")?;
        let names = [Verdict::Stable, Verdict::Apart, Verdict::Unstable].map(Verdict::name);
        let verdict = names.into_iter().find(|name| *name == said);
        Ok(Self {
            columns,
            axes,
            merits: of(held, "merits")?,
            stable: of(held, "stable")?,
            verdict: verdict.ok_or_else(|| refused("a run has a verdict".to_owned()))?,
            reason: of(held, "reason")?,
            fault: of(held, "fault")?,
            fault_time_s: of(held, "fault_time_s")?,
            spectral_radius: of(held, "spectral_radius")?,
            unstable_modes: of(held, "unstable_modes")?,
            ticks: of(held, "ticks")?,
            state_hash: of(held, "state_hash")?,
        })
    }

    /// Pickled as what it holds.
    fn __reduce__<'py>(slf: &Bound<'py, Self>, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let held = PyDict::new(py);
        HELD.iter().try_for_each(|name| held.set_item(*name, slf.getattr(*name)?))?;
        (slf.get_type().getattr("_of")?, (held,)).into_pyobject(py)
    }

    /// Its verdict and its figures of merit as a table, for notebooks.
    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        let mut rows = vec![("verdict".to_owned(), self.verdict.to_owned())];
        rows.extend(self.reason.iter().map(|reason| ("reason".to_owned(), reason.clone())));
        rows.push(("spectral radius, both hands on".to_owned(), format!("{:.9}", self.spectral_radius)));
        if !self.unstable_modes.is_empty() {
            rows.push(("unstable with hands on".to_owned(), self.unstable_modes.join("; ")));
        }
        for (name, merit) in self.merits.bind(py) {
            let merit: Option<f64> = merit.extract()?;
            rows.push((name.to_string(), merit.map_or_else(|| "none".to_owned(), |merit| format!("{merit:.6}"))));
        }
        rows.extend([("ticks".to_owned(), self.ticks.to_string()), ("state hash".to_owned(), self.state_hash.clone())]);
        Ok(html("Run", &rows))
    }

    fn __repr__(&self) -> String {
        let reason = self.reason.as_ref().map_or_else(String::new, |reason| format!(": {reason}"));
        let modes = match self.unstable_modes.as_slice() {
            [] => String::new(),
            modes => format!(", unstable with hands on: {}", modes.join("; ")),
        };
        format!("<Run of {} ticks, {}{reason}{modes}, state_hash {}>", self.ticks, self.verdict, self.state_hash)
    }
}

/// Runs a scene for so many simulated seconds.
///
/// `scalar` is the number type of the peers: f32 as the board, f64, or i32f32 (fixed point). Every `every`-th tick is recorded, 0 for
/// none; without it at most about 100,000 rows are, as the command line has it. `progress` is told now and then how many ticks are done, and of
/// how many. Other Python threads go on meanwhile.
#[pyfunction]
#[pyo3(signature = (scene, seconds = 20.0, scalar = "f64", every = None, progress = None))]
pub(crate) fn run(
    py: Python<'_>,
    #[pyo3(from_py_with = meant)] scene: cohold_sim::Scene,
    seconds: f64,
    scalar: &str,
    every: Option<i64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Run> {
    check_seconds(seconds, &scene)?;
    let mut options = Options::recorded(seconds, scene.peer.timing.control_period_s);
    if let Some(every) = every {
        options.record_every = u64::try_from(every).map_err(|_| {
            refused(format!("every = {every} is not allowed: it must be a whole number of ticks from 0"))
        })?;
    }
    if let Some(rows) = options.ticks(&scene).checked_div(options.record_every).filter(|rows| *rows > MOST_ROWS as u64)
    {
        let must = format!("a table has at most {MOST_ROWS} rows");
        return Err(refused(format!(
            "every = {} is not allowed here: it makes {rows} rows, and {must}",
            options.record_every
        )));
    }
    let scalar = scalar.to_owned();
    let ticks = options.ticks(&scene);
    let progress = Progress::new(progress, ticks);
    let own = progress.clone();
    let conclusion = here_telling(py, &progress, move |go_on| {
        let go_on = |done| {
            own.is_at(done);
            go_on()
        };
        let outcome = match scalar.as_str() {
            "f32" => run_while::<f32>(&scene, options, &go_on),
            "f64" => run_while::<f64>(&scene, options, &go_on),
            "i32f32" => run_while::<Fixed>(&scene, options, &go_on),
            other => return Err(unknown_scalar(other)),
        };
        let outcome = outcome.map_err(refused)?;
        own.is_at(outcome.ticks);
        conclude(&scene, outcome).map_err(refused)
    })?;
    let Conclusion { outcome, analysis } = conclusion;
    let merits = PyDict::new(py);
    for merit in METRICS {
        merits.set_item(merit.name(), (merit.of)(&outcome))?;
    }
    let (stable, verdict_name) = (outcome.is_stable(), outcome.verdict().name());
    let Outcome { reason, fault, fault_time_s, ticks, hash, axes, .. } = outcome;
    let axes: Vec<Py<PyDict>> =
        axes.into_iter().map(|along| Ok(to_python(py, along.table)?.unbind())).collect::<PyResult<_>>()?;
    Ok(Run {
        merits: merits.unbind(),
        stable,
        verdict: verdict_name,
        reason: reason.map(|reason| reason.to_string()),
        fault: fault.map(|(peer, fault)| (peer, fault.explain().to_string())),
        fault_time_s,
        spectral_radius: analysis.verdict.spectral_radius,
        unstable_modes: analysis.judged.unstable_modes(),
        ticks,
        state_hash: format!("{hash:016x}"),
        columns: axes[0].clone_ref(py),
        axes,
    })
}
