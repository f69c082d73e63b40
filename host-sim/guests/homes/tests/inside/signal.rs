//! Signals: what is said is what is heard, and nothing else.

use super::*;

fn said() -> Signal {
    let addresses = vec![(true, "203.0.113.7:4001".parse().unwrap()), (false, "[2001:db8::7]:9".parse().unwrap())];
    let (echo, generation, count) = ([7; 16], 3, 70_000);
    let (sent_us, echo_us, held_us) = (1 << 40, 1 << 41, 1 << 20);
    Signal { hears: true, direct: false, generation, count, sent_us, echo_us, held_us, echo, addresses }
}

#[test]
fn what_is_said_is_heard() {
    let key = Key::new([5; 32]);
    let mut sealer = Sealer::new(&key, 0, [9; 16]);
    for counter in 1..4 {
        assert_eq!(open(&key, 0, &sealer.seal(&said())), Some(([9; 16], counter, said())));
    }
    let full = Signal { addresses: vec![(true, "[::1]:1".parse().unwrap()); 9], ..said() };
    let sealed = sealer.seal(&full);
    assert_eq!(sealed.len(), MOST);
    assert_eq!(open(&key, 0, &sealed).expect("a signal").2.addresses.len(), MOST_ADDRESSES);
}

#[test]
fn no_bit_of_it_can_be_changed() {
    let key = Key::new([5; 32]);
    let sealed = Sealer::new(&key, 0, [9; 16]).seal(&said());
    // The first byte says only that it is one.
    for bit in 8..8 * sealed.len() {
        let mut forged = sealed.clone();
        forged[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(open(&key, 0, &forged), None, "bit {bit}");
    }
    for length in 0..sealed.len() {
        assert_eq!(open(&key, 0, &sealed[..length]), None, "{length} bytes");
    }
    assert_eq!(open(&key, 1, &sealed), None, "its own is none of the other side's");
    assert_eq!(open(&Key::new([6; 32]), 0, &sealed), None, "another key");
}
