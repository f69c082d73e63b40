//! Two sealed peers of several shared axes, datagram by datagram in virtual time.

use haptic_core::safety::Mode;
use haptic_protocol::key::Key;
use haptic_protocol::wire::{Flows, Message};
use haptic_sim::Laws;
use haptic_sim::node::Node;
use haptic_sim::run::{AxisOutcome, Options, run};
use haptic_sim::scenes;

/// Where the message begins in a sealed datagram (FORMAT.md), which is opened in place.
const MESSAGE: usize = 32;

/// Runs both for 20 s on a line that takes a tick; every flow that comes is of this kind. Gives F_T of peer 2 and the place of peer 1's
/// device.
fn meet<const N: usize>(mut nodes: [Node<N, N>; 2], kind: u8) -> [[f64; N]; 2]
where
    Flows<N>: Into<Message>,
{
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

/// What two sealed peers come to in the built-in scene is what the run in memory comes to, along every axis.
#[test]
fn sealed_peers_of_several_axes_come_to_what_a_run_comes_to() {
    for (name, kind) in [("plane", 10), ("space", 11)] {
        let scene = scenes::load(Laws::built_in(), name).expect("built in");
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
