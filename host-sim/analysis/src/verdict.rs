//! The verdict on a scene: spectral radius, stable or not, how many states.
//!
//! [`Analyser`] keeps its memory from one scene to the next, which is what a sweep needs; [`verdict`] is for one scene.

use serde::Serialize;

use super::error::AnalysisError;
use super::lifted::driven::Response;
use super::lifted::pair::{Wholes, is_symmetric};
use super::lifted::{Lifted, prune, rest};
use super::spectrum::Spectrum;
use haptic_sim::scene::Scene;

/// How far outside the unit circle an eigenvalue may lie by rounding alone: a lossless scene has them on the circle.
pub const ROUNDING: f64 = 1e-9;

/// What the eigenvalues of one packet period say about a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Largest |eigenvalue| of the lifted matrix, rest modes left out; infinite where one period overflows (in JSON, which
    /// has no infinity: the largest number).
    #[serde(serialize_with = "finite")]
    pub spectral_radius: f64,
    /// No eigenvalue outside the unit circle (by more than [`ROUNDING`]).
    pub stable: bool,
    /// States of the pair that matter to the next packet period, rest modes included.
    pub states: usize,
    /// Rest modes left out: directions in which the pair can stand anywhere.
    pub rest_modes: usize,
    /// The pair was taken apart into sum and difference.
    pub symmetric: bool,
}

/// JSON has no infinity.
fn finite<S: serde::Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(value.min(f64::MAX))
}

impl Verdict {
    fn new(spectral_radius: f64, states: usize, rest_modes: usize, symmetric: bool) -> Self {
        Self { spectral_radius, stable: spectral_radius <= 1.0 + ROUNDING, states, rest_modes, symmetric }
    }
}

/// The verdict on the linear scene behind this one ([`Scene::linear`]).
pub fn verdict(scene: &Scene) -> Result<Verdict, AnalysisError> {
    Analyser::default().verdict(&scene.linear())
}

/// Computes verdicts, one scene after the other.
#[derive(Debug, Default)]
pub struct Analyser {
    responses: [Response; 2],
    whole: Lifted,
    pruner: prune::Pruner,
    kept: Lifted,
    spectrum: Spectrum,
}

impl Analyser {
    /// The verdict on a scene that is linear already.
    pub fn verdict(&mut self, linear: &Scene) -> Result<Verdict, AnalysisError> {
        let symmetric = is_symmetric(linear);
        let (mut radius, mut states, mut rest_modes) = (0.0_f64, 0, 0);
        let mut wholes = Wholes::new(linear, symmetric, &mut self.responses)?;
        let second = self.responses[0].states();
        let devices: &[usize] = if symmetric { &[0] } else { &[0, second] };
        while wholes.next(&self.responses, &mut self.whole) {
            let part = self.part(devices)?;
            radius = radius.max(part.0);
            states += part.1;
            rest_modes += part.2;
        }
        Ok(Verdict::new(radius, states, rest_modes, symmetric))
    }

    /// Spectral radius, states and rest modes of a lifted matrix from elsewhere; `devices` is one state of each device.
    pub fn judge(&mut self, lifted: Lifted, devices: &[usize]) -> Result<Verdict, AnalysisError> {
        self.whole = lifted;
        let (radius, states, rest_modes) = self.part(devices)?;
        Ok(Verdict::new(radius, states, rest_modes, false))
    }

    /// Radius, states and rest modes of the lifted matrix in `whole`.
    fn part(&mut self, devices: &[usize]) -> Result<(f64, usize, usize), AnalysisError> {
        let kept = self.pruner.kept(&self.whole.matrix, devices);
        let states = kept.len();
        prune::copy(&self.whole, kept, &mut self.kept);
        rest::idle(&mut self.kept);
        let rest_modes = rest::divide_out(&mut self.kept);
        let radius = self.spectrum.radius(&mut self.kept.matrix).ok_or(AnalysisError::NoConvergence)?;
        Ok((radius, states, rest_modes))
    }
}
