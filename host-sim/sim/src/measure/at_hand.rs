//! A run as hands have it: what their motors press with beside another run ([`super::hands`] has the largest force), how far the object
//! goes, and the energy of all that lies between the two copies.
//!
//! | figure | what |
//! |---|---|
//! | error | root mean square of what either motor presses with less the same of another run of the same motion, over the whole run |
//! | way | where both copies are in the end, their mean, in metres and over nothing |
//! | least balance | least, over the ends of all ticks, of what both copies have put into their coordination less what they have got from it, J |
//!
//! The balance is taken at the two object ports ([`super::port`]) at the same instant, and so is that of both laws' ends and the network
//! together, whatever a law books: of a link that is passive it is never below −E₀, what both ends began with.
//!
//! Nothing is measured after a peer has stopped.

use cohold_core::peer::Observed;
use cohold_core::settings::Refused;

use super::port::ObjectPort;
use crate::pair::Pair;
use crate::plant::Plant;
use crate::run::{Accounts, Options, Outcome, Ticked};
use crate::scene::Scene;

/// What both motors pressed with, N, tick by tick.
pub type Forces = Vec<[f32; 2]>;

/// What came of a run.
#[derive(Clone, Debug)]
pub struct AtHand {
    /// Its verdict and other figures.
    pub outcome: Outcome,
    /// Root mean square of the error of force at a hand, N; none without another run, or of one that stopped.
    pub error_rms_n: Option<f64>,
    /// Where both copies are in the end, their mean, m.
    pub way_m: f64,
    /// The least balance of energy of the link, J.
    pub least_balance_j: f64,
    /// What both motors pressed with.
    pub forces: Forces,
}

/// Runs an object that is shared along one axis for so long, s; `other` has the forces of a run of the same motion.
///
/// # Errors
/// The first key of the scene that is out of range or impossible beside the others.
pub fn run(scene: &Scene, duration_s: f64, other: Option<&[[f32; 2]]>) -> Result<AtHand, Refused<'static>> {
    let mut pair = Pair::<f64, Plant>::new(scene)?;
    let options = Options::unrecorded(duration_s);
    let ticks = options.ticks(scene);
    let mut accounts = Accounts::<1>::new(scene, ticks, options);
    let (period_s, stiffness) = (scene.peer.timing.control_period_s, scene.peer.coordination.stiffness_n_per_m);
    let mut ports = [ObjectPort::new(period_s, stiffness); 2];
    let mut forces = Forces::with_capacity(ticks as usize);
    let (mut least_balance_j, mut way_m) = (0.0_f64, 0.0);
    let mut now_n = [0.0; 2];
    for _ in 0..ticks {
        pair.step_watched(&mut |seen| {
            let at = seen.number - 1;
            let observed: Observed<f64> = *seen.peer.observed()[0];
            ports[at].see(&observed, [0.0; 2]);
            accounts.ticked(at, Ticked::of(seen.peer));
            accounts.pressed(at, seen.motors_n());
            now_n[at] = seen.actuators.forces[0];
        });
        accounts.period();
        least_balance_j = least_balance_j.min(ports.iter().map(|port| port.balance_j).sum());
        way_m = 0.5 * pair.sides().iter().map(|side| side.peer.observed()[0].object.position).sum::<f64>();
        forces.push(now_n.map(|force| force as f32));
        if pair.fault().is_some() {
            break;
        }
    }
    let packets_per_s = pair.packets_per_s();
    let outcome = Outcome { packets_per_s, ..accounts.outcome() };
    let whole = other.filter(|other| other.len() == forces.len() && outcome.fault.is_none());
    let error_rms_n = whole.map(|other| {
        let squares = other.iter().zip(&forces).flat_map(|(one, other)| [one[0] - other[0], one[1] - other[1]]);
        let sum: f64 = squares.map(|error| f64::from(error).powi(2)).sum();
        (sum / (2 * forces.len().max(1)) as f64).sqrt()
    });
    Ok(AtHand { outcome, error_rms_n, way_m, least_balance_j, forces })
}
