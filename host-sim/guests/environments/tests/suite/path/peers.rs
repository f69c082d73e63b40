//! Two peers and somebody on the path between them.

use super::{Planted, Setup, finds, holds};

/// The scene of the paper's Figure 8 with a packet each tick and one solve a tick, as its line needs for users who let go.
const PAPER: Setup = Setup {
    scene: "paper-5.2-passive-wave-16ms",
    keys: &[
        "timing.ticks_per_packet=1",
        "object.integrator=midpoint",
        "object.force_delay_ticks=0",
        "coordination.decode=implicit",
        "user.2.sine_n=0",
    ],
    hub: false,
    lossless: false,
    planted: Planted::Nothing,
};

/// The recommended scene, but that silence is borne for 2 s and not for 8, which is longer than anybody is on the path, and that what is taken
/// back is given again before distances are compared.
const SELF_TIMED: Setup = Setup {
    scene: "any-network",
    keys: &["safety.fade_s=1.5", "safety.disengage_s=2", "coordination.taut_s=0.07"],
    lossless: true,
    ..PAPER
};

#[test]
fn nobody_on_the_path_harms_two_peers_of_the_paper() {
    let [apart_m, share, _, engaged_ms] = holds(PAPER, 300);
    // It does find what it may do: hold up one way of two, and hold back the last yes.
    assert!(apart_m < 1e-3 && share > 0.99 && engaged_ms > 100.0);
}

#[test]
fn nobody_on_the_path_harms_two_self_timed_peers() {
    let [apart_m, share, _, engaged_ms] = holds(SELF_TIMED, 100);
    assert!(apart_m < 1e-3 && share > 0.99 && engaged_ms > 2_000.0);
}

#[test]
fn the_search_finds_a_hand_that_moves_when_its_own_end_is_live() {
    finds(Setup { planted: Planted::OwnEndIsEnough, ..PAPER }, "live");
}

#[test]
fn the_search_finds_a_clock_that_forgets_the_time_since() {
    finds(Setup { planted: Planted::HalfTheRoundTrip, ..PAPER }, "stated");
}
