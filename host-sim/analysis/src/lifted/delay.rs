//! How long packets are on their way, in control periods.

use haptic_sim::scene::Scene;

/// Control periods that a packet is on its way to peer 1 and to peer 2, from the exchange that sends it to the tick that hears it.
pub fn delays_ticks(linear: &Scene) -> [usize; 2] {
    let (network, timing) = (&linear.world.network, &linear.peer.timing);
    let own = network.one_way_delay_packets as usize * timing.ticks_per_packet as usize;
    let to = |added_s: f64| own + whole_ticks(added_s, timing.control_period_s);
    [to(network.extra_delay_s + network.asymmetry_s), to(network.extra_delay_s)]
}

/// Packet periods that a packet is on its way to peer 1 and to peer 2: [`delays_ticks`], of which only whole packet periods count.
pub(crate) fn delays_packets(linear: &Scene) -> [usize; 2] {
    delays_ticks(linear).map(|ticks| ticks / linear.peer.timing.ticks_per_packet as usize)
}

/// Control periods that time on top of whole ones counts as: peers look once a tick, so that a fraction is one more. None
/// where it is negative: no packet comes before the constant delay is over.
pub(crate) fn whole_ticks(added_s: f64, period_s: f64) -> usize {
    // A boundary reached to within rounding is reached, as in `haptic_sim::network`.
    (added_s / period_s - 1e-6).ceil().max(0.0) as usize
}
