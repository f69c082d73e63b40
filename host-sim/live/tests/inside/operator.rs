use std::net::UdpSocket;
use std::os::fd::OwnedFd;

use cohold_protocol::key::Key;

use super::*;

/// Why: a stop that a socket kept back named the socket, and nothing to press.
#[test]
fn a_stop_that_the_socket_keeps_back_says_what_to_press() {
    let mut endpoint = Endpoint::answering("127.0.0.1:0".parse().unwrap()).unwrap();
    endpoint.socket = UdpSocket::from(OwnedFd::from(std::fs::File::open("/dev/null").unwrap()));
    let session = Session::new(Key::new([7; Key::LEN]), 1, [9; Key::LEN]).unwrap();
    let board = endpoint.address;
    let mut operator = Operator { endpoint, board, number: 1, session, stop: Stop::default() };
    let why = operator.stop().unwrap_err().to_string();
    assert!(why.starts_with("the socket on ") && why.ends_with(&format!("; {UNCONFIRMED}")), "{why}");
}
