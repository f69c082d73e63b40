//! Two sealed peers of several shared axes, datagram by datagram in virtual time.

use std::path::Path;

use cohold_core::safety::Mode;
use cohold_live::node::Node;
use cohold_live::start::AFTER_US;
use cohold_protocol::key::Key;
use cohold_sim::Laws;
use cohold_sim::run::{AxisOutcome, Options, run};
use cohold_sim::scene::Scene;
use cohold_sim::scenes;

/// Where the message begins in a sealed datagram (FORMAT.md), which is opened in place.
const MESSAGE: usize = 32;

/// Runs both for 20 s on a line that takes a tick; every flow that comes is of this kind. Gives F_T of peer 2 and the place of peer 1's
/// device.
fn meet<const N: usize>(mut nodes: [Node<N, N>; 2], kind: u8) -> [[f64; N]; 2] {
    let mut under_way = [const { Vec::<Vec<u8>>::new() }; 2];
    let mut flows = 0;
    for tick in 1..=20_000 {
        let now_us = 1_000 * tick;
        for (node, came) in nodes.iter_mut().zip(&mut under_way) {
            for mut datagram in came.drain(..) {
                if let Ok(Some(_)) = node.receive(now_us, &mut datagram) {
                    assert_eq!(datagram[MESSAGE], kind, "the kind of a flow of {N} axes");
                    flows += 1;
                }
            }
        }
        for (from, node) in nodes.iter_mut().enumerate() {
            node.tick(now_us, |bytes| under_way[1 - from].push(bytes.to_vec()));
        }
    }
    assert!(flows > 39_000 && nodes.iter().all(|node| node.peer.mode() == Mode::Armed), "{flows} flows");
    let [one, two] = nodes.each_ref().map(|node| node.peer.observed());
    [two.map(|seen| seen.coordination_force.into()), one.map(|seen| seen.device.position.into())]
}

/// What two sealed peers come to in the built-in scene is what the run in memory comes to, along every axis; read and driven exactly, since two
/// runs through encoders end a count apart.
#[test]
fn sealed_peers_of_several_axes_come_to_what_a_run_comes_to() {
    for (name, kind) in [("plane", 10), ("space", 11)] {
        let mut scene = scenes::load(Laws::built_in(), name).expect("built in");
        for key in ["plant.encoder=false", "plant.motor=false", "plant.winding=false", "axis.velocity=measured"] {
            scene.apply_override(key).expect("a good key");
        }
        let run = run::<f32>(&scene, Options { duration_s: 20.0, record_every: 1000 }, &|_| ());
        let run = run.expect("a good scene");
        let end = |column: &str| -> Vec<f64> {
            let last = |of: &AxisOutcome| *of.table.column(column).expect("recorded").last().expect("rows");
            run.axes.iter().map(last).collect()
        };
        let key = |number: u8| (number, Key::new([0x5a; Key::LEN]), [number; Key::LEN]);
        let [forces, places] = match kind {
            10 => meet(
                [1, 2]
                    .map(key)
                    .map(|(number, key, entropy)| Node::<2, 2>::build(&scene, number, key, entropy).expect("a peer")),
                kind,
            )
            .map(|each| each.to_vec()),
            _ => meet(
                [1, 2]
                    .map(key)
                    .map(|(number, key, entropy)| Node::<3, 3>::build(&scene, number, key, entropy).expect("a peer")),
                kind,
            )
            .map(|each| each.to_vec()),
        };
        for (came, wanted) in [(forces, end("coordination_2_n")), (places, end("device_1_m"))] {
            for (came, wanted) in came.iter().zip(wanted) {
                assert!((came / wanted - 1.0).abs() < 1e-3, "{name}: {came}, not {wanted}");
            }
        }
    }
}

/// Both push toward each other with 1 N for 30 s from `from_s` on, on the recommended scene, through a line of so long, s.
fn pushing(from_s: f64, delay_s: f64) -> Scene {
    let mut scene = scenes::load(Laws::built_in(), "any-network").expect("built in");
    scene.users = Default::default();
    // Tests run side by side, and each has its own.
    let own = format!("pushing-{from_s}-{:?}.csv", std::thread::current().id());
    let trace = Path::new(env!("CARGO_TARGET_TMPDIR")).join(own);
    let (up_s, until_s) = (from_s + 0.001, from_s + 30.0);
    let rows = format!("0,0\n{from_s},0\n{up_s},1\n{until_s},1\n{},0\n100,0\n", until_s + 0.001);
    std::fs::write(&trace, format!("time_s,force_n\n{rows}")).expect("a trace");
    let traces = ["1", "2"].map(|user| format!("user.{user}.trace={}", trace.display()));
    let delay = format!("network.extra_delay_s={delay_s}");
    // A line that may weigh what it does, and takes nothing back: how far apart copies are says how long it is, and a lighter one's that squared.
    let own = ["coordination.most_line_mass_kg=0", "coordination.tautness=0"];
    for key in
        ["safety.max_delay_s=1", "network.one_way_delay_packets=0", own[0], own[1], &delay, &traces[0], &traces[1]]
    {
        scene.apply_override(key).expect("a good override");
    }
    scene.check("the test").expect("a good scene");
    scene
}

/// What two sealed peers come to: distance of their copies at the most, while both have long pushed, and at the end, m; and when each
/// began, µs.
#[derive(Debug)]
struct Met {
    largest_m: f64,
    held_m: f64,
    last_m: f64,
    began_us: [u64; 2],
}

/// How long both move, ticks, and when they have long pushed.
const MOVED: u64 = 60_000;
const HELD: u64 = 29_900;

/// Two sealed peers whose datagrams are delayed as `delay_us` says of the way from the first (0) or the second (1) and the time, until both
/// have moved for [`MOVED`]. Nobody moves before both ends are whole.
fn push(scene: &Scene, after_us: u64, delay_us: impl Fn(usize, u64) -> u64) -> Met {
    let node = |number: u8| {
        let node = Node::<1, 2>::build(scene, number, Key::new([0x5a; Key::LEN]), [number; Key::LEN]).expect("a peer");
        node.beginning_after(after_us)
    };
    let mut nodes = [node(1), node(2)];
    let mut under_way = [const { Vec::<(u64, Vec<u8>)>::new() }; 2];
    let mut met = Met { largest_m: 0.0, held_m: 0.0, last_m: 0.0, began_us: [0; 2] };
    let place = |node: &Node<1, 2>| f64::from(node.observed().object.position);
    for tick in 1..=2 * MOVED {
        let now_us = 1_000 * tick;
        for (node, came) in nodes.iter_mut().zip(&mut under_way) {
            came.sort_by_key(|(due_us, _)| *due_us);
            while came.first().is_some_and(|(due_us, _)| *due_us <= now_us) {
                let _ = node.receive(now_us, &mut came.remove(0).1);
            }
        }
        for (from, node) in nodes.iter_mut().enumerate() {
            let due_us = now_us + delay_us(from, now_us).max(1);
            node.tick(now_us, |bytes| under_way[1 - from].push((due_us, bytes.to_vec())));
        }
        let began = nodes.each_ref().map(|node| node.armed_ticks > 0);
        if began != [false; 2] && met.began_us == [0; 2] {
            assert!(nodes.iter().all(|node| node.peer.is_engaged()), "one moves before both ends are live");
        }
        for (at_us, _) in met.began_us.iter_mut().zip(began).filter(|(at_us, began)| **at_us == 0 && *began) {
            *at_us = now_us;
        }
        if nodes.iter().all(|node| node.armed_ticks >= MOVED) {
            break;
        }
        if nodes.iter().all(|node| node.peer.mode() == Mode::Armed) {
            met.last_m = (place(&nodes[0]) - place(&nodes[1])).abs();
            met.largest_m = met.largest_m.max(met.last_m);
            if nodes[0].armed_ticks == HELD {
                met.held_m = met.last_m;
            }
        }
    }
    assert!(nodes.iter().all(|node| node.peer.mode() == Mode::Armed && node.armed_ticks > 0), "they did not begin");
    met
}

/// The same distances of the run in memory, m, whose users push when its line has long been live.
fn in_memory(delay_s: f64) -> [f64; 3] {
    let run =
        run::<f32>(&pushing(3.0, delay_s), Options { duration_s: 3.0 + 1e-3 * MOVED as f64, record_every: 1 }, &|_| ());
    let run = run.expect("a good scene");
    let [one, two] = ["object_1_m", "object_2_m"].map(|name| run.axes[0].table.column(name).expect("recorded"));
    let apart: Vec<f64> = one.iter().zip(two).map(|(one, two)| (one - two).abs()).collect();
    let [.., last] = apart[..] else { panic!("no rows") };
    [apart.iter().copied().fold(0.0, f64::max), apart[3_000 + HELD as usize], last]
}

/// From no delay to the longest that a session bears the copies are as far apart as in the run in memory, at the most and at the end.
#[test]
fn a_start_under_delay_is_the_start_in_memory() {
    for delay_ms in [1, 25, 50, 120, 240, 450] {
        let delay_s = 1e-3 * delay_ms as f64;
        let [largest_m, held_m, last_m] = in_memory(delay_s);
        let met = push(&pushing(0.001, delay_s), AFTER_US, |_, _| 1_000 * delay_ms);
        println!("{delay_ms} ms: {largest_m} m, {held_m} m, {last_m} m in memory: {met:?}");
        assert!((met.held_m - held_m).abs() < 0.05 * held_m + 2e-4, "{delay_ms} ms: {met:?}, not {held_m} m");
        assert!((met.last_m - last_m).abs() < 1e-4, "{delay_ms} ms: {met:?}, not {last_m} m");
        // Where the line is when they begin makes it less; and while it learns a long delay its ends stand and carry on by what they
        // hear, which comes at other times: 1.8 times as far over 450 ms, 0.7 times over 240.
        assert!(met.largest_m < 1.9 * largest_m + 2e-4, "{delay_ms} ms: {met:?}, not {largest_m} m");
        // By a clock that both know, but for what lies between two packets.
        let [one, two] = met.began_us;
        assert!(one.abs_diff(two) <= 2_000, "{delay_ms} ms: {met:?}");
    }
}

/// The delay is another while they start than after it, or keeps changing: that is gone in the end, whichever way it was.
#[test]
fn a_delay_that_changes_while_starting_leaves_nothing() {
    type Delay = fn(usize, u64) -> u64;
    let delays: [(&str, Delay); 5] =
        [
            ("the first 2.5 s by 200 ms", |_, now_us| if now_us < 2_500_000 { 210_000 } else { 10_000 }),
            ("one way only", |from, now_us| if from == 0 && now_us < 2_500_000 { 210_000 } else { 10_000 }),
            ("from the first second on, for two", |_, now_us| {
                if (1_000_000..3_000_000).contains(&now_us) { 210_000 } else { 10_000 }
            }),
            ("less and less", |_, now_us| 10_000 + 300_000_u64.saturating_sub(now_us / 10)),
            ("to and fro", |from, now_us| {
                if now_us < 3_000_000 { 10_000 + 1_000 * ((now_us / 16_000 + from as u64) % 13) * 12 } else { 10_000 }
            }),
        ];
    for after_us in [0, AFTER_US] {
        for (name, delay_us) in delays {
            let met = push(&pushing(0.001, 0.01), after_us, delay_us);
            println!("{name}, {after_us} µs: {met:?}");
            // While they push a line that was longer once keeps some of that; when they let go, nothing is left.
            assert!(met.held_m < 3e-3 && met.last_m < 1e-4, "{name}: {met:?}");
        }
    }
}
