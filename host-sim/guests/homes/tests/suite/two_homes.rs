//! The line's round trip falls from 80 ms to 16 ms and rises again, in virtual time. What hands feel of it is bounded, and nothing ends.

use cohold_homes::Way;

use super::homes_world::{AGAINST, LED, World};

/// Two ends, boards or not, whose direct path is found, dies and comes back; a path that dies is a step of less than this, N.
pub(crate) fn change_paths(boards: [bool; 2], longer_most_n: f64) -> World {
    let mut world = World::new(boards);
    world.run(6000);
    assert!(world.are_together(), "both hold it");
    let [direct_n, _, direct_m] = world.run(4000);
    assert_eq!(world.ways(), [Way::Direct; 2]);
    world.cut = true;
    let [longer_n, _, longer_m] = world.run(3000);
    let [relayed_n, _, relayed_m] = world.run(3000);
    assert_eq!(world.ways(), [Way::Relayed; 2]);
    world.cut = false;
    // ICE looks for it again; then the flow changes over.
    let [shorter_n, _, shorter_m] = world.run(15_000);
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
    // 0.013 N steadily, 0.018 to the shorter path, 0.07 to the longer, where for 47 ms nothing comes.
    assert!(steady_n < 0.02 && shorter_n < 0.05, "a path that becomes shorter is no step");
    assert!(longer_n < longer_most_n, "a path that ends is a step of less than {longer_most_n} N");
    assert!(direct_m < relayed_m, "the shorter line is nearer");
    assert!(shorter_m <= 1.1 * relayed_m, "copies stay within what the longer path leaves");
    // Nothing comes for 47 ms there, which the copies go apart for.
    assert!(longer_m <= 1.5 * relayed_m, "copies stay within 1.5 times what the longer path leaves");
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
    change_paths([false; 2], 0.1);
}

/// The step to a longer path depends on what the hands do when the shorter one dies: twelve moments of a second, as hands are led, push against each
/// other or shake. What the tank cannot pay for, 4 N on an object that goes at 0.3 m/s, is a step, and less of one with more in it.
#[test]
fn a_path_that_dies_at_any_moment_is_no_step() {
    const FASTER: &[&str] = &["user.1.sine_n=2", "user.1.sine_rad_per_s=12.566"];
    const HARDER: &[&str] = &["user.1.sine_n=4", "user.1.sine_rad_per_s=6.283"];
    const PAID: &[&str] = &["user.1.sine_n=4", "user.1.sine_rad_per_s=6.283", "coordination.carry_energy_j=0.2"];
    for (hands, most) in [
        (LED, [0.1, 0.06, 1.7e-3]),
        (AGAINST, [0.1, 0.03, 1.1e-3]),
        (FASTER, [0.15, 0.1, 3.3e-3]),
        (HARDER, [2.8, 0.75, 9.5e-3]),
        (PAID, [0.2, 0.12, 3.4e-3]),
    ] {
        let mut came = [0.0_f64; 3];
        for moment in 0..12 {
            let mut world = World::with(hands, [false; 2]);
            world.run(9500 + 87 * moment);
            assert_eq!(world.ways(), [Way::Direct; 2]);
            world.cut = true;
            let run = world.run(6000);
            assert!(world.ways() == [Way::Relayed; 2] && world.are_together() && !world.have_parted());
            came = [0, 1, 2].map(|at| came[at].max(run[at]));
        }
        let [force_n, hand_n, apart_m] = came;
        eprintln!(
            "{hands:?}, to relayed, at the worst of twelve moments: F_T {force_n:.3} N in a tick, a hand {hand_n:.3} N, {:.1} mm apart",
            1e3 * apart_m
        );
        assert!(came.iter().zip(most).all(|(came, most)| *came <= most), "{hands:?}: {came:?}, not {most:?}");
    }
}
