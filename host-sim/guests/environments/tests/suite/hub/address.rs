//! Where a peer is answered: at the address that it has, whoever copies what it says, and wherever it goes.

use cohold_core::safety::Mode;
use cohold_environments::cooperative::hub::Hub;
use cohold_live::node::Node;
use cohold_protocol::{key::Key, link::Notice};

use super::trial::{built_in, key};

/// From 0.3 s on, whatever the first of two peers says comes from somebody else first, who has copied it: he is told nothing, and
/// both hold on.
#[test]
fn a_copy_that_comes_first_takes_no_line_over() {
    const STRANGER: usize = 99;
    let (scene, mut drawn) = (built_in("hub", &["user.1.push_n=0.5".to_owned()]), 0);
    let entropy = || {
        drawn += 1;
        Ok([drawn; Key::LEN])
    };
    let mut hub: Hub<usize> = Hub::new(&scene, 2, &key(), entropy).expect("a hub");
    let node = |number: u8| {
        let line = key().line(number.into());
        <Node>::build(&scene, number, line, [100 + number; Key::LEN]).expect("a peer")
    };
    let (mut nodes, mut copied, mut stolen) = ([node(1), node(2)], 0, 0);
    for tick in 0..2_000_u64 {
        let now = 1_000 * tick;
        let (mut came, mut out) = (vec![], vec![]);
        for (at, node) in nodes.iter_mut().enumerate() {
            let _ = node.tick(now, |bytes| came.push((at, bytes.to_vec())));
        }
        for (from, mut bytes) in came {
            if from == 0 && tick > 300 {
                copied += 1;
                hub.receive(now, STRANGER, &mut bytes.clone(), |to, said| out.push((to, said.to_vec())));
            }
            hub.receive(now, from, &mut bytes, |to, said| out.push((to, said.to_vec())));
        }
        hub.tick(now, |to, said| out.push((to, said.to_vec())));
        for (to, mut bytes) in out {
            match nodes.get_mut(to) {
                Some(node) => _ = node.receive(now, &mut bytes),
                None => stolen += bytes.len(),
            }
        }
    }
    assert!(copied > 200 && stolen == 0, "{stolen} bytes for {copied} copies");
    assert!(nodes.iter().all(|node| node.peer.mode() == Mode::Armed && node.peer.is_engaged()));
    assert!(nodes.iter().all(|node| node.line.lives == 1));
}

/// From 1 s on one of two peers has another address, as behind a router that forgot its own: what goes to the old one is lost. It hears
/// the hub again within 12 packet periods of at least 8 ms, and in the same session.
#[test]
fn a_peer_with_another_address_is_answered_there_within_12_packet_periods() {
    for name in ["any-network", "hub"] {
        let (scene, mut drawn) = (built_in(name, &["user.1.push_n=0.5".to_owned()]), 0);
        let entropy = || {
            drawn += 1;
            Ok([drawn; Key::LEN])
        };
        let mut hub: Hub<usize> = Hub::new(&scene, 2, &key(), entropy).expect("a hub");
        let node = |number: u8| {
            <Node>::build(&scene, number, key().line(number.into()), [100 + number; Key::LEN]).expect("a peer")
        };
        let mut nodes = [node(1), node(2)];
        let (mut heard_us, mut longest_us) = (0, 0);
        for tick in 0..3_000_u64 {
            let now = 1_000 * tick;
            let address = |at: usize| if at == 0 && tick >= 1_000 { 7 } else { at };
            let (mut came, mut out) = (vec![], vec![]);
            for (at, node) in nodes.iter_mut().enumerate() {
                let _ = node.tick(now, |bytes| came.push((address(at), bytes.to_vec())));
            }
            for (from, mut bytes) in came {
                hub.receive(now, from, &mut bytes, |to, said| out.push((to, said.to_vec())));
            }
            hub.tick(now, |to, said| out.push((to, said.to_vec())));
            for (to, mut bytes) in out {
                let Some(at) = (0..2).find(|at| address(*at) == to) else { continue };
                if matches!(nodes[at].receive(now, &mut bytes), Ok(Some(_))) && at == 0 {
                    longest_us = longest_us.max(if tick >= 1_000 { now - heard_us } else { 0 });
                    heard_us = now;
                }
            }
        }
        assert!((48_000..96_000).contains(&longest_us), "{name}: {longest_us} µs");
        assert!(heard_us > 2_980_000, "{name}: {heard_us} µs");
        let (end, _) = hub.lines().next().expect("a line");
        assert_eq!((end.line.lives, nodes[0].line.lives), (1, 1), "{name}");
        let [one, _] = &nodes;
        assert!(one.line.notices.iter().all(|(_, notice)| *notice != Notice::Lost), "{name}: {:?}", one.line.notices);
    }
}
