//! How long packets are on their way, in control periods.

use cohold_sim::scene::{Network, Scene};

/// Control periods that a packet is on its way to peer 1 and to peer 2, from the exchange that sends it to the tick that hears it.
pub fn delays_ticks(linear: &Scene) -> [usize; 2] {
    let (network, timing) = (&linear.world.network, &linear.peer.timing);
    let own = network.one_way_delay_packets as usize * timing.ticks_per_packet as usize;
    let to = |added_s: f64| own + whole_ticks(added_s, timing.control_period_s);
    [to(network.extra_delay_s + network.asymmetry_s), to(network.extra_delay_s)]
}

/// The linear scene on a network on which packets take so many control periods to peer 1 and to peer 2.
pub(crate) fn at_delays(linear: &Scene, [to_first, to_second]: [usize; 2]) -> Scene {
    let (mut scene, period_s) = (linear.clone(), linear.peer.timing.control_period_s);
    let (extra_delay_s, all_s) = (to_second as f64 * period_s, to_first as f64 * period_s);
    scene.world.network =
        Network { one_way_delay_packets: 0, extra_delay_s, asymmetry_s: all_s - extra_delay_s, ..Network::default() };
    scene
}

/// Control periods that time on top of whole ones counts as: peers look once a tick, so that a fraction is one more. None
/// where it is negative: no packet comes before the constant delay is over.
pub(crate) fn whole_ticks(added_s: f64, period_s: f64) -> usize {
    // A boundary reached to within rounding is reached, as in `cohold_sim::network`.
    (added_s / period_s - 1e-6).ceil().max(0.0) as usize
}
