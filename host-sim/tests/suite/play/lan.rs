//! `play --lan`, as a user starts it, on loopback: a page for a visitor's phone, beside that of this machine.

use super::Play;
use super::socket::Socket;
use crate::program::cohold;

/// What is printed: addresses of this machine, then of the network, which hold one hand and watch, and a code. Each holds what it says at the
/// door it is for, and none opens the operator's role from the network.
#[test]
fn the_network_gets_a_hand_a_place_to_watch_and_a_code() {
    let play = Play::start(&["--lan", "127.0.0.1", "--environment", "bad-network"]);
    let [both, hand1, hand2, operator, watch, phone, onlooker] = &play.addresses[..] else {
        panic!("{:?}", play.addresses)
    };
    let parts = |address: &str| {
        address.split_once("/#").map(|(host, ring)| (host.to_owned(), ring.to_owned())).expect("a ring")
    };
    let ((here, _), (network, ring)) = (parts(hand2), parts(phone));
    assert!(here != network && parts(onlooker).0 == network, "{:?}", play.addresses);
    assert_eq!([&ring, &parts(onlooker).1], [&parts(hand2).1, &parts(watch).1]);
    for address in [hand1, hand2, operator, watch, phone, onlooker] {
        assert!(Socket::open(address).is_some(), "{address}");
    }
    for orders in [both, operator] {
        assert!(Socket::open(&format!("{network}/#{}", parts(orders).1)).is_none(), "an operator from the network");
    }
    // The operator is told how the phone comes in, and who is there.
    let join = Socket::open(operator).expect("it is let in").told("join");
    assert_eq!((join["address"].as_str(), join["hand"].as_u64()), (Some(phone.as_str()), Some(2)));
    let mut visitor = Socket::open(phone).expect("it is let in");
    visitor.points(0.02);
    for order in ["cut", "set network.loss=0.5", "start", "show pair"] {
        visitor.say(order);
        visitor.points(0.02);
        assert_eq!(visitor.told("refused"), "only the operator's address may order that", "{order}");
    }
}

/// In one line each: what is no address of this machine, or all of them, or not to be chosen.
#[test]
fn what_cannot_be_served_is_refused_in_a_line() {
    for (arguments, says) in [
        (&["--lan", "0.0.0.0"][..], "--lan 0.0.0.0 would be every network of this machine"),
        (&["--lan", "198.51.100.7"], "--lan 198.51.100.7 is no address of this machine"),
        (&["--lan", "::1"], "--lan ::1 is not allowed: invalid IPv4 address"),
        (&["--lan", "127.0.0.1", "--board", "simulated"], "cannot be used with"),
    ] {
        let output = cohold(&["play", "--seconds", "1"]).args(arguments).output().expect("cohold runs");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && error.contains(says) && !error.contains("http://"), "{error}");
    }
}
