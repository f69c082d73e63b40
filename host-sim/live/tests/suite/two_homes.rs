//! The line's round trip falls from 80 ms to 16 ms and rises again, in virtual time. What hands feel of it is bounded, and nothing ends.

use haptic_meeting::Way;

use super::world::World;

/// Two ends, boards or not, whose direct path is found, dies and comes back; a path that dies is a step of less than this, N.
pub(crate) fn change_paths(boards: [bool; 2], longer_most_n: f64) -> World {
    let mut world = World::new(boards);
    world.run(6000);
    assert!(world.are_together(), "both hold it");
    let [direct_n, direct_m] = world.run(4000);
    assert_eq!(world.ways(), [Way::Direct; 2]);
    world.cut = true;
    let [longer_n, longer_m] = world.run(3000);
    let [relayed_n, relayed_m] = world.run(3000);
    assert_eq!(world.ways(), [Way::Relayed; 2]);
    world.cut = false;
    // ICE looks for it again; then the flow changes over.
    let [shorter_n, shorter_m] = world.run(15_000);
    assert!(world.ways().iter().all(|way| matches!(way, Way::Direct | Way::Both)), "{:?}", world.ways());
    eprintln!(
        "boards {boards:?}: largest change of F_T in a tick: direct {direct_n:.4} N, to relayed {longer_n:.4}, relayed {relayed_n:.4}, \
         to direct {shorter_n:.4}; apart: {:.2}, {:.2}, {:.2}, {:.2} mm",
        1e3 * direct_m,
        1e3 * longer_m,
        1e3 * relayed_m,
        1e3 * shorter_m
    );
    let steady_n = relayed_n.max(direct_n);
    // 0.013 N steadily, 0.018 to the shorter path, 0.65 to the longer: a line to which nothing comes for 47 ms stands, and goes on in a step.
    assert!(steady_n < 0.02 && shorter_n < 0.05, "a path that becomes shorter is no step");
    assert!(longer_n < longer_most_n, "a path that ends is a step of less than {longer_most_n} N");
    assert!(direct_m < relayed_m, "the shorter line is nearer");
    assert!(shorter_m <= 1.1 * relayed_m, "copies stay within what the longer path leaves");
    // Nothing comes for 47 ms there, which the copies go apart for.
    assert!(longer_m <= 2.0 * relayed_m, "copies stay within twice what the longer path leaves");
    assert!(world.are_together() && !world.have_parted());
    for (node, carrier) in world.nodes.iter().zip(world.carriers.iter().flatten()) {
        // Hundreds of copies, and one datagram that crossed the handshake.
        let (refused, copies) = (node.line.link.counts().refused, carrier.report().copies);
        assert!(refused <= 2 && copies > 100, "{refused} refused, {copies} copies");
    }
    world
}

#[test]
fn a_change_of_path_is_a_small_step_and_nothing_ends() {
    change_paths([false; 2], 0.8);
}

/// The step to a longer path depends on what the hands do when the shorter one dies: twelve moments of a second.
#[test]
fn a_path_that_dies_at_any_moment_ends_nothing() {
    let [mut most_n, mut most_m] = [0.0_f64; 2];
    for moment in 0..12 {
        let mut world = World::new([false; 2]);
        world.run(9500 + 87 * moment);
        assert_eq!(world.ways(), [Way::Direct; 2]);
        world.cut = true;
        let [jump_n, apart_m] = world.run(6000);
        assert!(world.ways() == [Way::Relayed; 2] && world.are_together() && !world.have_parted());
        [most_n, most_m] = [most_n.max(jump_n), most_m.max(apart_m)];
    }
    eprintln!("to relayed, at the worst of twelve moments: {most_n:.2} N in a tick, {:.1} mm apart", 1e3 * most_m);
    assert!(most_n < 1.6 && most_m < 5.2e-3, "{most_n} N, {most_m} m");
}
