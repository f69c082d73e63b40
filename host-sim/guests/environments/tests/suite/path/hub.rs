//! A hub with two peers, and somebody on the path of both lines.

use super::{Planted, Setup, finds, holds};

const HUB: Setup =
    Setup { scene: "hub", keys: &["timing.ticks_per_packet=4"], hub: true, lossless: false, planted: Planted::Nothing };

#[test]
fn nobody_on_the_path_harms_a_hub_and_its_peers() {
    let [apart_m, share, _, engaged_ms] = holds(HUB, 300);
    assert!(apart_m < 1e-3 && share > 0.99 && engaged_ms > 100.0);
}

#[test]
fn the_search_finds_a_hand_that_moves_when_its_own_end_is_live() {
    finds(Setup { planted: Planted::OwnEndIsEnough, ..HUB }, "live");
}

#[test]
fn the_search_finds_a_clock_that_forgets_the_time_since() {
    finds(Setup { planted: Planted::HalfTheRoundTrip, ..HUB }, "stated");
}

/// Flow of the last second counts as if it had just been said.
#[test]
fn the_search_finds_an_end_that_takes_old_flow() {
    let keys = &["timing.ticks_per_packet=4", "safety.max_delay_s=1"];
    finds(Setup { keys, planted: Planted::AnyAge, ..HUB }, "engage");
}
