//! A live peer that Python holds: the very one of `cohold peer`, in a native thread of its own at the scene's rate, with no Python in its
//! tick. Python reads and steers it at any rate ([`cohold_live::steering`]).
//!
//! **Letting go.** Whatever ends the object ends the peer: `stop`, `close`, the end of a `with`, an exception in it, garbage collection, the end
//! of the interpreter. Forces go to nothing and the partner is told. A process that is killed tells nobody: then the partner lets go by
//! `safety.peer_lost_s`, and the device by its own watchdog. A child that was forked holds no peer.

mod given;
mod held;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

use cohold_cli::live_peer;
use cohold_live::devices::Kind;
use cohold_live::endpoint::{Span, Stop};
use cohold_live::peer::Report;
use cohold_live::steering::{Snapshot, Steering};
use cohold_live::tell::Manner;
use cohold_live::watch::LiveOptions;
use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

use crate::push::{Along, MOST_AXES, check};
use crate::scene::{Named, Scene, meant};
use crate::work::refused;

use given::{address, device_of, limit};
use held::{Held, Outcome, Why, remember};

/// How often whoever waits looks for Ctrl-C and for what it waits for.
const LOOK: Duration = Duration::from_millis(5);
/// Longest that somebody may be asked to wait, s: 100 years.
const LONGEST_S: f64 = 3.2e9;

/// Farthest from the middle that a hand is told to go, m.
const FARTHEST_M: f64 = 10.0;

/// What a live peer was at its newest tick. Along several shared axes each quantity is a tuple; places and forces are of the shared world.
#[pyclass(module = "cohold", frozen, get_all)]
pub(crate) struct LiveState {
    /// Time since the peer began, s.
    time_s: f64,
    /// Control periods in which its hand moved.
    tick: u64,
    /// calling, waiting (for the other end, a verdict or arming), refused, alone, armed, faulted; held while it is not wanted armed. The
    /// motors are on in alone (both ends have not been live yet) and in armed.
    mode: &'static str,
    /// What stopped it.
    fault: Option<String>,
    /// Where the hand is, m.
    hand_m: Py<PyAny>,
    /// How fast it moves, m/s.
    hand_m_per_s: Py<PyAny>,
    /// Where this peer's copy of the object is, m.
    object_m: Py<PyAny>,
    /// How fast it moves, m/s.
    object_m_per_s: Py<PyAny>,
    /// Where the other peer's copy is, as far as this one knows: what the coordination acts upon, m.
    peer_m: Py<PyAny>,
    /// How fast that moves, m/s.
    peer_m_per_s: Py<PyAny>,
    /// Force at the hand, as the peer commands it, N; 0 while its motors are off.
    force_n: Py<PyAny>,
    /// Force of contact on the copy, N.
    contact_force_n: Py<PyAny>,
    /// Force of coordination on the copy, N.
    coordination_force_n: Py<PyAny>,
}

#[pymethods]
impl LiveState {
    fn __repr__(&self) -> String {
        let fault = self.fault.as_ref().map_or_else(String::new, |fault| format!(", {fault}"));
        let Self { time_s, tick, mode, hand_m, force_n, .. } = self;
        format!("<LiveState at {time_s:.3} s: {mode}{fault}, tick {tick}, hand_m {hand_m}, force_n {force_n}>")
    }
}

/// A peer in real time: `cohold peer` in a native thread of its own, with no Python in its tick, read and steered from here at any rate.
///
/// `scene` is a Scene, the name of a built-in one, a file, or a dict of settings over the recommended scene; `number` 1 (left) or 2
/// (right); `listen` and `connect` are where this end and the other one are, `key` is the key file that both have (`generate_key`).
/// `device` is what `--device` takes, or an object with `read` and `write` (docs/guides/python.md); what else is told of it has the names of the
/// command's flags, as device_axes. Without `seconds` it goes on until it is stopped, and the means of its report are of the whole run.
/// With `arm=False` it waits for `arm()`. The user of a built-in scene does not push, unless `settings` has a push. What ends the
/// object lets go.
///
/// Raises ValueError for what is not allowed, and OSError for a file or an address that cannot be opened.
#[pyclass(module = "cohold", frozen, weakref)]
pub(crate) struct LivePeer {
    held: Arc<Held>,
    number: u8,
    axes: usize,
    is_simulated: bool,
}

impl LivePeer {
    /// Numbers along the shared axes as Python has them: one, or a tuple.
    fn along(&self, py: Python<'_>, numbers: [f64; MOST_AXES]) -> PyResult<Py<PyAny>> {
        if self.axes == 1 {
            return Ok(numbers[0].into_pyobject(py)?.into_any().unbind());
        }
        Ok(PyTuple::new(py, &numbers[..self.axes])?.into_any().unbind())
    }

    fn snapshot(&self, py: Python<'_>) -> Snapshot {
        py.detach(|| self.held.steering.snapshot())
    }

    /// Waits until `is_so`, or the peer has ended, or the time is over; whether it is so.
    fn wait_for(&self, py: Python<'_>, timeout_s: Option<f64>, is_so: impl Fn() -> bool + Sync) -> PyResult<bool> {
        let timeout_s = timeout_s.unwrap_or(LONGEST_S);
        if !(0.0..=LONGEST_S).contains(&timeout_s) {
            let must = format!("it must be a number from 0 to {LONGEST_S} s");
            return Err(refused(format!("timeout_s = {timeout_s} is not allowed: {must}")));
        }
        let by = Instant::now() + Duration::from_secs_f64(timeout_s);
        loop {
            let (so, over) = py.detach(|| {
                let over = self.held.outcome(false).is_some() || Instant::now() >= by;
                let so = is_so();
                if !so && !over {
                    std::thread::sleep(LOOK);
                }
                (so, over)
            });
            if so || over {
                return Ok(so);
            }
            py.check_signals()?;
        }
    }

    /// What was reported, once it has ended.
    fn told(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        match py.detach(|| self.held.outcome(false)) {
            None => Ok(None),
            Some(Ok(report)) => loads(py, report).map(Some),
            Some(Err(Why::System(said))) => Err(PyOSError::new_err(said.clone())),
            Some(Err(Why::Refused(said))) => Err(PyRuntimeError::new_err(said.clone())),
        }
    }
}

/// What a JSON text says.
fn loads(py: Python<'_>, text: &str) -> PyResult<Py<PyAny>> {
    Ok(py.import("json")?.call_method1("loads", (text,))?.unbind())
}

#[pymethods]
impl LivePeer {
    #[new]
    #[pyo3(signature = (scene, number, *, listen, connect, key, device = None, settings = None, seconds = None, patience_s = 30.0,
        anyway = false, arm = true, record = None, **device_settings))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        scene: &Bound<'_, PyAny>,
        number: u8,
        listen: &str,
        connect: &str,
        key: PathBuf,
        device: Option<&Bound<'_, PyAny>>,
        settings: Option<Named<'_>>,
        seconds: Option<f64>,
        patience_s: f64,
        anyway: bool,
        arm: bool,
        record: Option<PathBuf>,
        device_settings: Option<Named<'_>>,
    ) -> PyResult<Self> {
        if !(1..=2).contains(&number) {
            return Err(refused(format!("number = {number} is not allowed: it must be 1 or 2")));
        }
        for (name, time_s) in [("seconds", seconds.unwrap_or(1.0)), ("patience_s", patience_s)] {
            if !(time_s > 0.0 && time_s <= LONGEST_S) {
                return Err(refused(format!(
                    "{name} = {time_s} is not allowed: it must be above 0 and up to {LONGEST_S} s"
                )));
            }
        }
        if let Some(file) = record.as_ref().filter(|file| file.extension().is_none_or(|ending| ending != "mcap")) {
            let file = file.display();
            return Err(refused(format!("record = \"{file}\" is not allowed: a recording ends in .mcap")));
        }
        let over = scene.extract::<Named<'_>>().ok();
        let [named, simulated] = ["any-network", "simulated"].map(|name| PyString::new(py, name));
        let named = if over.is_some() { named.as_any() } else { scene };
        let mut scene = Scene { scene: meant(named)? };
        // The program is the user, and that of a built-in scene does not push.
        let name = named.extract::<String>().unwrap_or_default();
        if cohold_sim::scenes::text(&name).is_some() {
            scene.scene.set_number(&format!("user.{number}.push_n"), 0.0).map_err(refused)?;
        }
        for (key, value) in over.into_iter().chain(settings).flat_map(|all| all.0) {
            scene.put(&key, &value)?;
        }
        let device = device_of(device.unwrap_or(simulated.as_any()), device_settings)?;
        let is_simulated = matches!(device.kind, Kind::Simulated);
        if !is_simulated {
            limit(&mut scene, number)?;
        }
        let scene = scene.checked()?.clone();
        let law = scene.law().name;
        let known = cohold_guest_laws::laws().all();
        if known.iter().all(|known| known.name != law) {
            let must = "a law in Python would be asked in the middle of a tick, which waits for nobody";
            return Err(refused(format!("coordination.comm = \"{law}\" is not allowed in a live peer: {must}")));
        }
        let axes = scene.peer.axis.shared as usize;
        let ends = [address("listen", listen)?, address("connect", connect)?];
        let key = live_peer::LivePeer::key(&key).map_err(|cause| match cause {
            cohold_sim::Error::Io(..) => PyOSError::new_err(cause.to_string()),
            _ => refused(cause),
        })?;
        let span = Span { duration_s: seconds.unwrap_or(f64::INFINITY), patience_s };
        let anyway = if anyway { Ok(()) } else { Err("with anyway=True it does") };
        let peer = live_peer::LivePeer { scene, number, key, ends, span, anyway };
        let (steering, stop) = (Arc::new(Steering::new(arm)), Stop::default());
        let wanted = LiveOptions {
            record: record.map(|file| (file, peer.provenance(crate::provenance()))),
            manner: Manner::Quiet,
            device,
            steering: Some(steering.clone()),
            ..LiveOptions::default()
        };
        let own = stop.clone();
        let work = move || -> Outcome {
            let report: Report = peer.run(wanted, &own)?;
            serde_json::to_string(&report).map_err(|cause| Why::Refused(cause.to_string()))
        };
        let thread = std::thread::Builder::new().name("peer".to_owned()).spawn(work);
        let thread = thread.map_err(|cause| PyRuntimeError::new_err(format!("cannot start a thread: {cause}")))?;
        let (process, outcome) = (std::process::id(), OnceLock::new());
        let held = Arc::new(Held { steering, stop, process, thread: Mutex::new(Some(thread)), outcome });
        let this = Self { held, number, axes, is_simulated };
        remember(py, &this.held)?;
        // Until its socket and its device are open: what is wrong with them is an error here.
        this.wait_for(py, None, || this.held.steering.snapshot().has_begun)?;
        match this.held.outcome.get() {
            Some(Err(Why::Refused(said))) => Err(refused(said)),
            Some(Err(Why::System(said))) => Err(PyOSError::new_err(said.clone())),
            _ => Ok(this),
        }
    }

    /// What it was at its newest tick.
    #[getter]
    fn state(&self, py: Python<'_>) -> PyResult<LiveState> {
        let seen = self.snapshot(py);
        let along = |of: fn(&cohold_core::peer::Observed<f64>) -> f64| {
            let mut numbers = [0.0; MOST_AXES];
            numbers.iter_mut().zip(&seen.axes).for_each(|(to, axis)| *to = of(axis));
            self.along(py, numbers)
        };
        Ok(LiveState {
            time_s: seen.time_s,
            tick: seen.tick,
            mode: if seen.state.is_empty() { "calling" } else { seen.state },
            fault: seen.fault.clone(),
            hand_m: along(|seen| seen.device.position)?,
            hand_m_per_s: along(|seen| seen.device.velocity)?,
            object_m: along(|seen| seen.object.position)?,
            object_m_per_s: along(|seen| seen.object.velocity)?,
            peer_m: along(|seen| seen.desired.position)?,
            peer_m_per_s: along(|seen| seen.desired.velocity)?,
            force_n: self.along(py, seen.force_n)?,
            contact_force_n: along(|seen| seen.contact_force)?,
            coordination_force_n: along(|seen| seen.coordination_force)?,
        })
    }

    /// What its newest whole second was, and what was measured of the line in it: as `cohold peer --json-lines` says it; None before.
    #[getter]
    fn second(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let second = self.snapshot(py).second;
        second.map(|second| loads(py, &serde_json::to_string(&second).unwrap_or_default())).transpose()
    }

    /// What its scene is at the delays that were measured: stable, spectral_radius, one_way_ms, text, instead, not_judged; None before.
    #[getter]
    fn verdict(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let verdict = self.snapshot(py).verdict;
        verdict.map(|verdict| loads(py, &serde_json::to_string(&verdict).unwrap_or_default())).transpose()
    }

    /// Whether it has not ended.
    #[getter]
    fn running(&self, py: Python<'_>) -> bool {
        self.held.process == std::process::id() && py.detach(|| self.held.outcome(false).is_none())
    }

    /// What `cohold peer --json` reports at the end; None while it runs. Raises RuntimeError if the run failed.
    #[getter]
    fn report(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        self.told(py)
    }

    /// Arms it as soon as it may: the other end is there, and the verdict lets it. After a fault this forgets the fault.
    fn arm(&self, py: Python<'_>) {
        let is_faulted = self.snapshot(py).state == "faulted";
        py.detach(|| {
            self.held.steering.want(|wanted| {
                wanted.armed = true;
                wanted.clears += u64::from(is_faulted);
            });
        });
    }

    /// Turns its motors off, from the next tick on; the line stays, and `arm()` goes on.
    fn disarm(&self, py: Python<'_>) {
        py.detach(|| self.held.steering.want(|wanted| wanted.armed = false));
    }

    /// Whether the clutch is held open from here; the device's own button opens it, too.
    #[getter]
    fn clutch(&self, py: Python<'_>) -> bool {
        py.detach(|| self.held.steering.wanted().clutch)
    }

    #[setter]
    fn set_clutch(&self, py: Python<'_>, open: bool) {
        py.detach(|| self.held.steering.want(|wanted| wanted.clutch = open));
    }

    /// Has the hand at a simulated device push with this force beside what the scene's user does, N toward positive x, until told otherwise.
    fn push(&self, py: Python<'_>, force_n: Along) -> PyResult<()> {
        if !self.is_simulated {
            return Err(refused("push is for a simulated device: one that is really there has a hand of its own"));
        }
        let mut forces = [0.0; MOST_AXES];
        force_n.along("force_n", &mut forces[..self.axes])?;
        check(&forces)?;
        py.detach(|| self.held.steering.want(|wanted| wanted.pull_n = forces));
        Ok(())
    }

    /// Has a hand at a simulated device go there, m of the device's own (of the shared world, where `scale.position` is 1), or let go with None: from
    /// where the device is, at most 0.5 m/s fast, by a spring of 200 N/m and a damper of 12 N·s/m that pull with at most 10 N. Places that are told
    /// 60 times a second make a smooth motion.
    #[pyo3(signature = (position_m, /))]
    fn move_hand(&self, py: Python<'_>, position_m: Option<Along>) -> PyResult<()> {
        if !self.is_simulated {
            return Err(refused("move_hand is for a simulated device: one that is really there has a hand of its own"));
        }
        let place = position_m.map(|given| -> PyResult<_> {
            let mut place = [0.0; MOST_AXES];
            given.along("position_m", &mut place[..self.axes])?;
            let wrong = place.iter().find(|at| !(-FARTHEST_M..=FARTHEST_M).contains(*at));
            let must = format!("it must be a number from -{FARTHEST_M} to {FARTHEST_M} m");
            wrong.map_or(Ok(place), |at| Err(refused(format!("position = {at} is not allowed: {must}"))))
        });
        let place = place.transpose()?;
        py.detach(|| {
            self.held.steering.want(|wanted| {
                wanted.hand_m = place;
                wanted.moves += 1;
            });
        });
        Ok(())
    }

    /// Waits until it is armed and both ends are live; False if the time is over first. Raises RuntimeError if the run failed meanwhile.
    #[pyo3(signature = (timeout_s = None))]
    fn wait_armed(&self, py: Python<'_>, timeout_s: Option<f64>) -> PyResult<bool> {
        let armed = self.wait_for(py, timeout_s, || self.held.steering.snapshot().state == "armed")?;
        self.told(py).map(|ended| armed && ended.is_none())
    }

    /// Waits until it has ended; False if the time is over first. Raises RuntimeError if the run failed.
    #[pyo3(signature = (timeout_s = None))]
    fn wait(&self, py: Python<'_>, timeout_s: Option<f64>) -> PyResult<bool> {
        self.wait_for(py, timeout_s, || false)?;
        self.told(py).map(|ended| ended.is_some())
    }

    /// Lets go, tells the other end, and gives the report. Raises RuntimeError if the run failed.
    fn stop(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        self.close(py);
        self.told(py)
    }

    /// Lets go and tells the other end, whatever came of the run.
    fn close(&self, py: Python<'_>) {
        py.detach(|| self.held.end());
    }

    fn __enter__(this: Py<Self>) -> Py<Self> {
        this
    }

    #[pyo3(signature = (kind, error, traceback, /))]
    fn __exit__(
        &self,
        py: Python<'_>,
        kind: &Bound<'_, PyAny>,
        error: &Bound<'_, PyAny>,
        traceback: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let _ = (error, traceback);
        self.close(py);
        // What went wrong inside is told first.
        if kind.is_none() { self.told(py).map(drop) } else { Ok(()) }
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let state = match py.detach(|| self.held.outcome(false).is_some()) {
            true => "ended",
            false => self.snapshot(py).state,
        };
        format!("<LivePeer {}: {state}>", self.number)
    }
}

impl Drop for LivePeer {
    fn drop(&mut self) {
        // The interpreter may be at its end, or be held by whoever drops this.
        let held = &self.held;
        if Python::try_attach(|py| py.detach(|| held.end())).is_none() {
            held.end();
        }
    }
}

/// Makes a new key file for two peers; an existing file is left alone. Copy it to the other end over a way that you trust.
#[pyfunction]
pub(crate) fn generate_key(py: Python<'_>, file: PathBuf) -> PyResult<()> {
    let made = py.detach(|| live_peer::LivePeer::generate_key(&file));
    made.map_err(|cause| match cause {
        cohold_sim::Error::Io(..) => PyOSError::new_err(cause.to_string()),
        _ => refused(cause),
    })
}
