//! Two peers, two devices and a network that Python steps, with forces of its own.

use std::array::from_fn;
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

use cohold_core::num::Fixed;
use cohold_core::sample::{OfAxis, Reach, SAMPLE};
use cohold_core::settings::Refused;
use cohold_report::numbered;
use cohold_sim::pair::HASH_SEED;
use cohold_sim::peers::Builds;
use cohold_sim::{Plant, of_axes, pair};
use numpy::{AllowTypeChange, PyArray1, PyArrayDyn, PyArrayLikeDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::push::{Along, MOST_AXES, aligned, of_tick, of_ticks, room, written};
use crate::raised::Raised;
use crate::run::unknown_scalar;
use crate::scene::meant;
use crate::work::{here, refused};

/// What is seen of both peers along an axis after a tick.
const WIDTH: usize = 2 * SAMPLE.count(Reach::Steps);

/// Two peers of any number type that share the object along any axes.
pub(crate) trait Steps: Send {
    /// One tick with these forces toward the other peer, N: user 1's along each axis, then user 2's.
    fn advance(&mut self, forces_n: &[f64]);
    /// What is seen of both peers along each axis, at this level.
    fn see(&self, reach: Reach, put: &mut dyn FnMut(f64));
    /// What each peer's motors press with along a shared axis, N.
    fn motors_n(&self, axis: usize) -> [f64; 2];
    /// Which of the copies are coupled.
    fn engaged(&self) -> [bool; 2];
    fn ticks(&self) -> u64;
    fn time_s(&self) -> f64;
    fn stopped(&self) -> Option<(usize, String)>;
    fn hash(&self, before: u64) -> u64;
}

impl<S: Builds<SHARED, N>, const SHARED: usize, const N: usize> Steps for pair::Pair<S, Plant<N>, SHARED, N> {
    fn advance(&mut self, forces_n: &[f64]) {
        // Peer 2's hand pushes the opposite way, along the first axis toward negative x.
        for ((side, forces), toward) in self.sides_mut().zip(forces_n.chunks_exact(SHARED)).zip([1.0, -1.0]) {
            side.plant.pull(from_fn(|axis| forces.get(axis).map_or(0.0, |force| toward * force)));
        }
        self.step();
    }

    fn see(&self, reach: Reach, put: &mut dyn FnMut(f64)) {
        for axis in 0..SHARED {
            for side in self.sides() {
                let (observed, ledger) = (side.peer.observed()[axis].map(S::to_f64), side.peer.ledger()[axis]);
                let [received_j, sent_j] = [ledger.received_j(), ledger.sent_j()].map(S::to_f64);
                let of = OfAxis { observed: &observed, received_j, sent_j };
                SAMPLE.reaching(reach).for_each(|quantity| put((quantity.get)(&of)));
            }
        }
    }

    fn motors_n(&self, axis: usize) -> [f64; 2] {
        self.sides().map(|side| side.actuators().forces[axis].to_f64())
    }

    fn engaged(&self) -> [bool; 2] {
        self.sides().map(|side| side.peer.is_engaged())
    }

    fn ticks(&self) -> u64 {
        self.tick()
    }

    fn time_s(&self) -> f64 {
        Self::time_s(self)
    }

    fn stopped(&self) -> Option<(usize, String)> {
        self.fault().map(|(peer, fault)| (peer, fault.explain().to_string()))
    }

    fn hash(&self, before: u64) -> u64 {
        Self::hash(self, before)
    }
}

fn built<S: Builds<SHARED, N>, const SHARED: usize, const N: usize>(
    scene: &cohold_sim::Scene,
) -> Result<Box<dyn Steps>, Refused<'static>> {
    Ok(Box::new(pair::Pair::<S, Plant<N>, SHARED, N>::build(scene)?))
}

/// Both peers of this scene, armed and at rest, in this number type.
pub(crate) fn of_scene(scene: &cohold_sim::Scene, scalar: &str) -> PyResult<Box<dyn Steps>> {
    let pair = match scalar {
        "f32" => of_axes!(scene, built::<f32>(scene)),
        "f64" => of_axes!(scene, built::<f64>(scene)),
        "i32f32" => of_axes!(scene, built::<Fixed>(scene)),
        other => return Err(unknown_scalar(other)),
    };
    pair.map_err(refused)
}

type Shared = Arc<Mutex<Box<dyn Steps>>>;

/// Two peers in a scene, stepped by the tick; what the scene's users do, they do as well.
///
/// Forces are N toward the other peer, from -1000 to 1000: of each user a number, or, along several shared axes, as many (user 2's point
/// the opposite way along every axis). What a step gives is the 12 numbers that `COLUMNS` names, after the tick; along several axes a row
/// of them for each. One thread at a time may step it.
#[pyclass(module = "cohold", name = "Pair")]
pub(crate) struct Pair {
    pair: Shared,
    /// Axes along which the object is shared, and numbers that are seen of each.
    seen: [usize; 2],
}

/// The pair, unless a call that was interrupted still has it.
fn own(pair: &Mutex<Box<dyn Steps>>) -> PyResult<MutexGuard<'_, Box<dyn Steps>>> {
    match pair.try_lock() {
        Ok(own) => Ok(own),
        Err(TryLockError::Poisoned(own)) => Ok(own.into_inner()),
        Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(
            "a law that was interrupted in this pair has not come back yet: make another pair",
        )),
    }
}

impl Pair {
    /// One tick with what these users push with into a row of [`WIDTH`] numbers for each axis.
    fn tick(&mut self, pushes: [Along; 2], row: &mut [f64]) -> PyResult<()> {
        let forces = &of_tick(pushes, self.axes())?[..2 * self.axes()];
        let raised = Raised::default();
        let mut pair = own(&self.pair)?;
        raised.during(|| pair.advance(forces));
        let mut to = row.iter_mut();
        pair.see(Reach::Steps, &mut |number| to.next().into_iter().for_each(|to| *to = number));
        raised.take().map_or(Ok(()), Err)
    }

    /// Shape of what a step gives.
    fn seen(&self) -> &[usize] {
        if self.axes() == 1 { &self.seen[1..] } else { &self.seen }
    }

    /// Along how many axes the object is shared.
    fn axes(&self) -> usize {
        self.seen[0]
    }

    fn look<T>(&self, at: impl FnOnce(&dyn Steps) -> T) -> PyResult<T> {
        Ok(at(&**own(&self.pair)?))
    }
}

#[pymethods]
impl Pair {
    #[new]
    #[pyo3(signature = (scene, scalar = "f64"))]
    fn new(py: Python<'_>, #[pyo3(from_py_with = meant)] scene: cohold_sim::Scene, scalar: &str) -> PyResult<Self> {
        let scalar = scalar.to_owned();
        here(py, move |_| {
            let pair = Arc::new(Mutex::new(of_scene(&scene, &scalar)?));
            Ok(Self { pair, seen: [scene.peer.axis.shared as usize, WIDTH] })
        })
    }

    fn __repr__(&self) -> PyResult<String> {
        let stopped = self.fault()?.map_or(String::new(), |(peer, why)| format!(", peer {peer} stopped: {why}"));
        Ok(format!("<Pair after {} ticks{stopped}>", self.ticks()?))
    }

    /// The names of the 12 numbers, six of each peer; the unit is the end of the name.
    #[classattr]
    #[pyo3(name = "COLUMNS")]
    fn columns() -> Vec<String> {
        (1..=2)
            .flat_map(|peer| SAMPLE.reaching(Reach::Steps).map(move |quantity| numbered(quantity.name, peer)))
            .collect()
    }

    /// One tick: 12 numbers as a tuple; along several axes a tuple of one for each.
    fn step<'py>(&mut self, py: Python<'py>, force_1_n: Along, force_2_n: Along) -> PyResult<Bound<'py, PyTuple>> {
        let mut row = [0.0; MOST_AXES * WIDTH];
        let row = &mut row[..self.axes() * WIDTH];
        self.tick([force_1_n, force_2_n], row)?;
        if self.axes() == 1 {
            return PyTuple::new(py, &*row);
        }
        let axes: PyResult<Vec<_>> = row.chunks_exact(WIDTH).map(|along| PyTuple::new(py, along)).collect();
        PyTuple::new(py, axes?)
    }

    /// One tick into an array of 12 float64 that the caller keeps, or of 12 for each of several axes: nothing is allocated.
    fn step_into(&mut self, force_1_n: Along, force_2_n: Along, out: &Bound<'_, PyArrayDyn<f64>>) -> PyResult<()> {
        if out.shape() != self.seen() {
            let [given, must] = [out.shape(), self.seen()].map(written);
            return Err(refused(format!("out of shape {given} is not allowed: it must have shape {must}")));
        }
        aligned("out", out)?;
        let mut out = out.try_readwrite().map_err(refused)?;
        let mut row = [0.0; MOST_AXES * WIDTH];
        let row = &mut row[..self.axes() * WIDTH];
        self.tick([force_1_n, force_2_n], row)?;
        out.as_array_mut().iter_mut().zip(row).for_each(|(out, number)| *out = *number);
        Ok(())
    }

    /// As many ticks as `forces_n` has rows of two (user 1, user 2), 20,000,000 at the most: a row of 12 for each. Along several axes
    /// both have one dimension more: forces are (ticks, 2, axes), and what is given (ticks, axes, 12).
    fn steps<'py>(
        &mut self,
        py: Python<'py>,
        forces_n: PyArrayLikeDyn<'py, f64, AllowTypeChange>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (axes, own_forces) = (self.axes(), of_ticks(py, &forces_n, self.axes())?);
        let rows = own_forces.len() / (2 * axes);
        let pair = self.pair.clone();
        let flat = here(py, move |go_on| {
            let mut pair = own(&pair)?;
            let mut flat = room(rows.checked_mul(axes * WIDTH))?;
            for (at, of) in own_forces.chunks_exact(2 * axes).enumerate() {
                if at % 8 == 7 && !go_on() {
                    break;
                }
                pair.advance(of);
                pair.see(Reach::Steps, &mut |number| flat.push(number));
            }
            Ok(flat)
        })?;
        PyArray1::from_vec(py, flat).reshape([&[rows], self.seen()].concat())
    }

    /// Ticks done so far.
    #[getter]
    fn ticks(&self) -> PyResult<u64> {
        self.look(|pair| pair.ticks())
    }

    /// Time of the next tick, s.
    #[getter]
    fn time_s(&self) -> PyResult<f64> {
        self.look(|pair| pair.time_s())
    }

    /// Which peer (1 or 2) stopped, and why.
    #[getter]
    fn fault(&self) -> PyResult<Option<(usize, String)>> {
        self.look(|pair| pair.stopped())
    }

    /// Hash of both peers' states, continued from the one before; after every tick of a run it is the run's `state_hash`.
    #[pyo3(signature = (before = HASH_SEED))]
    fn state_hash(&self, before: u64) -> PyResult<u64> {
        self.look(|pair| pair.hash(before))
    }
}
