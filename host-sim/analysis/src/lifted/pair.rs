//! What two peers and the network between them fall apart into: sum and difference, or the pair as it is.

use haptic_core::settings::Refused;
use haptic_sim::scene::Scene;

use super::Lifted;
use super::closing::{End, close};
use super::driven::Response;
use crate::error::AnalysisError;

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
    let packet_s = timing.packet_period_s();
    // A boundary reached to within rounding is reached, as in `haptic_sim::network`.
    let periods = |added_s: f64| (added_s / packet_s - 1e-9).ceil().max(0.0) as usize;
    let to = |added_s: f64| network.one_way_delay_packets as usize + periods(added_s);
    [to(network.extra_delay_s + network.asymmetry_s), to(network.extra_delay_s)]
}

/// The lifted matrices a scene falls apart into: sum and difference, or the pair as it is.
pub(crate) struct Wholes {
    delays: [usize; 2],
    signs: std::slice::Iter<'static, f64>,
    symmetric: bool,
}

impl Wholes {
    pub(crate) fn new(
        linear: &Scene,
        symmetric: bool,
        responses: &mut [Response; 2],
    ) -> Result<Self, Refused<'static>> {
        responses[0].measure(linear, 0)?;
        if !symmetric {
            responses[1].measure(linear, 1)?;
        }
        let signs: &'static [f64] = if symmetric { &[1.0, -1.0] } else { &[1.0] };
        Ok(Self { delays: delays_packets(linear), signs: signs.iter(), symmetric })
    }

    /// Writes the next one into `whole`; false when there is none.
    pub(crate) fn next(&mut self, [first, second]: &[Response; 2], whole: &mut Lifted) -> bool {
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
/// their way to peer 1, to peer 2; local order as in `lifted::driven`.
pub fn pair_matrix(linear: &Scene) -> Result<Lifted, AnalysisError> {
    let mut responses = <[Response; 2]>::default();
    let mut whole = Lifted::default();
    Wholes::new(linear, true, &mut responses)?;
    responses[1].measure(linear, 1)?;
    let mut pair = Wholes { delays: delays_packets(linear), signs: [1.0].iter(), symmetric: false };
    pair.next(&responses, &mut whole);
    Ok(whole)
}
