//! The degradation by silence as a link climbs down it, and what comes after.

use cohold_protocol::link::{Link, Notice, Stage};
use cohold_protocol::wire::Telemetry;

use crate::protocol::world::{CLEAN, PERIOD, World, config};

/// Cuts the wire to peer 1 for `us` and gives what was reported to peer 1 meanwhile and until both are engaged again.
fn told_after_a_cut(us: u64) -> Vec<Notice> {
    let mut world = World::engaged(1);
    world.notices[1].clear();
    world.cut[1] = true;
    world.run(us);
    world.cut[1] = false;
    assert!(world.run_until(500_000, World::is_engaged).is_some());
    world.notices[1].clone()
}

#[test]
fn short_silence_goes_unnoticed() {
    assert_eq!(told_after_a_cut(2 * PERIOD), []);
}

#[test]
fn longer_silence_fades_and_resumes() {
    assert_eq!(told_after_a_cut(8 * PERIOD), [Notice::Fading, Notice::Resumed]);
}

#[test]
fn long_silence_ends_the_session_and_begins_another() {
    for us in [13 * PERIOD, 1_000_000, 60_000_000] {
        let wanted = [Notice::Fading, Notice::Disengaged, Notice::Lost, Notice::Joined, Notice::Engaged];
        assert_eq!(told_after_a_cut(us), wanted);
    }
}

#[test]
fn a_peer_that_sends_no_flow_keeps_its_session() {
    let mut world = World::engaged(3);
    world.notices = [vec![], vec![]];
    world.quiet[0] = true;
    world.run(5_000_000);
    assert_eq!(world.stages(), [Stage::Running, Stage::Idle]);
    assert_eq!(world.notices, [vec![], vec![Notice::Fading, Notice::Disengaged]]);
    world.quiet[0] = false;
    assert!(world.run_until(200_000, World::is_engaged).is_some());
    assert_eq!(world.notices[1].last(), Some(&Notice::Engaged));
    // The same with both quiet: probes alone keep it alive.
    world.quiet = [true, true];
    world.run(5_000_000);
    assert_eq!(world.stages(), [Stage::Idle; 2]);
}

/// Flow each 56 ms instead of 8: a link that is configured so says little more than that, and gives up a dead peer as
/// soon as one that was not.
#[test]
fn a_link_that_keeps_silent_adds_little_to_its_flow_and_is_no_slower_to_give_up() {
    let run = |longest_us: u32| {
        let mut world = World::new(8, CLEAN);
        for (link, (local, remote)) in world.links.iter_mut().zip([(1, 2), (2, 1)]) {
            let entropy = [local; 32];
            *link =
                Link::new(config(local, remote, entropy)).unwrap().disengage_after(480_000).keeping_silent(longest_us);
        }
        world.run(1_000_000);
        assert!(world.is_engaged());
        world.log = Some([vec![], vec![]]);
        world.notices = [vec![], vec![]];
        world.flows = [vec![], vec![]];
        for ms in 0..5_600 {
            world.quiet = [ms % 56 >= 8; 2];
            world.step();
            assert!(world.is_engaged());
        }
        assert_eq!(world.notices, [vec![], vec![]]);
        assert!(world.flows.iter().all(|flows| flows.len().abs_diff(100) <= 1));
        let said = world.log.as_ref().unwrap().each_ref().map(Vec::len);
        world.off[0] = true;
        let gone = world.run_until(1_000_000, |world| world.notices[1].contains(&Notice::Disengaged));
        (said, gone.unwrap())
    };
    let ([chatty, _], within) = run(0);
    let ([quiet, _], as_well) = run(56_000);
    assert!(chatty > 300 && (100..130).contains(&quiet), "{chatty} and {quiet} datagrams in 5.6 s");
    assert!(within.abs_diff(as_well) <= 10_000 && (420_000..500_000).contains(&as_well), "{within} and {as_well} µs");
}

#[test]
fn one_way_silence_is_noticed_at_both_ends() {
    let mut world = World::engaged(4);
    world.cut[1] = true;
    world.run(400_000);
    // Peer 1 hears nothing and calls; peer 0 hears its hellos and knows that the session is over.
    assert_ne!(world.stages()[0], Stage::Running);
    assert_eq!(world.stages()[1], Stage::Calling);
}

#[test]
fn late_flow_is_dropped_and_counted() {
    let mut world = World::engaged(5);
    world.impairment.jitter = 12_000;
    world.impairment.duplicate = 0.2;
    world.flows = [vec![], vec![]];
    world.run(20_000_000);
    for peer in [0, 1] {
        let ticks: Vec<u32> = world.flows[peer].iter().map(|flow| flow.tick).collect();
        assert!(ticks.is_sorted_by(|a, b| a < b), "only newer flow is handed out");
        let counts = world.links[peer].counts();
        assert!(counts.late > 50, "{counts:?}");
        assert!((2_450..=2_500).contains(&(ticks.len() as u32 + counts.late)), "{} and {counts:?}", ticks.len());
        assert!(counts.missing < 4, "{counts:?}");
    }
    assert_eq!(world.stages(), [Stage::Running; 2]);
}

#[test]
fn lost_datagrams_are_counted() {
    let mut world = World::engaged(6);
    world.impairment.loss = 0.2;
    world.run(40_000_000);
    let counts = world.links[0].counts();
    let share = f64::from(counts.missing) / f64::from(counts.missing + counts.taken);
    assert!((0.18..0.22).contains(&share), "{counts:?}");
}

#[test]
fn telemetry_says_what_the_link_knows_and_leaves_the_rest() {
    let mut world = World::engaged(7);
    world.clocks[1].0 = 7_000_000;
    world.restart(1);
    world.impairment.loss = 0.2;
    world.impairment.jitter = 12_000;
    world.run(10_000_000);
    let now = world.clock(0);
    let _ = world.links[0].receive(now, &mut [0; 40]);
    let mut telemetry = Telemetry { tick: 9, mode: 1, overruns: 3, ..Telemetry::default() };
    world.links[0].describe(now, &mut telemetry);
    let (link, counts) = (&world.links[0], world.links[0].counts());
    assert_eq!((telemetry.tick, telemetry.mode, telemetry.overruns), (9, 1, 3));
    assert_eq!(telemetry.stage, link.stage() as u8);
    assert!((telemetry.clock_offset_us - 2_000_000).abs() < 5_000, "{}", telemetry.clock_offset_us);
    assert!((8_000..30_000).contains(&telemetry.round_trip_us) && telemetry.jitter_us > 1_000, "{telemetry:?}");
    let told = (telemetry.packets_taken, telemetry.packets_missing, telemetry.flow_late, telemetry.refused);
    assert_eq!(told, (counts.taken, counts.missing, counts.late, counts.refused));
    assert!(counts.taken > 900 && counts.missing > 100 && counts.late > 10 && counts.refused > 0, "{counts:?}");
}

/// Peers that stand through silence keep their session as long as they are configured to.
#[test]
fn peers_that_are_apart_only_later_keep_their_session() {
    let mut world = World::engaged(1);
    world.links = world.links.map(|link| link.disengage_after(8_000_000));
    assert!(world.run_until(20_000_000, World::is_engaged).is_some());
    let session = world.links[1].session_number();
    world.notices[1].clear();
    world.cut[1] = true;
    world.run(7_900_000);
    assert_eq!(world.links[1].stage(), Stage::Fading);
    world.cut[1] = false;
    world.run(100_000);
    assert_eq!(world.notices[1], [Notice::Fading, Notice::Resumed]);
    assert_eq!(world.links[1].session_number(), session);
    world.cut[1] = true;
    world.run(8_100_000);
    assert_eq!(world.links[1].stage(), Stage::Calling);
}
