//! A scene that Python reads, changes, copies and sends to another process.

use std::path::{Path, PathBuf, absolute};

use cohold_core::settings::{Allowed, Value};
use cohold_sim::{Laws, scenes as built_in};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyKeyError, PyOSError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyList, PyMapping, PyString, PyTuple};

use crate::law::laws;
use crate::work::{here, refused};

/// What two peers, their users, their devices and the network between them are told before a run.
///
/// Without a source it is the cooperation paper's section 5. A `str` is the name of a built-in scene (`scenes()`) or a file, a
/// `pathlib.Path` a file. Settings are then applied in their order. Keys, units and ranges are those of scene files (`keys()`).
///
/// Raises ValueError with the line that the command line prints, and OSError for a file that cannot be read.
#[pyclass(module = "cohold")]
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) scene: cohold_sim::Scene,
}

impl Scene {
    /// The scene, its combinations checked: what a run, a sweep or a verdict begins with.
    pub(crate) fn checked(&self) -> PyResult<&cohold_sim::Scene> {
        self.scene.check("scene").map_err(refused)?;
        Ok(&self.scene)
    }

    pub(crate) fn put(&mut self, key: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = to_toml(key, value)?;
        let before = self.scene.laws;
        if self.scene.set(key, &value, "scene", None).is_ok() {
            return Ok(());
        }
        self.scene.laws = laws();
        let done = self.scene.set(key, &value, "scene", None);
        done.map_err(|cause| {
            self.scene.laws = before;
            refused(cause)
        })
    }
}

/// A scene that is found with the built-in laws, or else with those that Python has added: their keys are no part of a scene that
/// names none of them.
fn with_laws(
    py: Python<'_>,
    find: impl Fn(Laws) -> Result<cohold_sim::Scene, cohold_sim::Error> + Send + 'static,
) -> PyResult<cohold_sim::Scene> {
    here(py, move |_| find(cohold_guest_laws::laws()).or_else(|_| find(laws())).map_err(refused))
}

/// A value that a key may take, or a sweep give it.
pub(crate) fn to_toml(key: &str, value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    // bool first: Python's True is an int, too.
    if let Ok(flag) = value.extract::<bool>() {
        return Ok(toml::Value::Boolean(flag));
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(toml::Value::String(text));
    }
    value.extract::<f64>().map(toml::Value::Float).map_err(|_| {
        let kind = value.get_type().name().map_or_else(|_| "this".to_owned(), |name| name.to_string());
        PyTypeError::new_err(format!("{key} takes a bool, an int, a float or a str, not {kind}"))
    })
}

fn to_python(py: Python<'_>, value: Value<'_>) -> PyResult<Py<PyAny>> {
    match value {
        Value::Number(number) => number.into_py_any(py),
        Value::Flag(flag) => flag.into_py_any(py),
        Value::Text(text) => text.into_py_any(py),
    }
}

/// Values by name: any mapping of Python, in its order.
pub(crate) struct Named<'py>(pub(crate) Vec<(String, Bound<'py, PyAny>)>);

impl<'py> FromPyObject<'_, 'py> for Named<'py> {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        given.cast::<PyMapping>()?.items()?.extract().map(Self)
    }
}

/// The scene that a `Scene`, the name of a built-in one or a path stands for.
pub(crate) fn meant(source: &Bound<'_, PyAny>) -> PyResult<cohold_sim::Scene> {
    let py = source.py();
    if let Ok(scene) = source.cast::<Scene>() {
        let scene = scene.borrow().clone();
        return here(py, move |_| scene.checked().cloned());
    }
    let path: PathBuf = source.extract()?;
    let is_word = source.is_instance_of::<PyString>() && built_in::meant(Some(&path)).map_err(refused)?.is_some();
    if !is_word {
        // As Python itself says it.
        cohold_io::open(&path).map_err(|cause| {
            let said = cause.to_string();
            let said = said.split(" (os error").next().unwrap_or_default().to_owned();
            PyOSError::new_err((cause.raw_os_error(), said, path.display().to_string()))
        })?;
        return with_laws(py, move |laws| cohold_sim::Scene::load(laws, Some(&path), &[]));
    }
    with_laws(py, move |laws| built_in::find(laws, Some(&path), &[]))
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (source = None, settings = None))]
    fn new(source: Option<&Bound<'_, PyAny>>, settings: Option<Named<'_>>) -> PyResult<Self> {
        let usual = cohold_guest_laws::laws();
        let scene = source.map_or_else(|| Ok(cohold_sim::Scene::new(usual)), meant)?;
        let mut scene = Self { scene };
        for (key, value) in settings.into_iter().flat_map(|all| all.0) {
            scene.put(&key, &value)?;
        }
        Ok(scene)
    }

    /// The scene that this TOML text says, as a scene file holds it.
    #[staticmethod]
    fn from_toml(py: Python<'_>, text: String) -> PyResult<Self> {
        let scene = with_laws(py, move |laws| {
            let mut scene = cohold_sim::Scene::new(laws);
            scene.apply(&text, "text", None)?;
            scene.check("text").map(|()| scene)
        })?;
        Ok(Self { scene })
    }

    /// What differs from the default scene, as the text of a scene file. Traces are named by their whole path.
    pub(crate) fn to_toml(&self) -> String {
        let usual = cohold_sim::Scene::new(self.scene.laws).settings();
        let is_file = |key: &str| key.ends_with(".trace");
        let changed =
            self.scene.settings().into_iter().filter(|setting| !is_file(&setting.0) && !usual.contains(setting));
        let users = (1..).zip(&self.scene.users);
        let traces = users.filter_map(|(at, user)| Some((format!("user.{at}.trace"), &user.trace.as_ref()?.file)));
        let traces = traces.chain(self.scene.network_trace.iter().map(|of| ("network.trace".to_owned(), &of.file)));
        let whole = |path: &Path| absolute(path).unwrap_or_else(|_| path.to_owned());
        let traces =
            traces.map(|(key, file)| (key, toml::Value::String(whole(file).display().to_string()).to_string()));
        changed.chain(traces).map(|(key, value)| format!("{key} = {value}\n")).collect()
    }

    fn __getitem__(&self, py: Python<'_>, key: &str) -> PyResult<Py<PyAny>> {
        self.scene.get(key).map_or_else(|| Err(PyKeyError::new_err(key.to_owned())), |value| to_python(py, value))
    }

    /// The value of a key, or `default` if there is none.
    #[pyo3(signature = (key, default = None, /))]
    fn get(&self, py: Python<'_>, key: &str, default: Option<Py<PyAny>>) -> PyResult<Option<Py<PyAny>>> {
        self.scene.get(key).map_or(Ok(default), |value| to_python(py, value).map(Some))
    }

    /// Every key of this scene, its law's keys included: `dict(scene)` has all settings.
    fn keys(&self) -> Vec<String> {
        let all = self.scene.keys().into_iter().map(|(name, _)| name);
        all.filter(|name| self.scene.get(name).is_some()).collect()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        PyList::new(py, self.keys())?.try_iter()
    }

    fn __len__(&self) -> usize {
        self.keys().len()
    }

    fn __contains__(&self, key: &Bound<'_, PyAny>) -> bool {
        key.extract::<String>().is_ok_and(|key| self.scene.get(&key).is_some())
    }

    fn __setitem__(&mut self, key: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.put(key, value)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.borrow().to_toml() == self.to_toml())
    }

    fn __copy__(&self) -> Self {
        self.clone()
    }

    fn __deepcopy__(&self, memo: &Bound<'_, PyAny>) -> Self {
        let _ = memo;
        self.clone()
    }

    /// Pickled as its TOML: readable, and good across versions.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        (py.get_type::<Self>().getattr("from_toml")?, (self.to_toml(),)).into_pyobject(py)
    }

    fn __repr__(&self) -> String {
        format!("Scene.from_toml({:?})", self.to_toml())
    }
}

/// The names of the built-in scenes.
#[pyfunction]
pub(crate) fn scenes() -> Vec<&'static str> {
    built_in::known().map(|(name, _)| *name).collect()
}

/// Every key of a scene: its default, what it accepts, its unit and its meaning.
#[pyfunction]
pub(crate) fn keys(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let usual = cohold_sim::Scene::new(laws());
    let all = PyDict::new(py);
    for (name, key) in usual.keys() {
        let about = PyDict::new(py);
        let default = usual.get(&name).map(|value| to_python(py, value)).transpose()?;
        about.set_item("default", default)?;
        let one_of = |names: &[&'static str]| names.into_py_any(py);
        about.set_item(
            "allowed",
            match key.allowed {
                Allowed::Names(names) => one_of(names)?,
                Allowed::Laws(kinds) => one_of(&kinds.iter().map(|kind| kind.name).collect::<Vec<_>>())?,
                other => other.to_string().into_py_any(py)?,
            },
        )?;
        about.set_item("unit", key.unit)?;
        about.set_item("meaning", key.doc)?;
        all.set_item(name, about)?;
    }
    Ok(all)
}
