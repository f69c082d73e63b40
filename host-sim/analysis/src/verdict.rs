//! The verdict on a scene: spectral radius, stable or not, how many states.
//!
//! [`Analyser`] keeps its memory from one scene to the next, which is what a sweep needs; [`verdict`] is for one scene.

use haptic_core::settings::Refused;
use serde::Serialize;

use super::AnalysisError;
use super::lifted::closing::{End, close};
use super::lifted::driven::Response;
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
///
/// # Errors
/// Settings that the peer refuses.
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
    ///
    /// # Errors
    /// Settings that the peer refuses; eigenvalues that do not converge.
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
    ///
    /// # Errors
    /// Eigenvalues that do not converge.
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

/// Whether the two peers, their devices and both directions of the network are the same.
pub fn is_symmetric(linear: &Scene) -> bool {
    let arm = |user: usize| {
        let user = &linear.users[user].settings.user;
        (user.arm_stiffness_n_per_m, user.arm_damping_n_s_per_m, user.arm_mass_kg)
    };
    let [to_first, to_second] = delays_packets(linear);
    arm(0) == arm(1) && to_first == to_second
}

/// Packet periods that a packet is on its way to peer 1 and to peer 2: peers look once a period, so that time on top of
/// whole periods counts as one more.
pub fn delays_packets(linear: &Scene) -> [usize; 2] {
    let (network, timing) = (&linear.world.network, &linear.peer.timing);
    let packet_s = timing.control_period_s * f64::from(timing.ticks_per_packet);
    // A boundary reached to within rounding is reached, as in `haptic_sim::network`.
    let periods = |added_s: f64| (added_s / packet_s - 1e-9).ceil().max(0.0) as usize;
    let to = |added_s: f64| network.one_way_delay_packets as usize + periods(added_s);
    [to(network.extra_delay_s + network.asymmetry_s), to(network.extra_delay_s)]
}

/// The lifted matrices a scene falls apart into: sum and difference, or the pair as it is.
struct Wholes {
    delays: [usize; 2],
    signs: std::slice::Iter<'static, f64>,
    symmetric: bool,
}

impl Wholes {
    fn new(linear: &Scene, symmetric: bool, responses: &mut [Response; 2]) -> Result<Self, Refused<'static>> {
        responses[0].measure(linear, 0)?;
        if !symmetric {
            responses[1].measure(linear, 1)?;
        }
        let signs: &'static [f64] = if symmetric { &[1.0, -1.0] } else { &[1.0] };
        Ok(Self { delays: delays_packets(linear), signs: signs.iter(), symmetric })
    }

    /// Writes the next one into `whole`; false when there is none.
    fn next(&mut self, [first, second]: &[Response; 2], whole: &mut Lifted) -> bool {
        let Some(&sign) = self.signs.next() else { return false };
        let end = |response, hears, at: usize| End { response, hears, sign, delay_packets: self.delays[at] };
        if self.symmetric {
            close(&[end(first, 0, 0)], whole);
        } else {
            close(&[end(first, 1, 0), end(second, 0, 1)], whole);
        }
        true
    }
}

/// The lifted matrix of the whole pair, nothing left out and not taken apart, in the order peer 1, peer 2, packets on
/// their way to peer 1, to peer 2; local order as in [`super::lifted::driven`].
///
/// # Errors
/// Settings that the peer refuses.
pub fn pair_matrix(linear: &Scene) -> Result<Lifted, AnalysisError> {
    let mut responses = <[Response; 2]>::default();
    let mut whole = Lifted::default();
    Wholes::new(linear, true, &mut responses)?;
    responses[1].measure(linear, 1)?;
    let mut pair = Wholes { delays: delays_packets(linear), signs: [1.0].iter(), symmetric: false };
    pair.next(&responses, &mut whole);
    Ok(whole)
}
