//! A study: the entrants, networks, rows, answers and figures of `cohold study`.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use cohold_core::names::Choice;
use cohold_plot::Print;
use cohold_report::{Files, Provenance};
use cohold_sim::Laws;
use cohold_studies::entrant::Entrant;
use cohold_studies::networks::{Network, OWN};
use cohold_studies::study;
use cohold_studies::study::answers::{Answer, Goal, metric};
use cohold_studies::study::halving::{LeftOut, Search};
use cohold_studies::sweep;
use cohold_studies::sweep::{Keep, METRICS, Plan, Row};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::columns::to_python;
use crate::law::laws;
use crate::run::check_seconds;
use crate::scene::{Named, meant};
use crate::sweep::{Grid, failed, kept, rows_of, written};
use crate::work::{Progress, here, on_threads, refused};

/// Scenes or laws over keys, networks and seeds: which is best where, under which bounds, and how sure that is; the question of `cohold
/// study`.
///
/// `entrants` are texts as the command line takes them ("wave", "any-network,object.mass_kg=0.1", a law at its own gains or a scene), or
/// a dict from names to scenes. `networks` are names ("own", as each scene has it; "all"), or paths of recordings. Axes and sample are those
/// of `Sweep`, and may be left out. Every point is run for `seconds` in f64 with the same `seeds`: the first half chooses the best point,
/// the other half says how good it is.
///
/// Raises ValueError for what there is not, and for a value or a combination that is not allowed at any point.
#[pyclass(module = "cohold", frozen)]
pub(crate) struct Study {
    study: Arc<study::Study>,
}

/// A text as the command line takes it, with the built-in laws or else with those that Python has added.
fn entrant(py: Python<'_>, text: String) -> PyResult<Entrant> {
    here(py, move |_| {
        let of = |laws: Laws| Entrant::of(laws, &text, None, &[]);
        of(cohold_guest_laws::laws()).or_else(|_| of(laws())).map_err(refused)
    })
}

/// The scenes that take part.
fn entrants(py: Python<'_>, of: &Bound<'_, PyAny>) -> PyResult<Vec<Entrant>> {
    if let Ok(Named(all)) = of.extract() {
        let one = |(name, scene): (String, Bound<'_, PyAny>)| Ok(Entrant { name, scene: meant(&scene)? });
        return all.into_iter().map(one).collect();
    }
    if of.cast::<PyString>().is_ok() {
        return Ok(vec![entrant(py, of.extract()?)?]);
    }
    of.try_iter()?.map(|text| entrant(py, text?.extract()?)).collect()
}

/// The networks of names and paths.
fn networks(of: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Network>> {
    let named = |name: &str| Network::of(name).map_err(refused);
    let one = |network: &Bound<'_, PyAny>| match network.cast::<PyString>() {
        Ok(name) => named(&name.to_string()),
        Err(_) => Ok(vec![Network::of_trace(&network.extract::<PathBuf>()?).map_err(refused)?]),
    };
    match of {
        None => named(OWN),
        Some(of) if of.cast::<PyString>().is_ok() => one(of),
        Some(of) => {
            let each = of.try_iter()?.map(|network| one(&network?)).collect::<PyResult<Vec<_>>>()?;
            Ok(each.into_iter().flatten().collect())
        }
    }
}

/// What is to be least, and what may be how much at most.
fn goal(best: &str, at_most: Option<Named<'_>>) -> PyResult<Goal> {
    let named = |name: &str| metric(name).map_err(|cause| refused(format!("there is no {name:?}: {cause}")));
    let bound = |(name, most): (String, Bound<'_, PyAny>)| {
        Ok(study::answers::Bound { metric: named(&name)?, most: most.extract()? })
    };
    let bounds = at_most.into_iter().flat_map(|all| all.0).map(bound).collect::<PyResult<Vec<_>>>()?;
    if let Some(wrong) = bounds.iter().find(|bound| !bound.most.is_finite()) {
        return Err(refused(format!("{} needs a number, not {}", METRICS[wrong.metric].name(), wrong.most)));
    }
    Ok(Goal { metric: named(best)?, bounds })
}

#[pymethods]
impl Study {
    #[new]
    #[pyo3(signature = (
        entrants, over = None, networks = None, sample = None, points = None, design = "sobol", sample_seed = 1, seeds = 20,
        seconds = 20.0
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        entrants: &Bound<'_, PyAny>,
        over: Option<&Bound<'_, PyAny>>,
        networks: Option<&Bound<'_, PyAny>>,
        sample: Option<&Bound<'_, PyAny>>,
        points: Option<usize>,
        design: &str,
        sample_seed: u32,
        seeds: u32,
        seconds: f64,
    ) -> PyResult<Self> {
        let Grid { axes, sample } = Grid::of(&written(over)?, &written(sample)?, points, design, sample_seed, seeds)?;
        let (entrants, networks) = (self::entrants(py, entrants)?, self::networks(networks)?);
        entrants.iter().try_for_each(|entrant| check_seconds(seconds, &entrant.scene))?;
        let study = study::Study::new(entrants, networks, &axes, sample.as_ref(), seeds, seconds);
        let study = Arc::new(study.map_err(refused)?);
        let asked = study.clone();
        on_threads(py, 0, &Progress::default(), move |_| asked.check().map_err(refused))?;
        Ok(Self { study })
    }

    /// How many points there are: entrants times networks times points of the grid.
    #[getter]
    fn points(&self) -> usize {
        self.study.points()
    }

    /// How many runs: points times seeds.
    #[getter]
    fn runs(&self) -> usize {
        self.study.runs()
    }

    /// The names that `networks` takes beside "all".
    #[staticmethod]
    fn network_names() -> Vec<&'static str> {
        Network::names().collect()
    }

    /// Runs everything on so many threads (0: as many as there are cores); or with `search="halving"` only what decides which points have the least
    /// of `best` under the bounds `at_most`, which is then what may be asked of the findings.
    ///
    /// With a folder it is kept there as `cohold study --out` keeps it: what is there already is not run again, and in the end
    /// `study.csv` and `study.parquet` stand there. Raises OSError where that is another study's folder, or cannot be written.
    /// `progress` is told now and then how many runs are done, and of how many; a search may need fewer.
    #[pyo3(signature = (
        folder = None, threads = 0, progress = None, search = "grid", best = "true_discrepancy_mm", at_most = None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn run(
        &self,
        py: Python<'_>,
        folder: Option<PathBuf>,
        threads: usize,
        progress: Option<Py<PyAny>>,
        search: &str,
        best: &str,
        at_most: Option<Named<'_>>,
    ) -> PyResult<Findings> {
        let search = Search::from_name(search).ok_or_else(|| {
            refused(format!("search = {search:?} is not allowed: it must be one of {:?}", Search::NAMES))
        })?;
        let goal = goal(best, at_most)?;
        let question = self.study.question(crate::provenance()).map_err(refused)?;
        let opened = folder.as_ref().map(|folder| sweep::Journal::open(folder, "study", &question, (1, 1)));
        let (journal, there) = match opened.transpose().map_err(failed)? {
            Some((journal, rows)) => (Some(Arc::new(journal)), rows),
            None => (None, Vec::new()),
        };
        let (rows, searched) = match search {
            Search::Grid => {
                let (mut rows, all) = (there, (0..self.study.points()).collect::<BTreeSet<usize>>());
                let missing = self.study.missing(&all, &rows);
                rows.extend(rows_of(py, &self.study, missing, threads, journal.clone(), progress)?);
                self.study.sort(&mut rows);
                (rows, None)
            }
            Search::Halving => {
                let most = self.study.runs().saturating_sub(there.len()) as u64;
                let goal_of = goal.clone();
                let of = move |study: &study::Study, keep: Keep<'_>| study.search(&goal_of, (1, 1), there, keep);
                let found = kept(py, &self.study, most, threads, journal.clone(), progress, of)?;
                (found.rows, Some((goal, found.left_out)))
            }
        };
        let question = match &searched {
            Some((goal, _)) => goal.told(question.with("search", search.name())),
            None => question,
        };
        if let Some((folder, journal)) = folder.zip(journal) {
            sweep::write(&folder, "study", &self.study.columns(&rows), &question).map_err(failed)?;
            journal.finish().map_err(failed)?;
        }
        Ok(Findings { study: self.study.clone(), question, rows, searched })
    }

    fn __repr__(&self) -> String {
        let (entrants, networks) = (self.study.entrants.len(), self.study.networks.len());
        format!(
            "<Study of {entrants} entrants over {networks} networks, {} points, {} runs>",
            self.points(),
            self.runs()
        )
    }
}

/// What a study found.
#[pyclass(module = "cohold", frozen)]
pub(crate) struct Findings {
    study: Arc<study::Study>,
    question: Provenance,
    rows: Vec<Row>,
    /// For what it was searched, if not everything was run, and the points that were left out.
    searched: Option<(Goal, Vec<LeftOut>)>,
}

impl Findings {
    fn answered(&self, best: &str, at_most: Option<Named<'_>>) -> PyResult<(Goal, Vec<Answer>)> {
        let goal = goal(best, at_most)?;
        let answers = match &self.searched {
            None => self.study.answers(&self.rows, &goal),
            Some((searched, left_out)) if *searched == goal => self.study.searched_answers(&self.rows, left_out, &goal),
            Some((searched, _)) => {
                let [asked, searched] = [&goal, searched].map(Goal::what);
                let said = format!("the runs decide the least {searched}, not {asked}: run the study for that");
                return Err(refused(said));
            }
        };
        Ok((goal, answers))
    }
}

#[pymethods]
impl Findings {
    /// Every run by column, a row a run, with every mode's verdict.
    #[getter]
    fn rows<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        to_python(py, self.study.columns(&self.rows))
    }

    /// Every point by column: means over all its seeds, with half of their 95 % intervals; 0 runs where a search left it out.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let left_out = self.searched.as_ref().map_or(&[][..], |(_, left_out)| left_out);
        to_python(py, self.study.summary(&self.rows, left_out))
    }

    /// Of each entrant on each network the point with the least of a figure of merit, among those that are stable in every run and every
    /// mode and of which no run is beyond a bound (`at_most`: figures of merit and numbers); what seeds say of it that did not choose it.
    #[pyo3(signature = (best = "true_discrepancy_mm", at_most = None))]
    fn best<'py>(&self, py: Python<'py>, best: &str, at_most: Option<Named<'py>>) -> PyResult<Bound<'py, PyDict>> {
        let (goal, answers) = self.answered(best, at_most)?;
        to_python(py, self.study.answer_columns(&answers, &goal))
    }

    /// The best points of every two entrants beside each other, seed by seed, on networks where both have one.
    #[pyo3(signature = (best = "true_discrepancy_mm", at_most = None))]
    fn pairs<'py>(&self, py: Python<'py>, best: &str, at_most: Option<Named<'py>>) -> PyResult<Bound<'py, PyDict>> {
        let (goal, answers) = self.answered(best, at_most)?;
        to_python(py, self.study.pair_columns(&self.study.pairs(&self.rows, &answers, &goal)))
    }

    /// Writes the figure as `name` with .svg, .pdf and .png into a folder, `width_mm` wide (88 is a column of most journals, 180 a page);
    /// gives the paths. Nothing is overwritten.
    #[pyo3(signature = (folder, name = "study-best", best = "true_discrepancy_mm", at_most = None, width_mm = 88.0))]
    fn draw(
        &self,
        folder: PathBuf,
        name: &str,
        best: &str,
        at_most: Option<Named<'_>>,
        width_mm: f64,
    ) -> PyResult<Vec<PathBuf>> {
        if !(60.0..=400.0).contains(&width_mm) {
            return Err(refused(format!(
                "width_mm = {width_mm} is not allowed: it must be a number from 60 to 400 mm"
            )));
        }
        let (goal, answers) = self.answered(best, at_most)?;
        let mut files = Files::new(&folder, name, self.question.clone());
        files.print(Print { width_mm, ..Print::default() });
        for (number, figure) in (1..).zip(self.study.figures(&self.rows, &answers, &goal)) {
            let other = (number > 1).then(|| format!("{name}-figure-{number}"));
            files.figure(other.as_deref(), &figure).map_err(failed)?;
        }
        files.write().map_err(failed)
    }

    fn __repr__(&self) -> String {
        let stable = self.rows.iter().filter(|row| row.reason.is_empty()).count();
        format!("<Findings of {} runs, {stable} of them stable>", self.rows.len())
    }
}
