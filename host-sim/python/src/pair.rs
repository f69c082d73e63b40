//! Two peers, two devices and a network that Python steps, with forces of its own.

use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

use haptic_core::num::Fixed;
use haptic_core::safety::Mode;
use haptic_core::sample::{OfAxis, Reach, SAMPLE};
use haptic_report::numbered;
use haptic_sim::pair::HASH_SEED;
use haptic_sim::{Number, pair};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::{PyMemoryError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::raised::Raised;
use crate::run::{MOST_ROWS, unknown_scalar};
use crate::scene::Scene;
use crate::work::{here, refused};

/// What is seen of both peers after a tick.
const WIDTH: usize = 2 * SAMPLE.count(Reach::Steps);
type Row = [f64; WIDTH];

/// As far as `user.1.push_n` goes, too.
const LARGEST_N: f64 = 1000.0;

/// A force that is no number is refused, and none that no hand has.
fn check(forces: impl IntoIterator<Item = f64>) -> PyResult<()> {
    let wrong = forces.into_iter().find(|force| force.is_nan() || force.abs() > LARGEST_N);
    wrong.map_or(Ok(()), |force| {
        let must = format!("it must be a number from -{LARGEST_N} to {LARGEST_N} N");
        Err(refused(format!("force = {force} is not allowed: {must}")))
    })
}

enum Any {
    F32(pair::Pair<f32>),
    F64(pair::Pair<f64>),
    I32F32(pair::Pair<Fixed>),
}

macro_rules! with {
    ($any:expr, $pair:ident => $body:expr) => {
        match $any {
            Any::F32($pair) => $body,
            Any::F64($pair) => $body,
            Any::I32F32($pair) => $body,
        }
    };
}

/// One tick with these forces, toward the other peer.
fn tick<S: Number>(pair: &mut pair::Pair<S>, [first, second]: [f64; 2]) -> Row {
    // Peer 2's hand pushes toward negative x.
    for (side, force) in pair.sides_mut().zip([first, -second]) {
        side.plant.pull([force, 0.0]);
    }
    pair.step();
    let mut row = [0.0; WIDTH];
    let seen = pair.sides().into_iter().flat_map(|side| {
        let (observed, ledger) = (side.peer.observed()[0].map(S::to_f64), side.peer.ledger()[0]);
        let [received_j, sent_j] = [ledger.received_j(), ledger.sent_j()].map(S::to_f64);
        SAMPLE
            .reaching(Reach::Steps)
            .map(move |quantity| (quantity.get)(&OfAxis { observed: &observed, received_j, sent_j }))
    });
    row.iter_mut().zip(seen).for_each(|(to, number)| *to = number);
    row
}

/// Two peers in a scene, stepped by the tick; what the scene's users do, they do as well.
///
/// Forces are N toward the other peer, from -1000 to 1000. What a step gives is the 12 numbers that `COLUMNS` names, after the tick.
/// One thread at a time may step it.
#[pyclass(module = "haptic_sim", name = "Pair")]
pub(crate) struct Pair {
    pair: Arc<Mutex<Any>>,
}

/// The pair, unless a call that was interrupted still has it.
fn own(pair: &Mutex<Any>) -> PyResult<MutexGuard<'_, Any>> {
    match pair.try_lock() {
        Ok(own) => Ok(own),
        Err(TryLockError::Poisoned(own)) => Ok(own.into_inner()),
        Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(
            "a law that was interrupted in this pair has not come back yet: make another pair",
        )),
    }
}

/// An empty vector with room for so many.
fn room<T>(count: Option<usize>) -> PyResult<Vec<T>> {
    let mut room = Vec::new();
    let made = count.and_then(|count| room.try_reserve_exact(count).ok());
    made.map(|()| room).ok_or_else(|| PyMemoryError::new_err("there is no room for so many numbers"))
}

impl Pair {
    fn tick(&mut self, forces: [f64; 2]) -> PyResult<Row> {
        check(forces)?;
        let raised = Raised::default();
        let mut any = own(&self.pair)?;
        let row = raised.during(|| with!(&mut *any, pair => tick(pair, forces)));
        raised.take().map_or(Ok(row), Err)
    }

    fn look<T>(&self, at: impl FnOnce(&Any) -> T) -> PyResult<T> {
        Ok(at(&*own(&self.pair)?))
    }
}

fn stopped<S: Number>(pair: &pair::Pair<S>) -> Option<(usize, String)> {
    (1..).zip(pair.sides()).find_map(|(number, side)| match side.peer.mode() {
        Mode::Faulted(fault) => Some((number, fault.explain().to_string())),
        _ => None,
    })
}

#[pymethods]
impl Pair {
    #[new]
    #[pyo3(signature = (scene, scalar = "f64"))]
    fn new(py: Python<'_>, scene: &Scene, scalar: &str) -> PyResult<Self> {
        let (scene, scalar) = (scene.clone(), scalar.to_owned());
        let pair = here(py, move |_| {
            let scene = scene.checked()?;
            match scalar.as_str() {
                "f32" => pair::Pair::new(scene).map(Any::F32),
                "f64" => pair::Pair::new(scene).map(Any::F64),
                "i32f32" => pair::Pair::new(scene).map(Any::I32F32),
                other => return Err(unknown_scalar(other)),
            }
            .map_err(refused)
        })?;
        Ok(Self { pair: Arc::new(Mutex::new(pair)) })
    }

    /// The names of the 12 numbers, six of each peer; the unit is the end of the name.
    #[classattr]
    #[pyo3(name = "COLUMNS")]
    fn columns() -> Vec<String> {
        (1..=2)
            .flat_map(|peer| SAMPLE.reaching(Reach::Steps).map(move |quantity| numbered(quantity.name, peer)))
            .collect()
    }

    /// One tick: 12 numbers as a tuple.
    fn step<'py>(&mut self, py: Python<'py>, force_1_n: f64, force_2_n: f64) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.tick([force_1_n, force_2_n])?)
    }

    /// One tick into an array of 12 float64 that the caller keeps: nothing is allocated.
    fn step_into(&mut self, force_1_n: f64, force_2_n: f64, out: &Bound<'_, PyArray1<f64>>) -> PyResult<()> {
        let mut out = out.try_readwrite().map_err(refused)?;
        let mut out = out.as_array_mut();
        if out.len() != WIDTH {
            return Err(refused(format!("out of {} numbers is not allowed: it must have {WIDTH}", out.len())));
        }
        let row = self.tick([force_1_n, force_2_n])?;
        out.iter_mut().zip(row).for_each(|(out, number)| *out = number);
        Ok(())
    }

    /// As many ticks as `forces_n` has rows of two (user 1, user 2), 20,000,000 at the most: a row of 12 for each.
    fn steps<'py>(
        &mut self,
        py: Python<'py>,
        forces_n: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        // Element by element: however it lies in memory.
        let forces = forces_n.as_array();
        if forces.ncols() != 2 {
            let got = forces.ncols();
            return Err(refused(format!(
                "forces_n of {got} columns is not allowed: it must have 2, user 1 and user 2"
            )));
        }
        // A view may have many more rows than there is memory.
        let rows = forces.nrows();
        if rows > MOST_ROWS {
            let must = format!("it must have at most {MOST_ROWS}");
            return Err(refused(format!("forces_n of {rows} rows is not allowed: {must}")));
        }
        let mut own_forces: Vec<f64> = room(rows.checked_mul(2))?;
        own_forces.extend(forces.iter());
        check(own_forces.iter().copied())?;
        let pair = self.pair.clone();
        let flat = here(py, move |go_on| {
            let mut any = own(&pair)?;
            let mut flat = room(rows.checked_mul(WIDTH))?;
            for (at, of) in own_forces.chunks_exact(2).enumerate() {
                if at % 8 == 7 && !go_on() {
                    break;
                }
                flat.extend(with!(&mut *any, pair => tick(pair, [of[0], of[1]])));
            }
            Ok(flat)
        })?;
        PyArray1::from_vec(py, flat).reshape([rows, WIDTH])
    }

    /// Ticks done so far.
    #[getter]
    fn ticks(&self) -> PyResult<u64> {
        self.look(|any| with!(any, pair => pair.tick()))
    }

    /// Time of the next tick, s.
    #[getter]
    fn time_s(&self) -> PyResult<f64> {
        self.look(|any| with!(any, pair => pair.time_s()))
    }

    /// Which peer (1 or 2) stopped, and why.
    #[getter]
    fn fault(&self) -> PyResult<Option<(usize, String)>> {
        self.look(|any| with!(any, pair => stopped(pair)))
    }

    /// Hash of both peers' states, continued from the one before; after every tick of a run it is the run's `state_hash`.
    #[pyo3(signature = (before = HASH_SEED))]
    fn state_hash(&self, before: u64) -> PyResult<u64> {
        self.look(|any| with!(any, pair => pair.hash(before)))
    }
}
