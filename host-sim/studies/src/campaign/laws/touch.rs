//! What a hand feels of a law on the scene's own network: an impedance at every frequency, a mass, a drag.
//!
//! **Z-width**: by how much the impedance to a far hand that holds its device is above that to one that has let go, in decibels, mean
//! over the frequencies up to [`WIDTH_TO_HZ`], about as fast as a hand follows what it does not foresee, and below the resonances of object and
//! contacts in the campaign's scene (Colgate & Brown 1994 call it so of walls). A stiff link without delay has much, one that is not there 0 dB.
//!
//! **Needed damping**: what the device would have to have beside its own damping for the felt impedance to be passive at every
//! frequency up to [`PASSIVE_TO_HZ`], with the far hand on or off: −Re Z where that is largest. 0 is passive as it is. Above, contact, sampling and
//! hold are felt whatever the law: half the packet rate of the campaign's scene is 62.5 Hz.

use cohold_sim::measure::impedance::{
    BAND_HZ, Complex, POINTS, RemoteEnd, SPEED_M_PER_S, felt as impedance, frequencies_hz,
};
use cohold_sim::measure::swing;
use cohold_sim::scene::Scene;
use rayon::prelude::*;

use crate::Error;

/// Highest frequency of the Z-width, Hz.
pub const WIDTH_TO_HZ: f64 = 2.0;

/// Highest frequency at which passivity is asked for, Hz.
pub const PASSIVE_TO_HZ: f64 = 50.0;

/// Periods of the swing.
const PERIODS: u32 = 20;

/// The impedance that is felt at a frequency.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Frequency of the hand's motion, Hz.
    pub frequency_hz: f64,
    /// With the far hand holding its device; none where the scene stopped or did not settle.
    pub held: Option<Complex>,
    /// With the far hand off.
    pub let_go: Option<Complex>,
}

/// What a hand feels.
#[derive(Clone, Debug)]
pub struct Touch {
    /// The impedance, frequency by frequency.
    pub points: Vec<Point>,
    /// Mass and drag that both hands feel together; of a scene that is stable.
    pub swing: Option<swing::Felt>,
}

impl Touch {
    /// Z-width, dB; none where any frequency of it has no answer.
    pub fn width_db(&self) -> Option<f64> {
        let band: Vec<&Point> = self.points.iter().filter(|point| point.frequency_hz <= WIDTH_TO_HZ).collect();
        let ratios = band.iter().map(|point| Some(20.0 * (point.held?.norm() / point.let_go?.norm()).log10()));
        Some(ratios.collect::<Option<Vec<f64>>>()?.iter().sum::<f64>() / band.len() as f64)
    }

    /// Damping that the device lacks, N·s/m; none where any frequency has no answer.
    pub fn needed_damping(&self) -> Option<f64> {
        let asked = self.points.iter().filter(|point| point.frequency_hz <= PASSIVE_TO_HZ);
        let parts = asked.flat_map(|point| [point.held, point.let_go]);
        parts.map(|z| Some(-z?.re)).try_fold(0.0_f64, |most, lacks| Some(most.max(lacks?)))
    }
}

/// Measures it; mass and drag where the scene is `stable`.
pub(super) fn felt(scene: &Scene, stable: bool) -> Result<Touch, Error> {
    let point = |frequency_hz: f64| {
        let at = |far| impedance(scene, far, frequency_hz, SPEED_M_PER_S);
        Ok::<_, Error>(Point { frequency_hz, held: at(RemoteEnd::Held)?, let_go: at(RemoteEnd::LetGo)? })
    };
    let points = frequencies_hz(scene, BAND_HZ, POINTS).into_par_iter().map(point).collect::<Result<_, _>>()?;
    let swing = stable.then(|| swing::felt(scene, PERIODS)).transpose()?;
    Ok(Touch { points, swing })
}
