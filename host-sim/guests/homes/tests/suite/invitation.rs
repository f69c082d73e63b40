//! A link over sockets: it is used once, and who comes with it again and again fills no terminal.

use std::net::UdpSocket;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use cohold_homes::Error;
use cohold_homes::agreement::{Accepter, Inviter};
use cohold_homes::invitation::{accept, invite};
use cohold_homes::meet::Meet;
use cohold_live::endpoint::Stop;
use cohold_protocol::key::Key;

#[test]
fn a_used_link_that_is_used_300_times_more_causes_one_line() {
    let meet = Meet::open("127.0.0.1:0".parse().expect("an address")).expect("a socket");
    let inviter = Inviter::new(&meet.address().to_string(), &Key::new([1; 32]), Instant::now());
    let (link, stop, lines) = (inviter.invite.clone(), Stop::default(), Arc::new(Mutex::new(Vec::new())));
    std::thread::scope(|scope| {
        scope.spawn(|| meet.run(60.0, &stop));
        let said = Arc::clone(&lines);
        let say = move |words: &str| said.lock().expect("it is free").push(words.to_owned());
        let invites = scope.spawn(|| invite(inviter, &stop, say));
        let key = accept(&link, &stop).expect("a key");
        assert_eq!(invites.join().expect("it ends").expect("a key"), key);
        let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        socket.connect(meet.address()).expect("it is on loopback");
        socket.set_read_timeout(Some(Duration::from_millis(5))).expect("a timeout");
        let (mut seat, thief) = (link.seat(1, &Key::new([5; 32])), Accepter::new(&link, &Key::new([6; 32])));
        let (mut refused, mut bytes, start) = (0, [0; 256], Instant::now());
        while refused < 300 {
            let now = Instant::now();
            assert!(start.elapsed() < Duration::from_secs(30), "refused {refused} times");
            seat.poll(now, false).map(|join| socket.send(&join));
            if seat.other_is_there(now) {
                socket.send(&thief.offer()).expect("it is sent");
            }
            if let Ok(length) = socket.recv(&mut bytes) {
                let came = &bytes[..length];
                refused += u32::from(thief.hear(came) == Err(Error::Used));
                seat.hear(now, came);
            }
        }
        assert_eq!(lines.lock().expect("it is free").len(), 1);
        stop.ask();
    });
}
