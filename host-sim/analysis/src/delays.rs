//! Every constant delay that a network table can produce: as it is, after its step, and each whole number of control periods
//! within uniform jitter.
//!
//! Two peers hear each other around one loop: whole packet periods may be on either way of it without a change of any eigenvalue
//! but 0, only the **round trip** counts (let peer 2's clock be read some packet periods later, and as many move from the way
//! back to the way there). So one pair of delays is judged for each round trip, as even as the table allows: equal delays fall
//! apart into halves.
//!
//! Units: control periods. Not covered: how what is left of a round trip beside whole packet periods falls to the two ways (other
//! than evenly), a delay that changes from packet to packet, gamma jitter (it has no largest delay),
//! packets that are overtaken, a line's queue, a recording.

use std::ops::RangeInclusive;

use cohold_sim::scene::{Jitter, Scene};

use super::lifted::delay::{delays_ticks, whole_ticks};

/// Round trips judged at the most, spread evenly with both ends.
pub(crate) const MOST: usize = 17;

/// Delays to peer 1 and to peer 2 for every round trip that the table of `scene` can produce, shortest first, and whether that
/// is all of them. The delay of `linear`, the linear scene behind it, stands as it is.
pub(crate) fn delays(scene: &Scene, linear: &Scene) -> (Vec<[usize; 2]>, bool) {
    let (network, base) = (&scene.world.network, delays_ticks(linear));
    let timing = &scene.peer.timing;
    let whole_packets = |packets: u32| packets as usize * timing.ticks_per_packet as usize;
    let jitter_s = if network.jitter == Jitter::Uniform { network.jitter_s } else { 0.0 };
    let within = |added_s: f64| -> RangeInclusive<usize> {
        let ticks =
            |added_s: f64| whole_packets(network.one_way_delay_packets) + whole_ticks(added_s, timing.control_period_s);
        let (least, most) = (ticks(added_s), ticks(added_s + jitter_s));
        // Play-out makes everything as late as the fastest and its own depth, unless it is later than that.
        let played = least + whole_packets(network.playout_packets);
        least.max(played)..=most.max(played)
    };
    // A step at time 0 leaves nothing of what was before it.
    let steps = [(network.delay_step_at_s > 0.0).then_some(0.0), Some(network.delay_step_s)];
    let mut found: Vec<[usize; 2]> = Vec::new();
    for step_s in steps.into_iter().flatten() {
        let constant_s = network.extra_delay_s + step_s;
        let [to_first, to_second] = [constant_s + network.asymmetry_s, constant_s].map(within);
        let round_trips = to_first.start() + to_second.start()..=to_first.end() + to_second.end();
        found.extend(round_trips.map(|round_trip| split(round_trip, &to_first, &to_second)));
    }
    let round_trip = |pair: &[usize; 2]| pair[0] + pair[1];
    found.sort_by_key(round_trip);
    found.dedup_by_key(|pair| round_trip(pair));
    let (last, all) = (found.len() - 1, found.len() <= MOST);
    if !all {
        found = (0..MOST).map(|at| found[at * last / (MOST - 1)]).collect();
    }
    for own in found.iter_mut().filter(|pair| round_trip(pair) == round_trip(&base)) {
        *own = base;
    }
    (found, all)
}

/// A round trip as two delays within what each direction can have, as even as that allows.
fn split(round_trip: usize, to_first: &RangeInclusive<usize>, to_second: &RangeInclusive<usize>) -> [usize; 2] {
    let least = round_trip.saturating_sub(*to_second.end()).max(*to_first.start());
    let most = (round_trip - to_second.start()).min(*to_first.end());
    let first = round_trip.div_ceil(2).clamp(least, most);
    [first, round_trip - first]
}
