//! A sweep: the points, seeds, rows and folders of `cohold study sweep`.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cohold_core::names::Choice;
use cohold_report::Provenance;
use cohold_studies::sweep;
use cohold_studies::sweep::{Axis, Design, Plan, Row, Sample, Spread, Todo};
use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyString, PyTuple};

use crate::columns::to_python;
use crate::run::check_seconds;
use crate::scene::{Named, Scene, meant, to_toml};
use crate::work::{Progress, here, on_threads, refused};

/// A scene over its keys and over seeds, the question that `cohold study sweep` asks.
///
/// `over` is a grid: for each key its values, as a sequence or as the command line writes them ("200..20000:20:log", "0,0.1,0.3").
/// `sample` is drawn, `points` of it at each point of the grid, evenly by `design` ("sobol" or "latin-hypercube"): for each key a range
/// ("0..0.3", "0.02..1:log", "1..9:whole") or values. Every point is run for `seconds` in f64 with the same `seeds`.
///
/// Raises ValueError for a key that there is not, and for a value or a combination that is not allowed at any point.
#[pyclass(module = "cohold", frozen)]
pub(crate) struct Sweep {
    sweep: Arc<sweep::Sweep>,
    /// As they are written on the command line.
    over: Vec<String>,
    sample: Vec<String>,
}

/// `KEY=VALUES` of a mapping from keys to texts or sequences, or of texts that say so already.
pub(crate) fn written(of: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
    let Some(of) = of else { return Ok(Vec::new()) };
    let Ok(Named(all)) = of.extract() else { return of.extract() };
    let one = |(key, values): (String, Bound<'_, PyAny>)| {
        if let Ok(text) = values.cast::<PyString>() {
            return Ok(format!("{key}={text}"));
        }
        let value = |value: PyResult<Bound<'_, PyAny>>| {
            Ok(match to_toml(&key, &value?)? {
                toml::Value::String(text) => text,
                // 0 as 0, not as 0.0: as it is typed.
                toml::Value::Float(number) => number.to_string(),
                other => other.to_string(),
            })
        };
        let values: Vec<String> = values.try_iter()?.map(value).collect::<PyResult<_>>()?;
        Ok(format!("{key}={}", values.join(",")))
    };
    all.into_iter().map(one).collect()
}

impl Sweep {
    fn question(&self) -> PyResult<Provenance> {
        self.sweep.question(crate::provenance()).map_err(refused)
    }
}

/// What of a question every process that answers it must have alike: the program, and what is in the traces.
fn alike(question: &Provenance) -> Vec<String> {
    let matters = |line: &&str| ["version = ", "commit = ", "trace_"].iter().any(|name| line.starts_with(name));
    let text = question.toml();
    let made = text.split_once("\n[made]\n").map_or("", |(_, made)| made);
    made.lines().filter(matters).map(str::to_owned).collect()
}

/// What a folder of rows has to say.
pub(crate) fn failed(cause: impl ToString) -> PyErr {
    PyOSError::new_err(cause.to_string())
}

/// Does these runs; `journal` gets every row as soon as it is there.
pub(crate) fn rows_of(
    py: Python<'_>,
    plan: &Arc<impl Plan + Send + 'static>,
    runs: Todo,
    threads: usize,
    journal: Option<Arc<sweep::Journal>>,
    tell: Option<Py<PyAny>>,
) -> PyResult<Vec<Row>> {
    let count = runs.iter().map(|(_, seeds)| seeds.len() as u64).sum();
    kept(py, plan, count, threads, journal, tell, move |plan, keep| plan.run_these(runs, keep))
}

/// What this work on a plan gives, at most so many runs, whose rows a journal keeps.
pub(crate) fn kept<P: Plan + Send + 'static, T: Send + 'static>(
    py: Python<'_>,
    plan: &Arc<P>,
    most: u64,
    threads: usize,
    journal: Option<Arc<sweep::Journal>>,
    tell: Option<Py<PyAny>>,
    work: impl FnOnce(&P, sweep::Keep<'_>) -> Result<T, cohold_studies::Error> + Send + 'static,
) -> PyResult<T> {
    let plan = plan.clone();
    let progress = Progress::new(tell, most);
    let own = progress.clone();
    on_threads(py, threads, &progress, move |go_on| {
        let unwritten = AtomicBool::new(false);
        let keep = |rows: &[Row]| match go_on() {
            true => {
                own.add(rows.len() as u64);
                journal.as_ref().map_or(Ok(()), |journal| journal.append(rows)).inspect_err(|_| {
                    unwritten.store(true, Ordering::Relaxed);
                })
            }
            // Who said so tells why.
            false => Err("stopped".into()),
        };
        let wrong = |cause| if unwritten.load(Ordering::Relaxed) { failed(cause) } else { refused(cause) };
        work(&plan, &keep).map_err(wrong)
    })
}

/// Axes and sample as they were written, seeds checked.
pub(crate) struct Grid {
    pub(crate) axes: Vec<Axis>,
    pub(crate) sample: Option<Sample>,
}

impl Grid {
    pub(crate) fn of(
        over: &[String],
        sample: &[String],
        points: Option<usize>,
        design: &str,
        sample_seed: u32,
        seeds: u32,
    ) -> PyResult<Self> {
        if !(1..=100_000).contains(&seeds) {
            return Err(refused(format!("seeds = {seeds} is not allowed: it must be a whole number from 1 to 100000")));
        }
        let wrong = |text: &str, cause: cohold_studies::Error| refused(format!("{text}: {cause}"));
        let axes = over.iter().map(|text| text.parse::<Axis>().map_err(|cause| wrong(text, cause)));
        let axes = axes.collect::<PyResult<Vec<_>>>()?;
        let spreads = sample.iter().map(|text| text.parse::<Spread>().map_err(|cause| wrong(text, cause)));
        let spreads = spreads.collect::<PyResult<Vec<_>>>()?;
        let design = Design::from_name(design).ok_or_else(|| {
            refused(format!(
                "design = \"{design}\" is not allowed: it must be one of \"{}\"",
                Design::NAMES.join("\", \"")
            ))
        })?;
        let sample = match (points, spreads.is_empty()) {
            (Some(points), false) => Some(Sample::new(design, points, sample_seed, spreads).map_err(refused)?),
            (None, true) => None,
            (Some(_), true) => return Err(refused("points is not allowed without sample")),
            (None, false) => return Err(refused("sample needs points: how many there are")),
        };
        Ok(Self { axes, sample })
    }
}

#[pymethods]
impl Sweep {
    #[new]
    #[pyo3(signature = (
        scene, over = None, sample = None, points = None, design = "sobol", sample_seed = 1, seeds = 1, seconds = 20.0
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        #[pyo3(from_py_with = meant)] scene: cohold_sim::Scene,
        over: Option<&Bound<'_, PyAny>>,
        sample: Option<&Bound<'_, PyAny>>,
        points: Option<usize>,
        design: &str,
        sample_seed: u32,
        seeds: u32,
        seconds: f64,
    ) -> PyResult<Self> {
        let (over, sample) = (written(over)?, written(sample)?);
        check_seconds(seconds, &scene)?;
        let Grid { axes, sample: drawn } = Grid::of(&over, &sample, points, design, sample_seed, seeds)?;
        if axes.is_empty() && drawn.is_none() {
            return Err(refused("a sweep needs keys: over or sample"));
        }
        let sweep = Arc::new(sweep::Sweep { scene, axes, sample: drawn, seeds, seconds });
        let asked = sweep.clone();
        on_threads(py, 0, &Progress::default(), move |_| asked.check().map_err(refused))?;
        Ok(Self { sweep, over, sample })
    }

    /// How many points there are.
    #[getter]
    fn points(&self) -> usize {
        self.sweep.points()
    }

    /// How many runs: points times seeds.
    #[getter]
    fn runs(&self) -> usize {
        self.sweep.runs()
    }

    /// Simulated time of a run, s.
    #[getter]
    fn seconds(&self) -> f64 {
        self.sweep.seconds
    }

    /// The keys that are varied.
    #[getter]
    fn keys(&self) -> Vec<String> {
        self.sweep.keys().map(str::to_owned).collect()
    }

    /// The scene of a point, with the first seed.
    fn scene_at(&self, py: Python<'_>, point: usize) -> PyResult<Scene> {
        if point >= self.sweep.points() {
            let most = self.sweep.points() - 1;
            return Err(refused(format!("point = {point} is not allowed: it must be a whole number from 0 to {most}")));
        }
        let sweep = self.sweep.clone();
        here(py, move |_| Ok(Scene { scene: sweep.scene_at(point).map_err(refused)? }))
    }

    /// Runs everything on so many threads (0: as many as there are cores) and gives the table by column, a row a run.
    ///
    /// With a folder it is kept there as `cohold study sweep --out` keeps it: what is there already is not run again, and in the end
    /// `sweep.csv` and `sweep.parquet` stand there. Raises OSError where that is another sweep's folder, or cannot be written.
    /// `progress` is told now and then how many runs are done, and of how many.
    #[pyo3(signature = (folder = None, threads = 0, progress = None))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        folder: Option<PathBuf>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let Some(folder) = folder else {
            let all: BTreeSet<usize> = (0..self.sweep.points()).collect();
            let mut rows = rows_of(py, &self.sweep, self.sweep.missing(&all, &[]), threads, None, progress)?;
            self.sweep.sort(&mut rows);
            return to_python(py, self.sweep.columns(&rows));
        };
        let mut journal = self.open(folder)?;
        let new = rows_of(py, &self.sweep, journal.missing(), threads, journal.file.clone(), progress)?;
        journal.rows.extend(new);
        journal.finish(py)
    }

    /// Goes on with the sweep in this folder, or begins it there; for who hands its runs to others.
    fn open(&self, folder: PathBuf) -> PyResult<Journal> {
        let question = self.question()?;
        let (file, rows) = sweep::Journal::open(&folder, "sweep", &question, (1, 1)).map_err(failed)?;
        Ok(Journal { sweep: self.sweep.clone(), question, folder, file: Some(Arc::new(file)), rows })
    }

    /// Does these runs, each a point with its seeds, and gives their rows as lines for `Journal.append`.
    #[pyo3(signature = (runs, threads = 1))]
    fn rows<'py>(&self, py: Python<'py>, runs: Todo, threads: usize) -> PyResult<Bound<'py, PyBytes>> {
        let points = self.sweep.points();
        if let Some((point, _)) = runs.iter().find(|(point, _)| *point >= points) {
            return Err(refused(format!("point = {point} is not allowed: there are {points}, from 0")));
        }
        let rows = rows_of(py, &self.sweep, runs, threads, None, None)?;
        Ok(PyBytes::new(py, &Row::lines(&rows).map_err(refused)?))
    }

    /// Version, commit, and the sums of traces: what must be alike wherever the sweep is run.
    #[getter]
    fn made(&self) -> PyResult<Vec<String>> {
        Ok(alike(&self.question()?))
    }

    /// Pickled as it was asked.
    fn __reduce__<'py>(slf: &Bound<'py, Self>, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let Self { sweep, over, sample } = slf.get();
        let drawn = sweep.sample.as_ref();
        let scene = Scene { scene: sweep.scene.clone() };
        let asked = (
            scene,
            over.clone(),
            sample.clone(),
            drawn.map(|drawn| drawn.points),
            drawn.map_or(Design::Sobol, |drawn| drawn.design).name(),
            drawn.map_or(1, |drawn| drawn.seed),
            sweep.seeds,
            sweep.seconds,
        );
        (py.get_type::<Self>(), asked).into_pyobject(py)
    }

    fn __repr__(&self) -> String {
        let keys: Vec<&str> = self.sweep.keys().collect();
        format!("<Sweep of {} points, {} runs, over {}>", self.sweep.points(), self.sweep.runs(), keys.join(", "))
    }
}

/// A folder of a sweep that is being filled; nobody else fills it until `close`, or the end of its `with`.
#[pyclass(module = "cohold")]
pub(crate) struct Journal {
    sweep: Arc<sweep::Sweep>,
    question: Provenance,
    folder: PathBuf,
    file: Option<Arc<sweep::Journal>>,
    rows: Vec<Row>,
}

#[pymethods]
impl Journal {
    /// The runs that are not there yet: points, each with its seeds.
    fn missing(&self) -> Todo {
        let all = (0..self.sweep.points()).collect();
        self.sweep.missing(&all, &self.rows)
    }

    /// Adds rows as `Sweep.rows` gives them.
    fn append(&mut self, lines: &[u8]) -> PyResult<()> {
        let file = self.file.as_ref().ok_or_else(closed)?;
        let new = Row::read(lines).collect::<Result<Vec<Row>, _>>().map_err(refused)?;
        file.append(&new).map_err(failed)?;
        self.rows.extend(new);
        Ok(())
    }

    /// The table by column, when every run is there; writes `sweep.csv` and `sweep.parquet`, and closes the journal.
    fn finish<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let missing = self.missing().len();
        if missing > 0 {
            return Err(PyRuntimeError::new_err(format!("{missing} points are not there yet")));
        }
        let file = self.file.take().ok_or_else(closed)?;
        self.sweep.sort(&mut self.rows);
        let columns = self.sweep.columns(&self.rows);
        sweep::write(&self.folder, "sweep", &columns, &self.question).map_err(failed)?;
        file.finish().map_err(failed)?;
        to_python(py, columns)
    }

    /// Lets others fill the folder.
    fn close(&mut self) {
        self.file = None;
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&mut self, _error: &Bound<'_, PyTuple>) {
        self.close();
    }
}

fn closed() -> PyErr {
    PyRuntimeError::new_err("the journal is closed")
}
