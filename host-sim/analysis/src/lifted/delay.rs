//! How long packets are on their way, in packet periods.

use haptic_sim::scene::Scene;

/// Packet periods that a packet is on its way to peer 1 and to peer 2.
pub fn delays_packets(linear: &Scene) -> [usize; 2] {
    let (network, packet_s) = (&linear.world.network, linear.peer.timing.packet_period_s());
    let to = |added_s: f64| network.one_way_delay_packets as usize + whole_packets(added_s, packet_s);
    [to(network.extra_delay_s + network.asymmetry_s), to(network.extra_delay_s)]
}

/// Packet periods that time on top of whole ones counts as: peers look once a period, so that a fraction is one more. None
/// where it is negative: no packet comes before the constant delay is over.
pub(crate) fn whole_packets(added_s: f64, packet_s: f64) -> usize {
    // A boundary reached to within rounding is reached, as in `haptic_sim::network`.
    (added_s / packet_s - 1e-9).ceil().max(0.0) as usize
}
