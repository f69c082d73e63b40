//! An endpoint that is met somewhere asks its router for a port, over sockets: a router on loopback that speaks PCP, and strangers beside it.

use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use cohold_homes::carried::Meeting;
use cohold_live::batch::ReceivedBatch;
use cohold_live::road::Roads as _;
use cohold_protocol::key::Key;

fn socket() -> (UdpSocket, SocketAddr) {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket on loopback");
    socket.set_nonblocking(true).expect("it does not wait");
    let at = socket.local_addr().expect("an address");
    (socket, at)
}

/// What a router answers to a question in PCP (RFC 6887, 11.1): this outer port of 203.0.113.11 for as long as was asked.
fn answer(question: &[u8], port: u16) -> Vec<u8> {
    assert!(question.len() == 60 && question[..2] == [2, 1], "{question:?}");
    let port = port.to_be_bytes();
    let outer = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 203, 0, 113, 11];
    [&[2, 0x81, 0, 0][..], &question[4..8], &[0; 16], &question[24..42], &port, &outer].concat()
}

#[test]
fn an_end_asks_its_router_for_a_port_believes_nobody_else_and_gives_it_back() {
    let ((router, at), (stranger, _), (_, place)) = (socket(), socket(), socket());
    let meeting = Meeting { place, relay_only: false, mapped: None, router: Some(at) };
    let listen = Some("127.0.0.1:0".parse().expect("an address"));
    let endpoint = meeting.open(listen, Key::new([9; 32]), 0).expect("an endpoint");
    let inner = endpoint.address.port().to_be_bytes();
    let paths = endpoint.road().expect("it is carried");
    let (mut came, mut question, start) = (ReceivedBatch::default(), [0; 256], Instant::now());
    let mut asked = 0;
    while paths.report().mapped.is_none() {
        assert!(start.elapsed() < Duration::from_secs(20), "no port");
        endpoint.take(&mut came).expect("the socket is well");
        if let Ok((length, from)) = router.recv_from(&mut question) {
            let question = &question[..length];
            assert_eq!((&question[20..24], &question[40..42]), (&[127, 0, 0, 1][..], &inner[..]), "its own address");
            asked += 1;
            stranger.send_to(&answer(question, 6666), from).expect("it is sent");
            if asked == 2 {
                router.send_to(&answer(question, 51_000), from).expect("it is sent");
            }
        }
        std::thread::sleep(Duration::from_micros(500));
    }
    assert_eq!(paths.report().mapped, Some("203.0.113.11:51000".parse().expect("an address")));
    drop((endpoint, paths));
    std::thread::sleep(Duration::from_millis(20));
    let (length, _) = router.recv_from(&mut question).expect("it gives the port back");
    assert_eq!((length, &question[4..8]), (60, &[0; 4][..]), "a life of nothing");
}

#[test]
fn who_hides_his_address_asks_no_router() {
    let ((router, at), (_, place)) = (socket(), socket());
    let meeting = Meeting { place, relay_only: true, mapped: None, router: Some(at) };
    let listen = Some("127.0.0.1:0".parse().expect("an address"));
    let endpoint = meeting.open(listen, Key::new([9; 32]), 0).expect("an endpoint");
    let mut came = ReceivedBatch::default();
    for _ in 0..100 {
        endpoint.take(&mut came).expect("the socket is well");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(router.recv_from(&mut [0; 256]).is_err());
}
