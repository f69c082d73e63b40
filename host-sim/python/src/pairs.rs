//! Many pairs of one scene that Python steps together: one call for all, without Python in between.
//!
//! Lanes are not for this: they hold scenes whose packets come together and which take the same branches, and pairs that have a seed and
//! a beginning of their own do neither. Each pair is stepped alone, to the last bit as [`Pair`](crate::pair::Pair) steps it, on threads
//! that end with the call.

use std::sync::{Mutex, PoisonError};
use std::thread;

use cohold_core::sample::{Reach, SAMPLE};
use cohold_report::numbered;
use cohold_sim::pair::HASH_SEED;
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayDyn, PyArrayLikeDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::pair::{Steps, of_scene};
use crate::push::{of_ticks, room, written};
use crate::raised::Raised;
use crate::scene::meant;
use crate::work::{here, refused};

/// What is seen of both peers along an axis after a tick: all their quantities, and what each one's motors press with.
const WIDTH: usize = 2 * (SAMPLE.count(Reach::Records) + 1);
/// Most pairs, and most threads.
const MOST: usize = 100_000;
const MOST_THREADS: usize = 256;
/// Most ticks of a call.
const MOST_TICKS: usize = 1_000_000;
/// Ticks of all pairs before Ctrl-C is looked for: some 20 ms.
const PART: usize = 1 << 14;

type Own = Box<dyn Steps>;

/// Many pairs of one scene, stepped together in one call, on so many threads: each is a `Pair` with a seed of its own, to the last bit, and
/// begins anew when it is told to.
///
/// What is seen of a pair is the 22 numbers that `COLUMNS` names; along several axes a row of them for each. One thread at a time may step them.
#[pyclass(module = "cohold", name = "Pairs")]
pub(crate) struct Pairs {
    scene: cohold_sim::Scene,
    scalar: String,
    /// Nobody waits for the lock: who has the whole has what is in it.
    pairs: Mutex<Vec<Own>>,
    count: usize,
    axes: usize,
    threads: usize,
}

/// A whole number between two ends.
fn within(name: &str, given: i64, [least, most]: [usize; 2]) -> PyResult<usize> {
    usize::try_from(given).ok().filter(|given| (least..=most).contains(given)).ok_or_else(|| {
        refused(format!("{name} = {given} is not allowed: it must be a whole number from {least} to {most}"))
    })
}

impl Pairs {
    fn own(&mut self) -> &mut [Own] {
        self.pairs.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// A shape of one number a pair, then these.
    fn shape(&self, each: &[usize]) -> Vec<usize> {
        [&[self.count], each].concat()
    }

    /// Shape of what is seen, without the pairs.
    fn row(&self) -> Vec<usize> {
        if self.axes == 1 { vec![WIDTH] } else { vec![self.axes, WIDTH] }
    }

    fn table<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (axes, each) = (self.axes, WIDTH / 2 - 1);
        let mut flat: Vec<f64> = room(self.count.checked_mul(axes * WIDTH))?;
        for pair in self.own() {
            let mut seen = Vec::with_capacity(axes * 2 * each);
            pair.see(Reach::Records, &mut |number| seen.push(number));
            for (axis, along) in seen.chunks_exact(2 * each).enumerate() {
                let motors_n = pair.motors_n(axis);
                for (quantities, motor_n) in along.chunks_exact(each).zip(motors_n) {
                    flat.extend_from_slice(quantities);
                    flat.push(motor_n);
                }
            }
        }
        PyArray1::from_vec(py, flat).reshape(self.shape(&self.row()))
    }

    /// So many ticks of all pairs, each with forces of its own.
    fn advance(&mut self, forces_n: &[f64], ticks: usize, raised: &Raised) {
        let (each, width) = (self.count.div_ceil(self.threads).max(1), 2 * self.axes);
        let step = |pairs: &mut [Own], forces_n: &[f64]| {
            raised.during(|| {
                for (pair, forces_n) in pairs.iter_mut().zip(forces_n.chunks_exact(width)) {
                    (0..ticks).for_each(|_| pair.advance(forces_n));
                }
            });
        };
        let step = &step;
        thread::scope(|scope| {
            let mut parts = self.own().chunks_mut(each).zip(forces_n.chunks(each * width));
            let own = parts.next();
            for (pairs, forces_n) in parts {
                scope.spawn(move || step(pairs, forces_n));
            }
            own.into_iter().for_each(|(pairs, forces_n)| step(pairs, forces_n));
        });
    }
}

#[pymethods]
impl Pairs {
    #[new]
    #[pyo3(signature = (scene, count, scalar = "f64", threads = 1))]
    fn new(
        py: Python<'_>,
        #[pyo3(from_py_with = meant)] scene: cohold_sim::Scene,
        count: i64,
        scalar: &str,
        threads: i64,
    ) -> PyResult<Self> {
        let (count, threads) = (within("count", count, [1, MOST])?, within("threads", threads, [1, MOST_THREADS])?);
        let scalar = scalar.to_owned();
        here(py, move |go_on| {
            let some = (0..count).take_while(|_| go_on());
            let pairs = some.map(|_| of_scene(&scene, &scalar)).collect::<PyResult<Vec<Own>>>()?;
            let axes = scene.peer.axis.shared as usize;
            Ok(Self { scene, scalar, pairs: Mutex::new(pairs), count, axes, threads })
        })
    }

    /// The names of the 22 numbers, 11 of each peer; the unit is the end of the name.
    #[classattr]
    #[pyo3(name = "COLUMNS")]
    fn columns() -> Vec<String> {
        let names = || SAMPLE.reaching(Reach::Records).map(|quantity| quantity.name).chain(["motor_n"]);
        (1..=2).flat_map(|peer| names().map(move |name| numbered(name, peer))).collect()
    }

    fn __repr__(&self) -> String {
        format!("<{} Pairs, {}>", self.count, self.scalar)
    }

    fn __len__(&self) -> usize {
        self.count
    }

    /// Has these pairs (numbers from 0) begin anew, armed and at rest, each with its `network.seed`.
    fn begin(&mut self, py: Python<'_>, pairs: Vec<i64>, seeds: Vec<i64>) -> PyResult<()> {
        if pairs.len() != seeds.len() {
            let (pairs, seeds) = (pairs.len(), seeds.len());
            return Err(refused(format!("{seeds} seeds are not allowed: there must be as many as pairs, {pairs}")));
        }
        let last = self.count - 1;
        let mut anew = Vec::new();
        for (pair, seed) in pairs.into_iter().zip(seeds) {
            anew.push((within("pair", pair, [0, last])?, within("seed", seed, [0, u32::MAX as usize])? as u32));
        }
        let (scalar, mut scene) = (self.scalar.clone(), self.scene.clone());
        let own = self.own();
        let raised = Raised::default();
        for (pair, seed) in anew {
            scene.world.network.seed = seed;
            own[pair] = py.detach(|| raised.during(|| of_scene(&scene, &scalar)))?;
            py.check_signals()?;
        }
        raised.take().map_or(Ok(()), Err)
    }

    /// So many ticks of all pairs, 1,000,000 at the most, each with its row of `forces_n` held: (pairs, 2), user 1 and user 2, along several
    /// axes (pairs, 2, axes). Gives what is seen after the last one: (pairs, 22), along several axes (pairs, axes, 22).
    #[pyo3(signature = (forces_n, ticks = 1))]
    fn steps<'py>(
        &mut self,
        py: Python<'py>,
        forces_n: PyArrayLikeDyn<'py, f64, AllowTypeChange>,
        ticks: i64,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let mut ticks = within("ticks", ticks, [1, MOST_TICKS])?;
        let each = [2, self.axes];
        let must = self.shape(if self.axes == 1 { &each[..1] } else { &each });
        if forces_n.shape() != must {
            let [given, must] = [forces_n.shape(), &must].map(written);
            let what = "for each pair user 1 and user 2";
            return Err(refused(format!(
                "forces_n of shape {given} is not allowed: it must have shape {must}, {what}"
            )));
        }
        let forces_n = of_ticks(py, &forces_n, self.axes)?;
        let (part, raised) = ((PART / self.count).max(1), Raised::default());
        while ticks > 0 {
            let now = ticks.min(part);
            py.detach(|| self.advance(&forces_n, now, &raised));
            raised.take().map_or(Ok(()), Err)?;
            py.check_signals()?;
            ticks -= now;
        }
        self.table(py)
    }

    /// What is seen now, as `steps` gives it.
    fn seen<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.table(py)
    }

    /// Which copies are coupled, (pairs, 2): not once a peer has stopped, nor while it hears nothing of the other one.
    #[getter]
    fn engaged<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        let flat: Vec<bool> = self.own().iter().flat_map(|pair| pair.engaged()).collect();
        PyArray1::from_vec(py, flat).reshape([self.count, 2])
    }

    /// Of each pair which peer (1 or 2) stopped, and why.
    #[getter]
    fn faults(&mut self) -> Vec<Option<(usize, String)>> {
        self.own().iter().map(|pair| pair.stopped()).collect()
    }

    /// Of each pair what `Pair.state_hash` gives.
    fn state_hashes(&mut self) -> Vec<u64> {
        self.own().iter().map(|pair| pair.hash(HASH_SEED)).collect()
    }
}
