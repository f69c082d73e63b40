//! How far apart the two constructions of the lifted matrix are, entry by entry.
//!
//! Both are brought to the states that matter ([`prune`]; which these are must agree too) and to common units: the
//! powers of two that balance the constructed matrix ([`balance`]). The difference is the largest
//! |entry of one − entry of the other| in these units over the largest |entry|, or over 1 where all are smaller.

use cohold_core::law::Packet;
use cohold_core::num::StateVector;
use cohold_sim::scene::Scene;

use super::law::{TAUTNESS, number};
use super::{Constructed, Place, State, construct};
use crate::error::Error;
use crate::lifted::delay::delays_ticks;
use crate::lifted::driven::{TOO_LARGE, device_states};
use crate::lifted::pair::{hands_are_off, seat, seated_matrix};
use crate::lifted::{Lifted, prune};
use crate::matrix::{Matrix, column_mut};
use crate::modes::Hands;
use crate::spectrum::balance;
use crate::verdict::Analyser;

/// Rounding may put one on this side of the limit and the other on that.
const ALMOST: f64 = 1e-6;

/// What the comparison gave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Agreement {
    /// Largest difference of balanced entries, relative to the largest entry; infinite where other states matter.
    pub(super) matrix: f64,
    /// Difference of the spectral radii (driven by halves where the pair is symmetric), relative to the larger of it and 1.
    pub(super) spectral_radius: f64,
}

impl Agreement {
    /// The larger difference of each kind, of two comparisons.
    pub(super) fn or_farther(self, other: Self) -> Self {
        let [matrix, spectral_radius] =
            [[self.matrix, other.matrix], [self.spectral_radius, other.spectral_radius]].map(|[a, b]| a.max(b));
        Self { matrix, spectral_radius }
    }
}

/// Compares the two constructions on a mode of a linear scene (one hand: peer 1's); `None` where the scene has a model
/// without a second construction.
///
/// # Errors
/// A scene that cannot be built, or whose eigenvalues do not converge.
pub(super) fn agreement(linear: &Scene, hands: Hands) -> Result<Option<Agreement>, Error> {
    let released = [hands == Hands::None, hands != Hands::Both];
    let seats = released.map(|released| seat(linear, released));
    let seats = seats.each_ref().map(AsRef::as_ref);
    let Some(constructed) = construct(seats) else { return Ok(None) };
    let driven = seated_matrix(seats)?;
    if !driven.matrix.iter().all(|entry| entry.is_finite()) {
        // Grown beyond what is driven: the other must have grown as far, and no digit can be compared.
        let grown = !constructed.lifted.matrix.iter().all(|entry| entry.abs() < TOO_LARGE * ALMOST);
        let difference = if grown { 0.0 } else { f64::INFINITY };
        return Ok(Some(Agreement { matrix: difference, spectral_radius: difference }));
    }
    let matrix = compare(linear, &driven, &constructed);
    let mut analyser = Analyser::default();
    let delays = delays_ticks(linear);
    let says_all = crate::linear::matrix_says_all(linear)?;
    analyser.measure((linear, says_all), [hands != Hands::None, hands != Hands::Both], &[delays])?;
    let first = analyser.joined(released, delays)?.spectral_radius;
    let objects = objects(&constructed.places);
    let second = analyser
        .judge_held(constructed.lifted, &objects, !seats.iter().all(|seat| hands_are_off(seat)))?
        .spectral_radius;
    let spectral_radius = if first == second { 0.0 } else { (first - second).abs() / first.max(second).max(1.0) };
    Ok(Some(Agreement { matrix, spectral_radius }))
}

/// One state of each object.
fn objects(places: &[Place]) -> Vec<usize> {
    let object = |place: &Place| matches!(place, Place::Local { state: State::ObjectPosition, .. });
    (0..places.len()).filter(|at| object(&places[*at])).collect()
}

fn compare(linear: &Scene, driven: &Lifted, constructed: &Constructed) -> f64 {
    let in_flight = delays_packets(linear).iter().sum::<usize>() * packet();
    let order = Order::new(linear, driven.matrix.nrows() - in_flight);
    let kept = prune::kept(&constructed.lifted.matrix, &objects(&constructed.places));
    let same: Vec<Option<usize>> = kept.iter().map(|at| order.place(linear, constructed.places[*at])).collect();
    let mut ours: Vec<usize> = same.iter().flatten().copied().collect();
    ours.sort_unstable();
    if ours != prune::kept(&driven.matrix, &order.objects) {
        return f64::INFINITY;
    }
    let pick = |matrix: &Matrix, places: &[usize]| {
        let mut picked = Lifted::default();
        prune::copy(&Lifted { matrix: matrix.clone(), rest_modes: Vec::new() }, places, &mut picked);
        picked.matrix
    };
    let order: Vec<usize> = same.into_iter().flatten().collect();
    let (mut first, mut other) = (pick(&driven.matrix, &order), pick(&constructed.lifted.matrix, &kept));
    let mut units = vec![1.0; kept.len()];
    balance(&mut other, |at, factor| units[at] *= factor);
    let (mut largest, mut difference) = (1.0_f64, 0.0_f64);
    for (j, unit) in units.iter().enumerate() {
        for (i, entry) in column_mut(&mut first, j).iter_mut().enumerate() {
            *entry *= unit / units[i];
            largest = largest.max(other[(i, j)].abs());
            difference = difference.max((*entry - other[(i, j)]).abs());
        }
    }
    difference / largest
}

/// Where the driven pair has what the construction has.
struct Order {
    /// Of each peer, core's order of its states, as far as they are known here.
    locals: [Vec<Option<State>>; 2],
    /// Where the states of each peer begin, and where they end.
    starts: [usize; 3],
    /// Where the position of each object is.
    objects: [usize; 2],
}

impl Order {
    /// Of a pair of so many states of both peers together, which differ in how long their devices hold a force back.
    fn new(linear: &Scene, states: usize) -> Self {
        let devices = [0, 1].map(|index| device_states(linear, index));
        let second = (states + devices[0] - devices[1]) / 2;
        let locals = [0, 1].map(|index| driven_order(linear, index));
        Self { locals, starts: [0, second, states], objects: [devices[0], second + devices[1]] }
    }

    /// Where a place of the construction is in the driven pair.
    fn place(&self, linear: &Scene, place: Place) -> Option<usize> {
        match place {
            Place::Local { peer, state } => {
                self.locals[peer].iter().position(|known| *known == Some(state)).map(|at| self.starts[peer] + at)
            }
            Place::InFlight { to, slot, state } => {
                let field = match state {
                    State::ObjectPosition => 0,
                    State::ObjectVelocity => 1,
                    _ if linear.peer.coordination.comm == "self-timed" => 3,
                    _ => 2,
                };
                let before = if to == 0 { 0 } else { delays_packets(linear)[0] };
                Some(self.starts[2] + (before + slot) * packet() + field)
            }
        }
    }
}

/// Core's order of a peer's states, as far as they are known here.
fn driven_order(linear: &Scene, index: usize) -> Vec<Option<State>> {
    use State::*;
    let waiting = (0..linear.devices()[index].delay().0).map(DeviceWaiting);
    let device = [DevicePosition, DeviceVelocity, DeviceForce].into_iter().chain(waiting);
    let body = device.chain([ObjectPosition, ObjectVelocity]);
    // What is moved by ports remembers no force.
    let staged = (!linear.peer.object.integrator.solves()).then_some(ObjectForce);
    let law: &[Option<State>] = match linear.peer.coordination.comm {
        // u_in lies before what is sent: it is overwritten by the exchange, so it is no state of the construction.
        "wave" | "passive-wave" => {
            &[Some(DesiredPosition), Some(DesiredVelocity), Some(CoordinationForce), None, Some(Outgoing)]
        }
        // The sum before the mean is zero at every exchange.
        "passive-mean" => {
            &[Some(DesiredPosition), Some(DesiredVelocity), Some(CoordinationForce), None, None, Some(Outgoing)]
        }
        "self-timed" if number(linear, TAUTNESS) > 0.0 => {
            &[DesiredPosition, Outstanding, Outgoing, CoordinationForce, TautSooner, TautForce, TautWay].map(Some)
        }
        "self-timed" => &[DesiredPosition, Outstanding, Outgoing, CoordinationForce].map(Some),
        "power" => &[None, None],
        _ => &[],
    };
    let estimator = [Some(LastReading), Some(FilteredVelocity)];
    body.chain(staged).map(Some).chain(law.iter().copied()).chain(estimator).collect()
}

/// Numbers in a packet: position, velocity, wave, and what else core has come to send.
fn packet() -> usize {
    let mut numbers = 0;
    Packet::<f64>::default().visit(&mut |_| numbers += 1);
    numbers
}

/// Packet periods that a packet is on its way to peer 1 and to peer 2: [`delays_ticks`], of which only whole packet periods count.
fn delays_packets(linear: &Scene) -> [usize; 2] {
    delays_ticks(linear).map(|ticks| ticks / linear.peer.timing.ticks_per_packet as usize)
}
