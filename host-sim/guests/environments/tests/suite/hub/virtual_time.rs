//! Peers around a hub in virtual time: what they hold, whoever comes and goes.

use std::path::PathBuf;

use cohold_core::num::Motion;
use cohold_core::safety::Mode;
use cohold_environments::cooperative::hub::Hub;
use cohold_environments::cooperative::waves::Waves;
use cohold_live::node::{Line, MOST_NOTICES};
use cohold_protocol::end::End as _;
use cohold_protocol::key::Key;
use cohold_protocol::link::Notice;
use cohold_protocol::wire::{AxisFlow, Flow, Goodbye};
use cohold_sim::network::rule::Fate;
use cohold_sim::plant::Plant;
use cohold_sim::scene::Scene;

use super::trial::{HubTrial, Participant, built_in, key};

fn scene(keys: &[String]) -> Scene {
    built_in("hub", keys)
}

/// What the two users do, from 0.2 s on: what is armed by then step by step is engaged.
fn trace(side: usize) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("hub");
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(format!("user-{side}.csv"));
    let mut text = "time_s,force_n\n0,0\n".to_owned();
    for (at, force) in [0.0, 1.0, 0.9, -0.5, 1.2, 0.3, 1.0].into_iter().enumerate() {
        let force = if side == 1 { force } else { 0.6 * force + 0.1 * at as f64 };
        text += &format!("{},{force}\n", 0.2 + 0.35 * at as f64);
    }
    std::fs::write(&path, text).expect("a trace");
    format!("user.{side}.trace={}", path.display())
}

/// Sealed links, sessions, flow in f32 and the degradation change nothing: copies are where they are around the node in memory.
#[test]
fn peers_around_a_hub_are_the_waves_in_memory() {
    for users in [2, 3, 16] {
        let scene = scene(&[trace(1), trace(2)]);
        let mut memory = Waves::new(&scene, users).expect("peers around a node");
        let mut trial: HubTrial = HubTrial::new(scene, users);
        let mut farthest_m = 0.0_f64;
        for _ in 0..3_000 {
            trial.step();
            if trial.peers().all(|peer| peer.armed_ticks == 0) {
                continue;
            }
            memory.step();
            for (peer, copy) in trial.peers().zip(memory.copies()) {
                let distance_m = f64::from(peer.observed().object.position) - copy.position;
                farthest_m = farthest_m.max(copy.position.abs());
                // f32 here, f64 there.
                assert!(distance_m.abs() < 1e-7, "{users} users, tick {}: {distance_m} m apart", trial.engine.tick());
            }
        }
        assert!(farthest_m > 0.02 && trial.peers().all(|peer| peer.peer.mode() == Mode::Armed), "{farthest_m} m");
        assert!(trial.peers().all(|peer| peer.armed_ticks > 2_700), "they began late");
    }
}

/// Users push against each other through a hub of lines with a time of their own, those on even lines with 1 N, of three the others with
/// 0.5 N each: between two copies are four springs and two lines, (F₁ + F₂)·(2/K_T + T/b), T being what both ends of a line were
/// configured with. Of taut lines all ends take their part back.
#[test]
fn self_timed_lines_meet_in_a_copy() {
    for (users, credit_ticks, tautness) in
        [(2, 8, 0.0), (2, 20, 0.0), (2, 8, 0.9), (2, 20, 0.6), (3, 8, 0.9), (8, 8, 0.9), (8, 8, 0.0)]
    {
        let force_n = if users == 3 { 0.5 } else { 1.0 };
        let keys = ["user.2.push_n=1", "network.one_way_delay_packets=2"].map(str::to_owned);
        let push = format!("user.1.push_n={force_n}");
        let credit = format!("coordination.credit_ticks={credit_ticks}");
        let taut = format!("coordination.tautness={tautness}");
        let scene = built_in("any-network", &[&keys[..], &[credit, taut, push]].concat());
        let mut trial: HubTrial = HubTrial::new(scene, users);
        (0..20_000).for_each(|_| trial.step());
        let copies: Vec<f32> = trial.peers().map(|peer| peer.observed().object.position).collect();
        let coordination = &trial.scene.peer.coordination;
        let apart_m = f64::from((copies[0] - copies[1]).abs()) / (1.0 - tautness);
        let line_m = apart_m / (1.0 + force_n) - 2.0 / coordination.stiffness_n_per_m;
        let line_s = line_m * coordination.wave_impedance_n_s_per_m;
        // Who begins later than the other end may have made the line longer by what packets need.
        let credit_s = 1e-3 * f64::from(credit_ticks);
        assert!(
            (0.98 * credit_s..1.02 * (credit_s + 0.002)).contains(&line_s),
            "{users} users, tautness {tautness}: {apart_m} m apart without it, lines of {line_s} s"
        );
        let energy = trial.hub().junction.energy();
        // Each slip at the hub gives ½α·C·F² at most, for the C of one line.
        let slips_j = f64::from(users as u32) * 0.5 * tautness * 0.5 * apart_m;
        assert!(energy.sent_j > 0.0 && energy.sent_j <= energy.taken_j + slips_j, "{energy:?}, slips {slips_j} J");
    }
}

/// Through bursts, jitter, reordering and a life that ends in the middle, the copies of up to eight people stay together, and no more
/// energy goes back into the lines than came out of them ([`HubTrial::step`]). So it is where ends that are behind make up for it, and no farther apart.
#[test]
fn self_timed_lines_around_a_hub_stand_through_bursts() {
    const PEOPLE: [&str; 7] = [
        "user.1.arm_stiffness_n_per_m=200",
        "user.1.arm_damping_n_s_per_m=5",
        "user.1.push_n=1",
        "user.2.arm_stiffness_n_per_m=200",
        "user.2.arm_damping_n_s_per_m=5",
        "user.2.sine_n=1",
        "user.2.push_n=0.5",
    ];
    const BAD: [&str; 5] = [
        "network.loss=0.2",
        "network.loss_burst_packets=40",
        "network.jitter=uniform",
        "network.jitter_s=0.006",
        "network.duplicate=0.1",
    ];
    let mut means_m = Vec::new();
    for (users, network, even) in [
        (2, &[][..], "coordination.even_s=0"),
        (2, &[], "coordination.even_s=0.02"),
        (3, &BAD, "coordination.even_s=0"),
        (3, &BAD, "coordination.even_s=0.02"),
        (8, &BAD, "coordination.even_s=0"),
        (8, &BAD, "coordination.even_s=0.02"),
    ] {
        let keys: Vec<String> = PEOPLE.iter().chain(network).chain([&even]).map(|key| (*key).to_owned()).collect();
        let mut trial: HubTrial = HubTrial::new(built_in("any-network", &keys), users);
        let (mut farthest_m, mut sum_m) = (0.0_f64, 0.0);
        for tick in 0..12_000 {
            if tick == 6_000 {
                let device = trial.peers().last().expect("a peer").device();
                trial.restart(users - 1, device);
            }
            trial.step();
            let places = || trial.peers().map(|peer| f64::from(peer.observed().object.position));
            // The one that began anew is where its device is.
            if (1_000..6_000).contains(&tick) {
                let distance_m = places().fold(f64::MIN, f64::max) - places().fold(f64::MAX, f64::min);
                farthest_m = farthest_m.max(distance_m);
                sum_m += distance_m;
            }
        }
        assert!(trial.peers().all(|peer| peer.peer.mode() == Mode::Armed && peer.peer.is_engaged()));
        assert_eq!(trial.lives_on(users - 1), 2);
        means_m.push(sum_m / 5_000.0);
        println!("{users} users, {network:?}, {even}: {farthest_m} m, mean {means_m:?}");
        let most_m = if network.is_empty() { 3e-3 } else { 10e-3 };
        assert!(farthest_m < most_m, "{users} users, {network:?}: {farthest_m} m");
    }
    assert!(means_m.as_chunks().0.iter().all(|[without, with]| *with < 1.02 * without), "{means_m:?}");
}

/// One of four people falls silent, is let go without a jump, and comes back as another life; then so quickly that nobody
/// can have missed it. Clean, and with a tenth lost and the rest jittered.
#[test]
fn a_peer_that_restarts_is_let_go_and_taken_in_again() {
    const PEOPLE: [&str; 6] = [
        "user.1.arm_stiffness_n_per_m=200",
        "user.1.arm_damping_n_s_per_m=5",
        "user.1.push_n=0.5",
        "user.2.arm_stiffness_n_per_m=200",
        "user.2.arm_damping_n_s_per_m=5",
        "user.2.push_n=0.5",
    ];
    const BAD: [&str; 3] = ["network.loss=0.1", "network.jitter=uniform", "network.jitter_s=0.006"];
    for network in [&[][..], &BAD] {
        let keys: Vec<String> = PEOPLE.iter().chain(network).map(|key| (*key).to_owned()).collect();
        let mut trial: HubTrial = HubTrial::new(scene(&keys), 4);
        let mut forces = [0.0_f64; 4];
        // The largest change of a force from tick to tick: while all are there, and from the silence on.
        let mut jumps_n = [0.0_f64; 2];
        let mut back_at = None;
        for tick in 0..9_000 {
            match tick {
                4_000 => trial.engine.seats[3].off = true,
                5_000 => trial.restart(3, Plant::new(&trial.scene, 1)),
                7_000 => {
                    let device = trial.peers().nth(3).expect("it is back").device();
                    trial.restart(3, device);
                }
                _ => {}
            }
            trial.step();
            for (peer, before) in trial.peers().take(3).zip(&mut forces) {
                let force = f64::from(peer.observed().coordination_force);
                if tick >= 1_000 {
                    let jump_n = &mut jumps_n[usize::from(tick >= 4_000)];
                    *jump_n = jump_n.max((force - *before).abs());
                }
                *before = force;
            }
            let engaged = trial.hub().lines().nth(3).is_some_and(|(_, port)| port.is_engaged());
            if tick > 5_000 && engaged {
                back_at = back_at.or(Some(tick));
            }
            assert!(engaged || !(1_000..=4_000).contains(&tick), "not engaged at tick {tick}");
        }
        assert!(back_at.is_some_and(|tick| tick < 5_500), "back at {back_at:?}");
        assert_eq!(trial.lives_on(3), 3);
        assert!(trial.peers().all(|peer| peer.peer.mode() == Mode::Armed && peer.peer.is_engaged()));
        // What the network itself does, and a step of the degradation: a ninth of the push that the line carries. Where packets are
        // lost, that of a packet that is late and of the next one may come at once.
        let [calm_n, disturbed_n] = jumps_n;
        let steps = if network.is_empty() { 1.0 } else { 2.0 };
        assert!(disturbed_n < calm_n + steps * 0.5 / 9.0, "{network:?}: {disturbed_n} N, {calm_n} N before");
    }
}

/// Three people push; one of them falls silent, or is another life of itself: the force on the others' hands falls by no more than 0.02 N a tick
/// where lines have a time of their own. Waves end with what pays for them, in any loss, and a force with them in about 30 ms.
#[test]
fn nobody_feels_a_step_when_another_one_falls_silent() {
    for (name, most_n) in [("hub", 0.07), ("any-network", 0.02)] {
        for (push_n, leaves) in [(1.0, false), (3.0, false), (5.0, false), (1.0, true), (3.0, true), (5.0, true)] {
            let arms = [1, 2].map(|user| {
                let key = |name: &str, value: f64| format!("user.{user}.{name}={value}");
                [key("push_n", push_n), key("arm_stiffness_n_per_m", 200.0), key("arm_damping_n_s_per_m", 5.0)]
            });
            let soon = ["safety.fade_s=0.1", "safety.disengage_s=0.2"].map(str::to_owned);
            let mut trial: HubTrial = HubTrial::new(built_in(name, &[&arms.concat()[..], &soon].concat()), 3);
            let (mut before, mut steps_n) = ([0.0_f64; 3], [0.0_f64; 2]);
            // Somebody who comes again pushes anew meanwhile.
            for tick in 0..if leaves { 6_200 } else { 9_000 } {
                if tick == 6_000 && leaves {
                    let device = trial.peers().nth(1).expect("a peer").device();
                    trial.restart(1, device);
                }
                trial.engine.seats[1].off = tick >= 6_000 && !leaves;
                trial.step();
                for at in [0, 2] {
                    let Participant::Peer(node, _) = &trial.engine.seats[at].actor else { continue };
                    let now = f64::from(node.observed().contact_force);
                    let step_n = &mut steps_n[usize::from(tick >= 6_000)];
                    if tick > 5_000 {
                        *step_n = step_n.max((now - before[at]).abs());
                    }
                    before[at] = now;
                }
            }
            let told = format!("{name}, {push_n} N, leaves {leaves}: {steps_n:?} N a tick before and after");
            println!("{told}");
            assert!(
                steps_n[0] < 1e-4 && steps_n[1] <= if leaves { 1.4 * most_n } else { most_n } && steps_n[1] > 1e-3,
                "{told}"
            );
        }
    }
}

/// Any closure is a rule, here as in the relay: every third datagram on the way of one peer is lost, and all hold on.
#[test]
fn a_planted_rule_loses_what_it_says() {
    let mut trial: HubTrial = HubTrial::new(scene(&[]), 2);
    let every_third = |number: u64, _: u64| if number.is_multiple_of(3) { Fate::Drop } else { Fate::Pass };
    trial.engine.route(0, 2).rule = Some(Box::new(every_third));
    (0..3_000).for_each(|_| trial.step());
    assert!(trial.peers().all(|peer| peer.peer.mode() == Mode::Armed && peer.peer.is_engaged()));
    let [there, back] = [(0, 2), (2, 0)].map(|(from, to)| trial.engine.route(from, to).counts());
    assert_eq!((there.lost, back.lost), (there.taken.div_ceil(3), 0));
    // The hub learns of what it did not get.
    let (end, _) = trial.hub().lines().next().expect("a line");
    assert!(end.line.link.counts().missing > 100, "{there:?}");
}

#[test]
fn what_a_hub_cannot_be_made_for() {
    let refused = |users: usize, key_set: &str| {
        let scene = scene(&[key_set.to_owned()]);
        Hub::<usize, 1>::new(&scene, users, &key(), || Ok([1; Key::LEN])).expect_err("no hub").to_string()
    };
    for users in [0, 1, 17] {
        assert!(refused(users, "user.1.push_n=1").contains("from 2 to 16"));
    }
    let no_ledger = "coordination.drift_correction=false";
    let mut plain = scene(&[no_ledger.to_owned()]);
    plain.apply_override("coordination.ledger=false").expect("a good override");
    let said = Hub::<usize, 1>::new(&plain, 2, &key(), || Ok([1; Key::LEN])).expect_err("no hub").to_string();
    assert!(said.contains("coordination.ledger = false") && said.contains("true"), "{said}");
}

/// A peer that comes and goes all day: the newest notices are kept, and how often it came is known all the same.
#[test]
fn notices_of_a_line_take_bounded_memory() {
    let scene = scene(&[]);
    let line = |number: u8| Line::<1>::open(&scene, number, key(), [number; Key::LEN]).expect("a line");
    let (mut one, mut two, mut joined) = (line(1), line(2), 0);
    for round in 0..3_000_u64 {
        let (now, mut said) = (8_000 * round, [vec![], vec![]]);
        if round % 10 == 9 {
            two.link.say(now, Goodbye {}, |bytes| said[1].push(bytes.to_vec()));
        }
        one.link.say_due(now, |bytes| said[0].push(bytes.to_vec()));
        two.link.say_due(now, |bytes| said[1].push(bytes.to_vec()));
        let [to_two, to_one] = said;
        for (line, came) in [(&mut two, to_two), (&mut one, to_one)] {
            for mut bytes in came {
                let _ = line.receive(now, 0, &mut bytes);
            }
        }
        one.heed(now);
        let newest = one.notices.back();
        joined += u32::from(matches!(newest, Some((at, Notice::Joined)) if *at == now));
        assert!(one.notices.len() <= MOST_NOTICES);
    }
    assert!(joined > 200 && one.lives == 1, "{joined} sessions, {} lives", one.lives);
    assert_eq!(one.notices.len(), MOST_NOTICES);
    assert!(one.notices.back().is_some_and(|(at, _)| *at > 23_000_000), "{:?}", one.notices.back());
}

/// The wire as the others of a hub see it: one flow whose sum is finite and cannot be is not taken, its line is named, and the other two
/// go on holding what they hold; somebody new is taken in on that line.
#[test]
fn one_sum_that_cannot_be_harms_nobody() {
    let keys = ["user.1.push_n=0.5", "user.2.push_n=0.5", "network.one_way_delay_packets=2"].map(str::to_owned);
    for name in ["any-network", "hub"] {
        let mut trial: HubTrial = HubTrial::new(built_in(name, &keys), 3);
        (0..2_000).for_each(|_| trial.step());
        // The third says it in its own session.
        let Participant::Peer(node, hub) = &mut trial.engine.seats[2].actor else { panic!("a peer") };
        let (hub, mut said) = (*hub, vec![]);
        let now = 2_000_000;
        let axis = AxisFlow { wave_integral: 1.7e308, live_ticks: 5_000, ..AxisFlow::default() };
        let flow = Flow { engaged: true, fading: false, tick: 5_000, axes: [axis] };
        assert!(node.line.link.say(now, flow, |bytes| said.push(bytes.to_vec())));
        let Participant::Hub(hub) = &mut trial.engine.seats[hub].actor else { panic!("the hub sits last") };
        said.iter_mut().for_each(|bytes| hub.receive(now, 2, bytes, |_, _| {}));
        let news = hub.news(now).join("\n");
        assert!(news.contains("line 3: 2 says what cannot be") && news.contains("wave_integral"), "{news}");
        trial.engine.seats[2].off = true;
        let before = trial.peers().map(|peer| peer.observed().object.position).collect::<Vec<_>>();
        for _ in 0..500 {
            trial.step();
            assert!(trial.hub().junction.motion[0].is_finite());
        }
        for (peer, before) in trial.peers().zip(before) {
            let Motion { position, velocity } = peer.observed().object;
            assert!(peer.peer.is_engaged() && velocity.abs() < 1.0, "{position} m, {velocity} m/s");
            assert!((position - before).abs() < 0.5 && position.is_finite(), "{name}: {position} m, not {before}");
        }
        let device = Plant::new(&trial.scene, 0);
        trial.restart(2, device);
        (0..2_000).for_each(|_| trial.step());
        assert!(trial.peers().all(|peer| peer.peer.is_engaged()));
        let places = || trial.peers().take(2).map(|peer| f64::from(peer.observed().object.position));
        let apart_m = (places().next().unwrap_or(0.0) - places().nth(1).unwrap_or(0.0)).abs();
        assert!(apart_m < 5e-3, "{name}: {apart_m} m apart");
    }
}
