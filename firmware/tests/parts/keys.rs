//! A board takes two keys or none, and whoever holds one has nothing of the other.

use cohold_protocol::ends::Ends;
use cohold_protocol::key::{Key, Role};
use cohold_protocol::link::{Config, Link};
use cohold_protocol::parameters::Parameters;
use cohold_protocol::wire::{MAX_DATAGRAM, PeerId};
use firmware_parts::keys::{Keyless, Keys, WORDS};
use firmware_parts::store::Word;

const PEERS: [u8; 32] = [7; 32];
const OPERATOR: [u8; 32] = [8; 32];

/// What flash holds: the first words of the sector, and behind them nothing.
fn flash(images: &[[u8; Key::IMAGE]]) -> Vec<Word> {
    let mut words: Vec<Word> = images.concat().as_chunks().0.to_vec();
    words.resize(8, [0xFF; 32]);
    words
}

fn read(words: &[Word]) -> Result<Keys, Keyless> {
    Keys::read(|at| words.get(at as usize).copied())
}

fn provisioned(peers: [u8; 32], operator: [u8; 32]) -> Vec<Word> {
    flash(&[Key::new(peers).image(Role::Peers), Key::new(operator).image(Role::Operator)])
}

#[test]
fn a_board_takes_both_keys_or_none() {
    let keys = read(&provisioned(PEERS, OPERATOR)).expect("two keys");
    assert_eq!((keys.peers, keys.operator), (Key::new(PEERS), Key::new(OPERATOR)));
    let [peers, operator] = [Role::Peers, Role::Operator].map(|role| Key::new(PEERS).image(role));
    // As versions before wrote it, and counted starts behind it.
    let mut single = flash(&[peers]);
    single[0][..8].copy_from_slice(b"haptkey1");
    single[2] = [0; 32];
    for (what, words, why) in [
        ("never written", flash(&[]), Keyless::NoPeers),
        ("one key, of a version before", single, Keyless::Single),
        ("the operator's is missing", flash(&[peers]), Keyless::NoOperator),
        ("the peers' is missing", flash(&[[0xFF; 64], operator]), Keyless::NoPeers),
        ("the peers' twice", flash(&[peers, peers]), Keyless::NoOperator),
        ("the other way round", flash(&[operator, peers]), Keyless::NoPeers),
        ("both the same", provisioned(PEERS, PEERS), Keyless::Same),
        ("the peers' is zero", provisioned([0; 32], OPERATOR), Keyless::NoPeers),
        ("the operator's is zero", provisioned(PEERS, [0; 32]), Keyless::NoOperator),
    ] {
        assert_eq!(read(&words).err(), Some(why), "{what}");
    }
    for at in 0..WORDS as usize {
        for byte in 0..size_of::<Word>() {
            let mut words = provisioned(PEERS, OPERATOR);
            words[at][byte] ^= 1;
            assert!(read(&words).is_err(), "byte {byte} of word {at}");
        }
        let lost = |word: u32| (word as usize != at).then(|| provisioned(PEERS, OPERATOR)[word as usize]);
        assert!(Keys::read(lost).is_err(), "word {at} is lost");
    }
}

/// The operator's port of board 1 and somebody who calls it as its operator: whether the two meet, and the most datagrams that the
/// board sends.
fn call(port: &Key, caller: &Key) -> (bool, usize) {
    let link = |key: &Key, local, remote, entropy| {
        let ends = Ends { local: PeerId(local), remote: PeerId(remote) };
        let parameters = Parameters::new();
        Link::new(Config { key: key.clone(), ends, packet_period_us: 20_000, parameters, entropy }).expect("sound")
    };
    let (mut board, mut operator) = (link(port, 1, 0, [1; 32]), link(caller, 0, 1, [2; 32]));
    let (mut out, mut said) = ([0; MAX_DATAGRAM], 0);
    for now in (0..2_000_000).step_by(10_000) {
        while let Some(length) = operator.poll(now, &mut out) {
            // A board answers nobody that it has never heard.
            if board.receive(now, &mut out[..length]).is_ok() {
                while let Some(length) = board.poll(now, &mut out) {
                    said += 1;
                    let _ = operator.receive(now, &mut out[..length]);
                }
            }
        }
    }
    assert_eq!(board.is_up(), operator.is_up());
    (board.is_up(), said)
}

#[test]
fn no_key_of_peers_or_of_a_hub_opens_the_operators_port() {
    // A board on line 2 of a hub.
    let hub = Key::new([9; 32]);
    let words = flash(&[hub.line(2).image(Role::Peers), Key::new(OPERATOR).image(Role::Operator)]);
    let keys = read(&words).expect("two keys");
    let (meets, said) = call(&keys.operator, &keys.operator);
    assert!(meets && said > 0, "its operator is answered");
    for (who, key) in [("who is on its line", &keys.peers), ("the owner of the hub", &hub)] {
        assert_eq!(call(&keys.operator, key), (false, 0), "{who}");
    }
    assert!((0..=4096).all(|line| hub.line(line) != keys.operator && keys.peers.line(line) != keys.operator));
}
