//! One peer alone: where its hand is and what the other peer sent come from Python, which has devices, hands and network of its own.

use cohold_core::device::Reading;
use cohold_core::law::Packet;
use cohold_core::num::{Motion, Scalar};
use cohold_core::peer::Sensors;
use cohold_core::safety::{Command, Mode};
use cohold_core::settings::Refused;
use cohold_sim::of_axes;
use cohold_sim::pair::HASH_SEED;
use cohold_sim::peers::{Builds, DynPeer};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::push::{Along, MOST_AXES};
use crate::raised::Raised;
use crate::run::unknown_scalar;
use crate::scene::meant;
use crate::work::{here, refused};

/// What a packet says along an axis; the unit is the end of the name.
const PACKET: [&str; 6] =
    ["position_m", "velocity_m_per_s", "wave_root_w", "energy_j", "wave_integral_root_w_s", "live_ticks"];

/// A packet along an axis, as [`PACKET`] names it.
type Row = [f64; PACKET.len()];
type Rows = [Row; MOST_AXES];

fn told<S: Scalar>(packet: &Packet<S>) -> Row {
    let [energy_j, wave_integral] = [packet.energy_j, packet.wave_integral].map(Scalar::to_f64);
    let Motion { position, velocity } = packet.motion;
    [position.to_f64(), velocity.to_f64(), packet.wave.to_f64(), energy_j, wave_integral, f64::from(packet.live_ticks)]
}

fn heard<S: Scalar>(row: &Row) -> Packet<S> {
    let [position, velocity, wave, energy_j, wave_integral, live_ticks] = *row;
    Packet {
        motion: Motion { position: S::from_f64(position), velocity: S::from_f64(velocity) },
        wave: S::from_f64(wave),
        energy_j: S::Counter::from_f64(energy_j),
        wave_integral: S::Counter::from_f64(wave_integral),
        // A count: what is no count saturates.
        live_ticks: live_ticks as u32,
    }
}

/// A peer of any number type that shares the object along any axes.
trait Steps: Send + Sync {
    /// A control period: place and speed along each axis, and what was heard; force along each axis, and what is to be sent.
    fn advance(&mut self, hand: &[[f64; 2]], packet: Option<&Rows>) -> ([f64; MOST_AXES], Option<Rows>);
    fn boxed(&self) -> Box<dyn Steps>;
    fn mode(&self) -> Mode;
    fn is_engaged(&self) -> bool;
    fn object_m(&self) -> [f64; MOST_AXES];
    fn hash(&self, before: u64) -> u64;
}

impl<S: Builds<SHARED, N>, const SHARED: usize, const N: usize> Steps for Box<dyn DynPeer<S, SHARED, N>> {
    fn advance(&mut self, hand: &[[f64; 2]], packet: Option<&Rows>) -> ([f64; MOST_AXES], Option<Rows>) {
        let mut axes = [Motion::REST; N];
        for (axis, [position, velocity]) in axes.iter_mut().zip(hand) {
            *axis = Motion { position: S::from_f64(*position), velocity: S::from_f64(*velocity) };
        }
        let packets = packet.map(|rows| std::array::from_fn(|axis| rows.get(axis).map_or_else(Packet::default, heard)));
        let (actuators, sent) = self.step(packets.as_ref(), &Sensors::of(Reading::Exact(axes)));
        let mut forces = [0.0; MOST_AXES];
        forces.iter_mut().zip(actuators.forces).for_each(|(to, force)| *to = force.to_f64());
        let sent = sent.map(|packets| {
            let mut rows = Rows::default();
            rows.iter_mut().zip(&packets).for_each(|(to, packet)| *to = told(packet));
            rows
        });
        (forces, sent)
    }

    fn boxed(&self) -> Box<dyn Steps> {
        Box::new(self.clone())
    }

    fn mode(&self) -> Mode {
        (**self).mode()
    }

    fn is_engaged(&self) -> bool {
        (**self).is_engaged()
    }

    fn object_m(&self) -> [f64; MOST_AXES] {
        let mut places = [0.0; MOST_AXES];
        places.iter_mut().zip(self.observed()).for_each(|(to, seen)| *to = seen.object.position.to_f64());
        places
    }

    fn hash(&self, before: u64) -> u64 {
        (**self).hash(before)
    }
}

fn built<S: Builds<SHARED, N>, const SHARED: usize, const N: usize>(
    scene: &cohold_sim::Scene,
    at: usize,
) -> Result<Box<dyn Steps>, Refused<'static>> {
    let mut peer = scene.peer::<S, SHARED, N>(at)?;
    peer.command(Command::Arm);
    Ok(Box::new(peer))
}

/// One peer of a scene, armed, for a program that has device, hand and network of its own: another simulator, or a trial of one's own.
///
/// Places and forces are of the shared world, in which x points from peer 1 to peer 2; along several shared axes each is a sequence. The
/// scene's device, users and network are not simulated; its verdict (`stability`) is about them all the same. A peer is a value:
/// `copy.copy(peer)` is a saved state that goes on by itself.
#[pyclass(module = "cohold", name = "Peer")]
pub(crate) struct Peer {
    peer: Box<dyn Steps>,
    /// As it was when it was made.
    first: Box<dyn Steps>,
    axes: usize,
    ticks: u64,
    start_m: [f64; MOST_AXES],
}

impl Peer {
    /// Numbers along the shared axes as Python has them: one, or a tuple.
    fn along<'py>(&self, py: Python<'py>, numbers: [f64; MOST_AXES]) -> PyResult<Bound<'py, PyAny>> {
        if self.axes == 1 {
            return Ok(numbers[0].into_pyobject(py)?.into_any());
        }
        Ok(PyTuple::new(py, &numbers[..self.axes])?.into_any())
    }

    /// A packet that Python gives: numbers in a row, or such a row for each axis.
    fn rows(&self, packet: &Bound<'_, PyAny>) -> PyResult<Rows> {
        let mut rows = Rows::default();
        let shape = |_| {
            let must = match self.axes {
                1 => format!("{} numbers, as Peer.PACKET names them", PACKET.len()),
                axes => format!(
                    "a tuple of {axes}, for each shared axis {} numbers, as Peer.PACKET names them",
                    PACKET.len()
                ),
            };
            refused(format!("packet is not allowed: it must have {must}"))
        };
        if self.axes == 1 {
            rows[0] = packet.extract().map_err(shape)?;
        } else {
            let given: Vec<Row> = packet.extract().map_err(shape)?;
            if given.len() != self.axes {
                return Err(shape(refused("")));
            }
            rows.iter_mut().zip(given).for_each(|(to, row)| *to = row);
        }
        Ok(rows)
    }
}

#[pymethods]
impl Peer {
    #[new]
    #[pyo3(signature = (scene, number, scalar = "f32"))]
    fn new(
        py: Python<'_>,
        #[pyo3(from_py_with = meant)] scene: cohold_sim::Scene,
        number: usize,
        scalar: &str,
    ) -> PyResult<Self> {
        if !(1..=2).contains(&number) {
            return Err(refused(format!("number = {number} is not allowed: it must be 1 or 2")));
        }
        let scalar = scalar.to_owned();
        here(py, move |_| {
            let scene = &scene;
            let at = number - 1;
            let peer = match scalar.as_str() {
                "f32" => of_axes!(scene, built::<f32>(scene, at)),
                "f64" => of_axes!(scene, built::<f64>(scene, at)),
                "i32f32" => of_axes!(scene, built::<cohold_core::num::Fixed>(scene, at)),
                other => return Err(unknown_scalar(other)),
            }
            .map_err(refused)?;
            let start_m = scene.start::<MOST_AXES>(at).map(|axis| axis.position);
            Ok(Self { first: peer.boxed(), peer, axes: scene.peer.axis.shared as usize, ticks: 0, start_m })
        })
    }

    /// The names of a packet's numbers along an axis; the unit is the end of the name.
    #[classattr]
    #[pyo3(name = "PACKET")]
    fn names() -> Vec<&'static str> {
        PACKET.to_vec()
    }

    /// A control period: the hand's place (m) and speed (m/s), and the newest packet that came of the other peer since the period before,
    /// or None. Gives the force on the device (N), and the packet to send to the other peer, or None between two of them.
    #[pyo3(signature = (position_m, velocity_m_per_s, packet = None))]
    fn tick<'py>(
        &mut self,
        py: Python<'py>,
        position_m: Along,
        velocity_m_per_s: Along,
        packet: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, Option<Bound<'py, PyTuple>>)> {
        let (mut places, mut speeds) = ([0.0; MOST_AXES], [0.0; MOST_AXES]);
        position_m.along("position_m", &mut places[..self.axes])?;
        velocity_m_per_s.along("velocity_m_per_s", &mut speeds[..self.axes])?;
        let mut hand = [[0.0; 2]; MOST_AXES];
        hand.iter_mut().zip(places.into_iter().zip(speeds)).for_each(|(to, (place, speed))| *to = [place, speed]);
        let packet = packet.map(|packet| self.rows(packet)).transpose()?;
        let raised = Raised::default();
        let (forces, sent) = raised.during(|| self.peer.advance(&hand[..self.axes], packet.as_ref()));
        raised.take().map_or(Ok(()), Err)?;
        self.ticks += 1;
        let sent = sent.map(|rows| {
            if self.axes == 1 {
                return PyTuple::new(py, rows[0]);
            }
            let each: PyResult<Vec<_>> = rows[..self.axes].iter().map(|row| PyTuple::new(py, *row)).collect();
            PyTuple::new(py, each?)
        });
        Ok((self.along(py, forces)?, sent.transpose()?))
    }

    /// Goes back to where it was when it was made: armed, at rest, before its first tick.
    fn reset(&mut self) {
        self.peer = self.first.boxed();
        self.ticks = 0;
    }

    fn __copy__(&self) -> Self {
        Self { peer: self.peer.boxed(), first: self.first.boxed(), ..*self }
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.__copy__()
    }

    /// Where the hand has to be at first, m: just clear of the object.
    #[getter]
    fn start_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.along(py, self.start_m)
    }

    /// Where this peer's copy of the object is, m.
    #[getter]
    fn object_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.along(py, self.peer.object_m())
    }

    /// Control periods done so far.
    #[getter]
    fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Whether its copy is coupled to the other one: not once it has stopped, nor while it hears nothing of the other peer.
    #[getter]
    fn engaged(&self) -> bool {
        self.peer.is_engaged()
    }

    /// Why it stopped; its forces are 0 from then on.
    #[getter]
    fn fault(&self) -> Option<String> {
        match self.peer.mode() {
            Mode::Faulted(fault) => Some(fault.explain().to_string()),
            _ => None,
        }
    }

    fn __repr__(&self) -> String {
        let stopped = self.fault().map_or(String::new(), |why| format!(", stopped: {why}"));
        format!("<Peer after {} ticks{stopped}>", self.ticks)
    }

    /// Hash of the state, continued from the one before.
    #[pyo3(signature = (before = HASH_SEED))]
    fn state_hash(&self, before: u64) -> u64 {
        self.peer.hash(before)
    }
}
